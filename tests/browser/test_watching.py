"""What a browser really shows of a plan, and what of it counts as watched, in Chromium."""

import time

import numpy as np
import pytest

from workbench.gui.page.server import serve

LONG = 900.0
"""[s] That a plan may take to be played."""

STILL = "window.requestAnimationFrame = () => 0"
"""What a page is like that lies behind others: nothing of it is drawn."""


@pytest.fixture
def served(bench):
    page = serve(bench, port=0, most_points=4000)
    yield page
    page.close()


@pytest.fixture
def url(served):
    return served.url


def planned(screen, reaches):
    for step, phase in (("Scan", "scanned"), ("Find parts", "localized"), ("Plan", "planned")):
        screen.press(step)
        state = reaches(phase)
    return state


def shared_link(served, cell):
    """Where the robot's last link is for everybody."""
    scene = served._renderer._server.scene
    return np.array(scene.get_handle_by_name(f"/robot/{cell.arms[0].flange}").position)


def still(picture):
    """What is drawn once nothing changes any more: a browser reads meshes one after another."""
    drawn = [picture()]
    while len(drawn) < 5:
        drawn.append(picture())
        if np.abs(drawn[-1] - drawn[-2]).mean() > 0.05:
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
    screen.wait_for("Clear; nearest are")
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


# Seen with busy processors and, since the light is another one, also with idle ones.
@pytest.mark.xfail(reason="after 'End jogging' the picture may keep the moved robot", strict=False)
def test_a_jogged_robot_is_drawn_over_the_shared_one_and_gives_it_back(served, screen, bench, wait):
    wait(lambda: len(served._renderer._visitors) == 1, "the browser")
    (visitor,) = served._renderer._visitors.values()

    def picture():
        drawn = visitor.client.get_render(180, 320, transport_format="png")
        return drawn[..., :3].astype(float)

    stood = shared_link(served, bench.state.cell)
    screen.tab("Cell")
    screen.press("Jog")
    screen.wait_for("Clear; nearest are")
    at_home = still(picture)
    home = np.asarray(bench.state.cell.arms[0].home)
    visitor.own.change(jog={**visitor.own.now.jog, "right": home + 0.5})
    wait(lambda: np.abs(picture() - at_home).mean() > 1.0, "the jogged robot")
    moved = np.abs(still(picture) - at_home).mean()
    assert np.array_equal(shared_link(served, bench.state.cell), stood)
    screen.shoot("own-jog")
    screen.press("End jogging")
    for _ in range(20):
        after = np.abs(still(picture) - at_home).mean()
        if after < moved / 5:
            break
    assert after < moved / 5, "the robot that all see"
    assert screen.errors == []
