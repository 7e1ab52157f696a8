"""What is said of a filled library: how much comes out, why the rest stays, what would take it."""

import pinocchio as pin

from workbench.app.filling.fill import Filled
from workbench.app.filling.for_remaining import Proposal
from workbench.app.filling.words import filled_words, proposal_words
from workbench.model.candidate import Reason
from workbench.model.messages.changes import ChangeText, FillText
from workbench.model.part import Grasp
from workbench.words.words import words_of

COLLISION = (Reason.TOOL_COLLISION.message, 6)
BLOCKED = (Reason.EXTRACT_BLOCKED.message, 6)


def told(**changes):
    """The messages about a filling in which ten parts lay."""
    values = {"stays": (), "lifts": 1, "looked": 0, "helps": ()} | changes
    return filled_words(Filled((), (), 10, 4, seconds=50.0, **values))


def test_what_stays_is_said_with_its_reasons():
    assert len(told()) == 1
    assert str(told(stays=(COLLISION,))[1]).endswith("6 tool in collision")


def test_more_lifts_are_proposed_only_where_there_is_one_and_a_lift_is_blocked():
    def proposes(**changes):
        return any(message.text is FillText.MORE_LIFTS for message in told(**changes))

    assert proposes(stays=(BLOCKED,))
    assert not proposes(stays=(BLOCKED,), lifts=6)
    assert not proposes(stays=(COLLISION,))


def test_a_tool_or_bin_that_would_take_the_rest_is_named():
    helps = ((ChangeText.FINGERS_THINNER(by=0.001), 5),)
    said = told(stays=(COLLISION,), looked=6, helps=helps)
    assert "5 with fingers 1 mm thinner" in str(said[-1])
    assert "nor with thinner fingers" in str(told(stays=(COLLISION,), looked=6)[-1])


def test_a_german_page_says_it_in_german():
    helps = ((ChangeText.FINGERS_THINNER(by=0.001), 5),)
    german = [words_of("de").render(message) for message in told(stays=(BLOCKED,), looked=6)]
    german.append(words_of("de").render(told(looked=6, helps=helps)[-1]))
    assert not any(word in " ".join(german) for word in ("parts", "lift", "fits", "thinner"))
    assert "1 mm" in german[-1]


def test_a_proposal_says_what_the_library_and_the_new_grasps_take():
    entries = (Grasp("edge", pin.SE3.Identity(), 0.04, 0.03),)
    known, added = proposal_words("peg", Proposal(entries, 9, 2, 6))
    assert str(known).startswith("2 of 9 peg") and str(added).endswith("new grasps: edge")
    (none,) = proposal_words("peg", Proposal((), 9, 0, 0))
    assert str(none).startswith("no grasp of the tools takes the 9 peg")
    assert "9 liegengebliebenen peg" in words_of("de").render(none)
