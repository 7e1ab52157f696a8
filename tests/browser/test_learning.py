"""Parts that were left without a plan get grasps from the tab Statistics, in a real browser."""

from dataclasses import replace

import numpy as np
import pytest
from hands import settle
from playwright.sync_api import expect

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.state import Phase
from workbench.app.filling import fill_process
from workbench.app.filling.for_remaining import families_for
from workbench.model.errors import JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.work import CancelText, ProgressText
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.model.scan import Detection


@pytest.fixture
def bench(own_bench):
    return own_bench


@pytest.fixture
def url(own_url):
    return own_url


@pytest.fixture
def here(monkeypatch):
    """Grasps are looked for in this process, which is ready."""

    def propose(cell, name, left, report, given_up):
        return families_for(cell, name, left, report=report, cancelled=given_up.is_set)

    monkeypatch.setattr(fill_process, "propose_apart", propose)


@pytest.fixture
def endless(monkeypatch):
    """Grasps are looked for until somebody stops that."""

    def propose(cell, name, left, report, given_up):
        report(0.5, ProgressText.GRIPS())
        assert given_up.wait(60)
        raise JobCancelled(CancelText.FILLING())

    monkeypatch.setattr(fill_process, "propose_apart", propose)


def leave_a_part(screen, bench, wait):
    """Have a planning leave a part along a wall; the library's one grasp cannot take it."""
    part = bench.state.cell.parts[0]
    first = part.library.entries[0]
    shut = with_grasp(first, replace(grasp_of(first), is_enabled=False))
    entries = part.library.entries
    bench.do(EditPart(part.name, entries, (shut,), pairs=(), searches=False), "Ada")
    floor, length = bench.state.cell.bin.T_world_bin.translation, bench.state.cell.bin.size[0]
    pile = tuple(
        Detection(part.name, pose_from_rpy(floor + [x, y, 0.0191], (np.pi / 2, 0.0, 0.0)))
        for x, y in ((0.0, -0.05), (length / 2 - 0.022, 0.05))
    )
    bench.do(UseDetections(pile), "Ada")
    bench.do(MakePlan(), "Ada")
    wait(lambda: bench.state.job is None and bench.state.phase is not Phase.IDLE, "no plan")
    assert bench.state.plan is None
    screen.tab("Statistics")
    screen.wait_for("Parts left when no plan was found")


def test_a_search_for_grasps_of_parts_left_can_be_stopped_and_begun_again(
    screen, bench, wait, endless
):
    leave_a_part(screen, bench, wait)
    before = bench.state.cell.parts[0].library.entries
    for _ in range(2):
        screen.press("Add grasps for the parts left")
        screen.wait_for("50%")
        screen.shoot("learning_3_under_way")
        screen.press("Cancel")
        screen.wait_for("Stopped: nothing was added.")
    assert bench.state.cell.parts[0].library.entries == before


def test_parts_left_along_a_wall_get_grasps_by_a_button_and_undo_takes_them_back(
    screen, bench, wait, here
):
    leave_a_part(screen, bench, wait)
    screen.shoot("learning_1_left")
    screen.press("Add grasps for the parts left")

    def entries():
        return bench.state.cell.parts[0].library.entries

    wait(lambda: len(entries()) > 1, "new grasps")
    screen.wait_for("can be taken with new grasps")
    settle(screen.page, 500)
    screen.shoot("learning_2_added")
    bench.do(MakePlan(), "Ada")
    wait(lambda: bench.state.plan is not None, "a plan with the new grasps")
    screen.tab("Grasps")
    screen.press("Undo")
    wait(lambda: len(entries()) == 1, "the library as it was")
    expect(screen.page.get_by_text("Internal error")).to_have_count(0)
