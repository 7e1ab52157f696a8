"""What is said of a filled library: how much comes out, why the rest stays, what would take it."""

from workbench.app.filling.fill import Filled
from workbench.app.filling.words import filled_words


def told(**changes):
    """The sentences about a filling in which ten parts lay."""
    values = {"stays": (), "lifts": 1, "looked": 0, "helps": ()} | changes
    return filled_words(Filled((), (), 10, 4, seconds=50.0, **values))


def test_what_stays_is_said_with_its_reasons():
    assert len(told()) == 1
    assert told(stays=(("tool collision", 6),))[1].endswith("6 tool collision")


def test_more_lifts_are_proposed_only_where_there_is_one_and_a_lift_is_blocked():
    blocked = (("extract blocked", 6),)
    assert 'emptying = "thorough"' in told(stays=blocked)[-1]
    assert 'emptying = "thorough"' not in " ".join(told(stays=blocked, lifts=6))
    assert 'emptying = "thorough"' not in " ".join(told(stays=(("tool collision", 6),)))


def test_a_tool_or_bin_that_would_take_the_rest_is_named():
    stays = (("tool collision", 6),)
    said = told(stays=stays, looked=6, helps=(("fingers 1 mm thinner", 5),))
    assert "it would at 5 with fingers 1 mm thinner" in said[-1]
    assert "also with thinner fingers" in told(stays=stays, looked=6)[-1]
