"""What a browser really shows of a plan, and what of it counts as watched, in Chromium."""

import time

import numpy as np
import pytest
from viser._messages import GetRenderResponseMessage

from workbench.gui.incoming.gate import MessageGate

LONG = 900.0
"""[s] That a plan may take to be played."""

STILL = "window.requestAnimationFrame = () => 0"
"""What a page is like that lies behind others: nothing of it is drawn."""


@pytest.fixture
def are_filled():
    return True


def planned(screen, reaches):
    for step, phase in (("Scan", "scanned"), ("Find parts", "localized"), ("Plan", "planned")):
        screen.press(step)
        state = reaches(phase)
    return state


def shared_link(served, cell):
    """Where the robot's last link is for everybody."""
    scene = served._renderer._server.scene
    return np.array(scene.get_handle_by_name(f"/planned/{cell.arms[0].flange}").position)


@pytest.fixture
def unpacked(monkeypatch):
    """Pictures of browsers as they are: the gate hands none of them on, since nobody needs them."""
    problem_of = MessageGate._problem

    def leave_picture(gate, number, message):
        payload = getattr(message, "payload", None)
        problem = problem_of(gate, number, message)
        if isinstance(message, GetRenderResponseMessage):
            message.payload = payload
        return problem

    monkeypatch.setattr(MessageGate, "_problem", leave_picture)


def patches(client):
    """What a browser draws of the robot and the bin, coarsely: it draws in less detail when busy.

    Returns:
        (30, 25, 3) mean colours [0..255] of patches of 6 by 8 pixels.
    """
    drawn = client.get_render(180, 320, transport_format="png")[:, 60:260, :3].astype(float)
    return drawn.reshape(30, 6, 25, 8, 3).mean(axis=(1, 3))


def changed(one, other):
    """How many patches have another colour, for anybody to see."""
    return np.count_nonzero(np.abs(one - other).max(axis=2) > 25.0)


def still(client):
    """What is drawn once nothing changes any more: a browser reads meshes one after another."""
    drawn = [patches(client)]
    while len(drawn) < 5:
        drawn.append(patches(client))
        if changed(drawn[-1], drawn[-2]):
            drawn = drawn[-1:]
    return drawn[-1]


# The plan waits for each drawing, which the processor makes here: for long where others compute.
@pytest.mark.timeout(1200)
def test_a_jog_that_is_left_on_does_not_hide_the_plan_that_is_played(
    served, screen, bench, reaches, wait
):
    planned(screen, reaches)
    screen.tab("Cell")
    screen.press("Jog")
    screen.wait_for("Clear; nearest:")
    stood = shared_link(served, bench.state.cell)
    screen.tab("Plan")
    screen.press("Play")
    seen, until = [], time.monotonic() + LONG
    while not bench.state.watched:
        assert time.monotonic() < until, "the plan was not played to its end"
        seen.append(shared_link(served, bench.state.cell))
        screen.page.wait_for_timeout(50)
    assert max(np.linalg.norm(one - stood) for one in seen) > 0.1, "the robot was seen to move"
    screen.tab("Cell")
    screen.button("Jog").wait_for()
    assert screen.errors == []


def test_a_page_that_is_not_drawn_has_not_watched(served, screen, bench, reaches, wait):
    plan = planned(screen, reaches).plan
    screen.tab("Plan")
    look = served._renderer._look
    screen.press("Play")
    wait(lambda: look.now.time > 0.1, "the plan to play")
    screen.page.evaluate(STILL)
    # Longer than the plan takes.
    screen.page.wait_for_timeout(1000 * (plan.cycle_seconds + 5))
    assert look.now.time < plan.cycle_seconds
    assert bench.state.watched == ()


def test_a_jogged_robot_is_drawn_over_the_shared_one_and_gives_it_back(
    unpacked, served, screen, bench, wait
):
    wait(lambda: len(served._renderer._visitors) == 1, "the browser")
    (visitor,) = served._renderer._visitors.values()
    client = visitor.client
    stood, before = shared_link(served, bench.state.cell), still(client)
    screen.tab("Cell")
    screen.press("Jog")
    screen.wait_for("Clear; nearest:")
    home = np.asarray(bench.state.cell.arms[0].home)
    visitor.own.change(jog={**visitor.own.now.jog, "right": home + 0.5})
    wait(lambda: changed(patches(client), before) > 20, "the jogged robot")
    assert np.array_equal(shared_link(served, bench.state.cell), stood)
    screen.page.locator('.wb-mode[data-mode="jog"]').wait_for()
    screen.shoot("own-jog")
    screen.press("End jogging")
    screen.page.locator('.wb-mode[data-mode="jog"]').wait_for(state="detached")
    wait(lambda: changed(patches(client), before) == 0, "the robot that all see, where it was")
    assert screen.errors == []
