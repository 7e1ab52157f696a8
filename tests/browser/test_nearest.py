"""Where a plan comes nearest to something, shown at a click; and its certificate, in Chromium."""

import io
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import NOBODY
from workbench.app.picking.facts import nearest_place
from workbench.app.picking.proving import check
from workbench.formats.plans.certificates import read_certificate
from workbench.gui.shared.colours import BAD, rgb_of
from workbench.gui.shared.playback import timeline
from workbench.model.motion import at_least


@pytest.fixture
def are_filled():
    return True


def planned(screen, reaches):
    for step, phase in (("Scan", "scanned"), ("Find parts", "localized"), ("Plan", "planned")):
        screen.press(step)
        state = reaches(phase)
    return state


def place_of(state):
    """When the plan is nearest to something, and the two points (2, 3) [m] there."""
    named = state.proof.nearest
    spot = nearest_place(state.cell, state.plan, state.proof)
    for run in timeline(state.plan):
        if (run.arm, run.leg.name) == (named.arm, named.leg):
            return run.start + spot.seconds, spot.points
    raise AssertionError("the proof names a leg that the plan does not have")


def is_marked(screen):
    """Whether the middle of what a browser draws is red: the mark of the nearest points."""
    box = screen.page.locator("canvas").first.bounding_box()
    middle = {"x": box["x"] + box["width"] / 2 - 40, "y": box["y"] + box["height"] / 2 - 40}
    picture = screen.page.screenshot(clip={**middle, "width": 80, "height": 80})
    drawn = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)
    red = np.abs(drawn - np.array(rgb_of(BAD))).max(axis=2) < 40
    return np.count_nonzero(red) > 3


def goes_there(served, screen, state, wait):
    look, client = served._renderer._look, next(iter(served._renderer._visitors.values())).client
    time, points = place_of(state)
    wait(lambda: look.now.time == pytest.approx(time), "the preview to stand there")
    middle = points.mean(axis=0)
    wait(lambda: np.allclose(client.camera.look_at, middle, atol=1e-3), "the camera to look there")
    assert np.linalg.norm(client.camera.position - middle) < 0.6
    wait(lambda: is_marked(screen), "the mark where the two are nearest")


def test_a_click_on_the_smallest_clearance_in_the_plan_tab_goes_there(
    served, screen, bench, reaches, wait
):
    state = planned(screen, reaches)
    screen.tab("Plan")
    nearest = screen.page.locator(".wb-go:visible").first
    named = state.proof.nearest
    said = nearest.inner_text()
    assert f"{at_least(state.proof.clearance)}, {named.arm} arm on {named.leg}" in said
    assert named.pair[0] in said and named.pair[1] in said
    screen.shoot("nearest-plan-tab")
    nearest.click()
    goes_there(served, screen, state, wait)
    screen.shoot("nearest-shown")
    screen.press("To the start")
    wait(lambda: not is_marked(screen), "the mark to go, as the plan stands elsewhere")
    assert screen.errors == []


def test_the_approval_goes_there_and_gives_the_certificate_of_this_plan(
    served, screen, bench, reaches, wait, tmp_path
):
    state = planned(screen, reaches)
    bench.do(WatchPlan(state.plan.digest), NOBODY)
    screen.press("Approve")
    screen.wait_for("Type your name to approve")
    facts = screen.text("[role=dialog]")
    for word in ("the whole motion on", "positions checked in", "Linear motion", "Certificate"):
        assert word in facts
    screen.shoot("approval-light")
    screen.press("Back")
    screen.page.get_by_role("dialog").wait_for(state="detached")
    screen.page.mouse.move(200, 400)
    screen.page.keyboard.press("l")
    screen.page.locator(':root[data-mantine-color-scheme="dark"]').wait_for()
    screen.press("Approve")
    screen.wait_for("Type your name to approve")
    screen.shoot("approval-dark")
    links = screen.page.locator("[role=dialog] .wb-go")
    with screen.page.expect_download() as waiting:
        links.nth(1).click()
    file = tmp_path / "certificate.json"
    waiting.value.save_as(file)
    assert waiting.value.suggested_filename == f"certificate-{state.plan.digest[:12]}.json"
    certificate = read_certificate(file)
    assert certificate.plan.digest == state.plan.digest
    assert check(state.cell, certificate).holds
    better = replace(certificate, proof=replace(certificate.proof, clearance=0.09))
    assert not check(state.cell, better).holds
    links.first.click()
    screen.page.get_by_role("dialog").wait_for(state="detached")
    goes_there(served, screen, state, wait)
    screen.shoot("nearest-from-approval")
    assert bench.state.approval is None, "to look is no word"
    assert screen.errors == []
