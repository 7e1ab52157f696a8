"""Verdicts while something is dragged with its gizmo, in real browsers."""

from contextlib import contextmanager

import numpy as np
from hands import Camera, first_look, settle
from playwright.sync_api import expect

from workbench.gui.cell.panel import GIZMO
from workbench.gui.grasps.pose import GIZMO as HAND_GIZMO
from workbench.gui.scene.stage import T_WORLD_STAGE, size_of, view_of
from workbench.model.part_edits import grasp_of

WORDS = "while you drag: "


@contextmanager
def dragged(page, start, end):
    """A hand that has dragged from here to there, and has not let go within the block."""
    settle(page, 0)
    page.mouse.move(*start)
    settle(page, 300)
    page.mouse.down()
    settle(page, 100)
    page.mouse.move(*end, steps=12)
    settle(page, 200)
    yield
    page.mouse.up()


def said(screen):
    return screen.page.get_by_text(WORDS).locator("visible=true")


def found_parts(screen, reaches):
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")


def test_while_the_bin_is_dragged_one_browser_tells_how_many_grasps_would_work(
    open_screen, bench, wait, reaches
):
    screen, other = open_screen(), open_screen()
    found_parts(screen, reaches)
    for one in (screen, other):
        one.tab("Cell")
    screen.press("Show gizmo")
    settle(screen.page, 1000)
    state, head = bench.state, bench.head
    camera, p = first_look(screen.page, state.cell), state.cell.bin.T_world_bin.translation
    tip = p + [0, 0, 0.9 * GIZMO]
    with dragged(screen.page, camera.pixel(tip), camera.pixel(tip + [0, 0, 0.03])):
        expect(said(screen)).to_contain_text(f"of {2 * 2 * 15} work")
        # Against a floor that is so much higher every hand is too near.
        expect(said(screen)).to_contain_text(f"{WORDS}0 of ")
        screen.shoot("live-verdicts")
        assert said(other).count() == 0
        assert (bench.state, bench.head) == (state, head)
    wait(lambda: bench.state.before != (), "the bin moved")
    expect(said(screen)).to_have_count(0)
    screen.shoot("live-verdicts-over")
    assert screen.errors == [] and other.errors == []


def test_while_a_grasp_is_dragged_it_is_told_for_the_parts_found(screen, bench, wait, reaches):
    found_parts(screen, reaches)
    part = bench.state.cell.parts[0]
    screen.tab("Grasps")
    screen.press("Edit grasps")
    settle(screen.page, 1500)
    T = grasp_of(part.library.entries[0]).T_part_tcp
    camera = Camera(screen.page, *view_of(part))
    z = np.array(T.rotation[:, 2])
    handle = T_WORLD_STAGE.act(T.translation + 0.9 * HAND_GIZMO * size_of(part) * z)
    with dragged(screen.page, camera.pixel(handle), camera.pixel(handle + 0.01 * z)):
        expect(said(screen)).to_contain_text(f"of {2 * 2 * 15} work")
        screen.shoot("live-verdicts-grasp")
        assert bench.state.cell.parts[0] is part
    wait(lambda: bench.state.before != (), "the grasp moved")
    expect(said(screen)).to_have_count(0)
    assert bench.state.detections, "with other grasps the parts stay found"
    assert screen.errors == []
