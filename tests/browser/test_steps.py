"""A plan run step by step, by pressing, with a robot controller in a process of its own."""

import re
from functools import partial

import numpy as np
import pytest
from playwright.sync_api import expect
from test_page import run_to_plan, seen

from workbench.app.core.cycle.sending import NextStep
from workbench.app.records.replay import replay
from workbench.journal.journal import Journal

NEAR = 0.0005
"""[rad] Programs are sent in hundredths of a degree."""


@pytest.fixture
def stepping(screen, bench, robot, reaches, wait):
    """A plan approved in the dialog, step by step at half its speed, and on its way."""
    state = run_to_plan(screen, reaches)
    seen(bench)
    screen.press("Approve")
    dialog = screen.page.get_by_role("dialog")
    dialog.locator("input").first.press_sequentially("Anna", delay=100)
    screen.button("Approve as Anna").wait_for()
    dialog.locator("input[type=checkbox]").check()
    screen.button("Approve as Anna, step by step").wait_for()
    dialog.locator("input").nth(1).click()
    screen.page.get_by_role("option", name="50%").click()
    screen.button("Approve as Anna, at 50% of the planned speed, step by step").wait_for()
    screen.shoot("s1-approval")
    screen.press("Approve as Anna, at 50% of the planned speed, step by step")
    approval = reaches("approved").approval
    assert approval.manner == (0.5, True)
    screen.wait_for("at 50% of the planned speed, step by step")
    screen.press("Send")
    wait(lambda: bench.state.waits == 1, "the robot to wait")
    return state.plan


def ends_of(cell, plan, number):
    """Where each joint [rad] is when the robot waits before a step."""
    q = {arm.name: arm.home for arm in cell.arms}
    for step in plan.sequence[: number - 1]:
        q |= {arm: plan.arm(arm).leg(leg).q[-1] for arm, leg in step.runs}
    return cell.joint_values(q)


def stands(bench, there):
    """Whether the robot has reported that it is there: reports come a moment later."""
    joints = bench.live.joints
    return all(abs(joints.get(name, np.inf) - value) < NEAR for name, value in there.items())


def label(plan, number):
    return f"Run step {number} of {len(plan.sequence)}: {plan.sequence[number - 1].words}"


def test_every_step_waits_for_a_press_that_counts_once(
    screen, bench, robot, reaches, wait, stepping, tmp_path
):
    steps = len(stepping.sequence)
    for number in range(1, steps + 1):
        screen.button(label(stepping, number)).wait_for()
        screen.wait_for(f"waits before step {number} of {steps}")
        if number == 3:
            waits = screen.page.locator('.wb-mode[data-mode="waits"]')
            expect(waits).to_contain_text("Ends with Run step 3, or Stop")
            screen.shoot("s2-waiting")
        wait(partial(stands, bench, ends_of(bench.cell, stepping, number)), "the robot to stand")
        before = bench.live.joints
        screen.page.wait_for_timeout(300)
        assert bench.live.joints == before and bench.state.waits == number
        if number == 2:
            # Two presses at once: the second is for a step that runs already.
            screen.button(label(stepping, number)).dblclick()
        else:
            screen.press(label(stepping, number))
        wait(lambda: bench.state.let == number, "the step to run")  # noqa: B023
        wait(lambda: bench.state.waits or bench.state.phase == "done", "the next step")
        assert bench.state.let == number
        if number < steps:
            assert bench.state.waits == number + 1
    done = reaches("done")
    assert done.parts_placed == 2
    expect(screen.button("Send")).to_be_visible()
    expect(screen.page.get_by_role("button", name=re.compile("^Run step"))).to_have_count(0)
    bench.close()
    presses = [
        (entry.command.number, entry.actor)
        for entry, _ in replay(Journal(tmp_path / "session"), bench.cell)
        if isinstance(entry.command, NextStep)
    ]
    assert presses == [(number, "operator") for number in range(1, steps + 1)]
    assert screen.errors == []


def test_a_stop_while_a_step_waits(screen, bench, robot, reaches, wait, stepping):
    screen.press(label(stepping, 1))
    wait(lambda: bench.state.waits == 2, "the second step")
    screen.button(label(stepping, 2)).wait_for()
    screen.press("Stop")
    fault = str(reaches("fault").fault)
    assert "acknowledged the stop" in fault
    assert bench.state.let == 1 and bench.state.waits == 0
    expect(screen.page.get_by_role("button", name=re.compile("^Run step"))).to_have_count(0)
