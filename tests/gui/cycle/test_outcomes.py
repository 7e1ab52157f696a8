"""What became of the parts: a reason belongs to the failure that it was typed for."""

from dataclasses import replace

import pytest

from workbench.app.core.commands import ReportPick
from workbench.gui.cycle.outcomes import OutcomeInputs


@pytest.fixture
def inputs(visitor, states, monkeypatch):
    """After a plan was sent, with a reason typed; everything that is said is taken."""
    inputs = OutcomeInputs(visitor, "")
    inputs._why.value = "slipped"
    given = inputs.given = []
    monkeypatch.setattr(type(visitor.bench), "state", property(lambda _: states.done))
    monkeypatch.setattr(visitor, "give", lambda command, name="": given.append(command))
    return inputs


def press(button):
    for called in button._impl.update_cb:
        called(None)


def test_why_a_pick_failed_is_said_of_that_pick_alone(inputs, states):
    (first, second), rows = [one.arm for one in states.done.plan.arms], inputs._rows
    press(rows[first][2])
    press(rows[second][2])
    assert [type(one) for one in inputs.given] == [ReportPick, ReportPick]
    assert [one.why for one in inputs.given] == ["slipped", ""]
    assert inputs._why.value == ""


def test_what_was_refused_keeps_its_reason(inputs, visitor, states, monkeypatch):
    monkeypatch.setattr(visitor, "ask", lambda command: False)
    press(inputs._rows[states.done.plan.arms[0].arm][2])
    assert inputs._why.value == "slipped"


def test_a_new_scan_asks_for_new_reasons(inputs, states, view_of):
    done = view_of(states.done)
    inputs.show(done, view_of(replace(states.done, message="told")))
    assert inputs._why.value == "slipped"
    inputs.show(done, view_of(replace(states.scanned, scan=replace(states.scanned.scan))))
    assert inputs._why.value == ""
