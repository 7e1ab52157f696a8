"""Sparse clouds: between points of one surface the surface is drawn."""

from dataclasses import replace

import numpy as np

from workbench.app.runtime.work import find_parts
from workbench.formats.parts.reading import read_part
from workbench.model import scan as model_scan
from workbench.model.scan import ALL_KINDS
from workbench.perception.localization.judging import PartSearch
from workbench.perception.localization.localize import begin_search
from workbench.perception.localization.outline import has_visible_boundary
from workbench.perception.matching.maps import MIXED
from workbench.perception.parts.part_surface import prepare
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize, visible_shares
from workbench.perception.views.filling import densify, spacing_of
from workbench.plugins.progress import never, silent
from workbench.studies.localization import compare


def wall(count, depth, across, seed=0):
    """Random points (count, 3) on a plane `depth` before a camera, `across` wide."""
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-across / 2, across / 2, (count, 2))
    return np.column_stack([xy, depth + 0.2 * xy[:, 0]])


def test_points_that_are_filled_in_lie_on_the_surface():
    sparse = wall(2000, 1.0, 0.4)
    dense = densify(sparse, 0.003)
    assert len(dense) > 4 * len(sparse)
    assert np.array_equal(dense[: len(sparse)], sparse)
    assert np.abs(dense[:, 2] - 1.0 - 0.2 * dense[:, 0]).max() < 2e-3


def test_a_step_stays_a_step_where_the_points_have_it():
    points = wall(4000, 1.0, 0.4)
    points[:, 2] = np.where(points[:, 0] > 0, 0.95, 1.0)
    dense = densify(points, 0.003)
    away = np.abs(dense[:, 0]) > 0.01
    assert np.isin(dense[away, 2].round(6), (0.95, 1.0)).all()
    between = (dense[:, 2] > 0.951) & (dense[:, 2] < 0.999)
    assert np.count_nonzero(between) < 0.001 * len(dense)


def test_points_that_are_dense_enough_stay_as_they_are():
    points = wall(2000, 1.0, 0.1)
    spacing, _, _ = spacing_of(points)
    assert densify(points, spacing * 1.01) is points


def test_a_stray_point_beside_the_scanner_does_not_widen_the_picture():
    points = wall(2000, 1.0, 0.1)
    strays = np.vstack([[[0.1, -0.1, 1e-6]], points])
    for alone, also in zip(spacing_of(points), spacing_of(strays), strict=True):
        np.testing.assert_allclose(also, alone)


def thinned(scan, count):
    kept = np.sort(np.random.default_rng(0).permutation(len(scan.points))[:count])
    return replace(scan, points=scan.points[kept], pixels=None, resolution=None)


def test_dense_scans_are_searched_as_they_were_measured(cell, scan):
    scene = scene_model(scan, cell, smallest=0.08)
    assert scene.filled == 1.0
    assert scene.points is scan.points


def test_parts_are_found_in_a_scan_of_which_a_thirtieth_is_left(cell, scan, pile):
    sparse = thinned(scan, 10_000)
    result = find_parts(cell, {"scan": sparse, "seed": 0}, silent, never)
    found, are_found = compare(cell.parts, pile, result.detections)
    assert all(are_found)
    assert all(detection.is_right for detection in found)


def test_a_sparse_scan_is_filled_in_once_for_all_kinds(cell, scan, monkeypatch):
    digests, digest_of = [], model_scan.digest_of

    def counted(value, **how):
        digests.append(value)
        return digest_of(value, **how)

    kinds = tuple(read_part(name) for name in ("bracket", "bolt", "puck"))
    sparse, whole = thinned(scan, 10_000), replace(cell, parts=kinds)
    monkeypatch.setattr(model_scan, "digest_of", counted)
    scene = scene_model(sparse, whole, smallest=prepare(kinds[1]).diameter)
    searches = [begin_search(sparse, part, whole, detail=1.0, scene=scene) for part in kinds]
    assert all(isinstance(search, PartSearch) and search.filled > 2.0 for search in searches)
    assert digests == [scene.scan]


def test_right_brackets_end_where_few_points_have_them_end(cell):
    bracket = read_part("bracket")
    cell = replace(cell, parts=(bracket,))
    pile = pile_of(cell, ALL_KINDS, 8, seed=8801)
    sparse = thinned(synthesize(cell, pile, seed=8801), 10_000)
    scene = scene_model(sparse, cell, smallest=prepare(bracket).diameter)
    search = begin_search(sparse, bracket, cell, detail=1.0, scene=scene)
    assert isinstance(search, PartSearch) and search.filled > 2.0
    T_scanner_world = sparse.T_world_scanner.inverse()
    nothing = np.zeros(search.depth_map.depth.size, np.bool_)
    poses = [
        (T_scanner_world * true.T_world_part).homogeneous
        for true, visible in zip(pile, visible_shares(cell, pile), strict=True)
        if visible > 0.6
    ]

    def ending(depth_map):
        """How many parts end, if nothing is known of the others."""
        return sum(
            has_visible_boundary(depth_map, search.surface, pose, search.tolerance, nothing)
            for pose in poses
        )

    assert ending(search.depth_map) > ending(replace(search.depth_map, mixed=MIXED))
