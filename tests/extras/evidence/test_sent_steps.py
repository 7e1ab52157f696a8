"""What went to the robot is what was approved in speed and steps, or it is found."""

import pytest

from workbench.extras.evidence.steps import step_problems

WAYS = {"reach": [0.0, 0.4, 1.0004], "home": [0.0, 0.123]}


def entries(share=1.0, sent_at=1.0, *, is_stepped=False, ticket="", presses=(), words=()):
    """A session: its plan, sent at `sent_at` of the speed by an approval of `share`."""
    arms = [{"arm": "right", "legs": [{"name": name, "t": t} for name, t in WAYS.items()]}]
    sequence = [{"runs": [["right", name]]} for name in WAYS]
    plan = {"plan": {"plan": {"arms": arms, "sequence": sequence}}}
    approval = {}
    if share < 1.0:
        approval["speed_share"] = share
    if is_stepped:
        approval["is_stepped"] = True
    sent = [("ticket", f"0003 ticket {'a' * 16} 002 003{ticket}")]
    for t in WAYS.values():
        for k in range(1, len(t)):
            sent.append(("to", f"0004 to 001 1.00 {(t[k] - t[k - 1]) / sent_at * 1000:05.0f}"))
    found = [("JobEnded", {"command": {"result": plan}}), ("SendPlan", {"approval": approval})]
    found += [("NextStep", {"command": {"number": number}}) for number in presses]
    sent += [("next", f"0099 next {number:02d}") for number in words]
    found += [("Sent", {"command": {"receipt": {"kind": k, "sent": s}}}) for k, s in sent]
    return [(number, kind, body) for number, (kind, body) in enumerate(found, 1)]


@pytest.mark.parametrize("share", [1.0, 0.5, 0.25, 0.1])
def test_the_wire_has_the_times_of_the_plan_at_the_share_approved(share):
    assert list(step_problems(entries(share, share))) == []
    for other in {1.0, 0.5, 0.25, 0.1} - {share}:
        assert len(list(step_problems(entries(share, other)))) == 3


@pytest.mark.parametrize(
    ("presses", "words", "says"),
    [
        ((1, 2), (1, 2), ""),
        ((1,), (1, 2), "a step that nobody has let run"),
        ((1, 2), (1, 1), "a step that nobody has let run"),
        ((2,), (), "that was not to run then"),
        ((1, 1), (1,), "that was not to run then"),
    ],
)
def test_each_step_has_its_press(presses, words, says):
    told = entries(is_stepped=True, ticket=" stepped", presses=presses, words=words)
    found = list(step_problems(told))
    assert (says in "; ".join(found)) if says else found == []


@pytest.mark.parametrize(("is_stepped", "ticket"), [(True, ""), (False, " stepped")])
def test_another_manner_than_the_one_approved_is_found(is_stepped, ticket):
    (found,) = step_problems(entries(is_stepped=is_stepped, ticket=ticket))
    assert found == "entry 3 is another manner of sending than the one approved"


def test_a_press_in_a_plan_that_is_sent_in_one_go_is_found():
    assert len(list(step_problems(entries(presses=(1,))))) == 1
