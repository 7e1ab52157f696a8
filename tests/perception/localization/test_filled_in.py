"""Sparse clouds: between points of one surface the surface is drawn."""

from dataclasses import replace

import numpy as np

from workbench.app.runtime.work import find_parts
from workbench.perception.scene.scene_model import scene_model
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
