"""Nothing is lost: presses wait, values are overtaken by newer ones of the same widget only."""

from hypothesis import given
from hypothesis import strategies as some

from workbench.web.page.messages import CommandTriggerMessage, GuiUpdateMessage, Updates, is_press
from workbench.web.page.rate_limit import AT_ONCE, MOST_WAITING, RateLimit


def value(widget, number):
    return GuiUpdateMessage(widget, Updates(number))


PRESS = CommandTriggerMessage("save")


def all_at(limit, now):
    """What goes out at a time."""
    found = []
    while (message := limit.ready(now)) is not None:
        found.append(message)
    return found


def slow():
    """After what may come at once, one a second."""
    limit = RateLimit(0.0, per_second=1.0, at_once=1)
    assert limit.add(PRESS)
    assert all_at(limit, 0.0) == [PRESS]
    return limit


def test_a_hand_is_not_held_up():
    limit = RateLimit(0.0)
    for number in range(AT_ONCE):
        assert limit.add(value("a", number))
        assert limit.ready(0.0) == value("a", number)


def test_of_values_that_wait_the_newest_goes():
    limit = slow()
    for number in range(1000):
        assert limit.add(value("a", number))
    assert len(limit) == 1
    assert all_at(limit, 10.0) == [value("a", 999)]


def test_a_value_does_not_pass_a_press():
    limit = slow()
    typed = [value("text", "r"), value("text", "rim"), PRESS, value("text", "next")]
    for message in typed:
        assert limit.add(message)
    found = [limit.ready(float(second)) for second in range(1, 4)]
    assert found == [value("text", "rim"), PRESS, value("text", "next")]


def test_it_says_how_long_to_wait():
    limit = slow()
    limit.add(PRESS)
    assert limit.ready(0.25) is None
    assert limit.patience() == 0.75
    assert limit.ready(1.0) == PRESS


def test_too_many_presses_are_refused_and_so_are_too_many_widgets():
    for message in (lambda n: PRESS, lambda n: value(str(n), 1)):
        limit = slow()
        taken = [limit.add(message(number)) for number in range(MOST_WAITING + 1)]
        assert taken == [True] * MOST_WAITING + [False]


widgets = some.sampled_from("abc")
steps = some.lists(
    some.one_of(
        some.builds(value, widgets, some.integers(0, 99)),
        some.just(PRESS),
        some.floats(0.0, 0.2),
    ),
    max_size=120,
)


@given(steps)
def test_presses_and_newest_values_always_arrive_in_order(steps):
    limit, now, said, heard = RateLimit(0.0, per_second=20.0, at_once=3), 0.0, [], []
    for step in steps:
        if isinstance(step, float):
            now += step
        else:
            said.append(step)
            assert limit.add(step)
        heard += all_at(limit, now)
    for _ in range(len(said) + 1):
        now += 1.0
        heard += all_at(limit, now)
    assert [one for one in heard if is_press(one)] == [one for one in said if is_press(one)]
    # Between two presses the last value of each widget is the last that was given.
    assert newest(heard) == newest(said)


def newest(messages):
    found, since = [], {}
    for message in messages:
        if is_press(message):
            found.append(since)
            since = {}
        else:
            since[message.uuid] = message.updates.value
    return [*found, since]
