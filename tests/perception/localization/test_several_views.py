"""Parts in a scan from several views: what one finds, the others look at along their own rays."""

from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view

from workbench.model.cell import Cell
from workbench.model.derived.by_view import by_each_view
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, LocalizationResult, Objection, Scan
from workbench.perception.localization.kinds import SearchedView
from workbench.perception.localization.localize import begin_search
from workbench.perception.localization.several_views import localize_in_views
from workbench.perception.scene.merging import merged
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts
from workbench.plugins.progress import Report, silent

PARTS = 5


@pytest.fixture(scope="module")
def cell() -> Cell:
    return with_lower_view(on_arm_cell())


@pytest.fixture(scope="module")
def truth(cell: Cell) -> tuple[Detection, ...]:
    return pile_of(cell, "", PARTS, seed=2)


@pytest.fixture(scope="module")
def whole(cell: Cell, truth: tuple[Detection, ...]) -> Scan:
    high, low = (synthesize(each, truth, seed=2) for each in by_each_view(cell))
    return merged(cell, merged(cell, None, high, "bin"), low, "low")


def smaller(cell: Cell) -> Cell:
    """The cell with parts of 85% of their size."""
    (part,) = cell.parts
    mesh = replace(part.mesh, points=0.85 * part.mesh.points, pieces=())
    return replace(cell, parts=(replace(part, mesh=mesh),))


def search(cell: Cell, whole: Scan, *brought: tuple[Detection, ...]) -> LocalizationResult:
    """What comes of it where the search in each view brings these, one after the other."""
    results = iter(LocalizationResult(detections) for detections in brought)

    def localize(scan: Scan, report: Report) -> SearchedView:
        scene = scene_model(scan, cell)
        searches = [begin_search(scan, p, cell, detail=1.0, scene=scene) for p in cell.parts]
        return SearchedView(next(results), tuple(searches))

    return localize_in_views(whole, localize, silent)


def test_a_part_that_both_views_show_is_one(cell, truth, whole):
    near = tuple(
        replace(one, T_world_part=pose_from_rpy((0.0002, 0, 0)) * one.T_world_part) for one in truth
    )
    found = search(cell, whole, truth, near)
    assert len(found.detections) == PARTS
    assert [each.reason for each in found.rejected] == [Objection.TWIN] * PARTS
    assert all(each.rival is not None for each in found.rejected)


def test_a_part_that_one_view_has_found_is_found(cell, truth, whole):
    found = search(cell, whole, truth[:2], truth[2:])
    assert len(found.detections) == PARTS and found.rejected == ()


def test_a_part_through_which_another_view_looks_is_none(cell, truth, whole):
    up = replace(truth[0], T_world_part=pose_from_rpy((0, 0, 0.03)) * truth[0].T_world_part)
    found = search(cell, whole, (up, *truth[1:]), ())
    assert len(found.detections) == PARTS - 1
    assert [each.reason for each in found.rejected] == [Objection.FREE_SPACE]


def test_of_parts_that_reach_into_each_other_the_better_one_stands(cell, truth, whole):
    into = replace(truth[0], T_world_part=pose_from_rpy((0, 0, 0.004)) * truth[0].T_world_part)
    found = search(cell, whole, (truth[0],), (into,))
    (one,) = found.detections
    assert one.T_world_part.isApprox(truth[0].T_world_part)


def test_the_usual_search_finds_the_parts_in_the_merged_scan(cell, truth, whole):
    shares: list[float] = []
    found = find_parts(whole, cell, seed=1, report=lambda done, note: shares.append(done))
    places = [one.T_world_part.translation for one in truth]
    for one in found.detections:
        assert min(np.linalg.norm(one.T_world_part.translation - p) for p in places) < 0.003
    assert len(found.detections) == PARTS
    assert shares == sorted(shares) and shares[-1] <= 1.0


def test_views_are_compared_by_the_size_that_their_searches_found(cell):
    small = smaller(cell)
    truth = pile_of(small, "", PARTS, seed=2)
    high, low = (synthesize(each, truth, seed=2) for each in by_each_view(small))
    both = merged(cell, merged(cell, None, high, "bin"), low, "low")
    assert len(search(small, both, truth, ()).detections) == PARTS
    assert len(search(cell, both, truth, ()).detections) < PARTS
