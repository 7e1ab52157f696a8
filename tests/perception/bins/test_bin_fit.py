"""Floor and walls of the bin where the scan shows them: raised, tilted, bent, moved, covered."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Bin
from workbench.model.scan import Scan
from workbench.perception.bins.bin_fit import (
    above_floor,
    fit_bin,
    inside_by,
)
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize

SIZE = np.array([0.4, 0.3, 0.1])
BIN = Bin(pin.SE3.Identity(), SIZE)


def box(count=40_000, noise=0.0003, seed=0):
    """Points on the floor and the inner walls of the bin, and which are the floor's."""
    generator = np.random.default_rng(seed)
    u, v, w = generator.uniform(-1, 1, (3, count))
    half = SIZE[:2] / 2
    floor = np.column_stack([half[0] * u, half[1] * v, np.zeros(count)])
    few = count // 8
    up = SIZE[2] * (w[:few] + 1) / 2
    walls = [
        np.column_stack([np.full(few, s * half[0]), half[1] * v[:few], up]) for s in (1, -1)
    ] + [np.column_stack([half[0] * u[:few], np.full(few, s * half[1]), up]) for s in (1, -1)]
    points = np.vstack([floor, *walls])
    return points + noise * generator.standard_normal(points.shape), count


def fitted(points, noise=0.0003):
    return fit_bin(points, pin.SE3.Identity(), BIN, noise=noise)


def test_a_bin_in_its_place_stays_there():
    seen = fitted(box()[0])
    assert np.abs(seen.floor).max() < 0.0001 and np.abs(seen.walls).max() < 0.0002
    assert seen.noise == pytest.approx(0.0003, rel=0.1)
    assert seen.floor_share > 0.95 and seen.wall_shares.min() > 0.7


@pytest.mark.parametrize("shift", [(0, 0, 5), (0, 0, -6), (4, -3, 2)])
@pytest.mark.parametrize("rpy_deg", [(0, 0, 0), (1, -0.7, 0), (0, 0, 1)])
def test_a_bin_that_is_off_is_fitted_where_it_is(shift, rpy_deg):
    points, count = box()
    T = pose_from_rpy(np.array(shift) / 1000, np.deg2rad(rpy_deg))
    seen = fitted(points @ T.rotation.T + T.translation)
    floor = (points @ T.rotation.T + T.translation)[:count]
    assert np.std(above_floor(seen, SIZE, floor)) < 0.00035
    assert abs(np.mean(above_floor(seen, SIZE, floor))) < 0.0001
    assert seen.walls[:, 0] == pytest.approx(
        np.array([shift[0], -shift[0], shift[1], -shift[1]]) / 1000, abs=0.0015
    )


def test_a_bent_floor_is_followed():
    points, count = box()
    u, v = 2 * points[:count, 0] / SIZE[0], 2 * points[:count, 1] / SIZE[1]
    points[:count, 2] += 0.006 * u**2 - 0.002 * v**2 + 0.001 * u * v
    seen = fitted(points)
    assert np.percentile(np.abs(above_floor(seen, SIZE, points[:count])), 95) < 0.001


@pytest.mark.parametrize("raised", [-0.005, 0.0, 0.005])
def test_plates_that_cover_most_of_the_floor_are_not_the_floor(raised):
    points, count = box()
    places = np.floor((points[:count, :2] + SIZE[:2] / 2) / (0.05, 0.04)).astype(int)
    covered = np.flatnonzero((places[:, 0] + 2 * places[:, 1]) % 4 > 0)
    assert len(covered) > 0.7 * count
    points[covered, 2] += 0.004
    points[:, 2] += raised
    seen = fitted(points)
    assert seen.floor[0] == pytest.approx(raised, abs=0.0007)
    assert np.median(above_floor(seen, SIZE, points[covered])) > 0.0025


def test_what_is_too_far_off_is_as_in_the_cell():
    points, _ = box()
    seen = fitted(points + (0, 0, 0.03))
    assert not seen.is_floor_seen
    assert not seen.floor.any()


@pytest.mark.parametrize("count", [0, 1, 20])
def test_a_few_points_are_no_bin(count):
    seen = fitted(np.random.default_rng(0).uniform(-0.1, 0.1, (count, 3)))
    assert not seen.floor.any() and not seen.walls.any()


def test_heights_and_ways_to_the_walls_follow_the_surfaces():
    points, _ = box()
    T = pose_from_rpy((0.003, 0, 0.005), (0, 0, 0))
    seen = fitted(points + T.translation)
    height, left = inside_by(seen.floor, seen.walls, SIZE, 0.0, 0.0, 0.055)
    assert height == pytest.approx(0.05, abs=1e-4)
    assert left == pytest.approx(0.15, abs=1e-3)
    _, left = inside_by(seen.floor, seen.walls, SIZE, 0.2, 0.0, 0.055)
    assert left == pytest.approx(0.003, abs=2e-4)
    assert inside_by(seen.floor, seen.walls, SIZE, -0.2, 0.0, 0.055)[1] < 0


def test_walls_that_are_not_seen_are_where_the_rim_says():
    cell = read_cell("yumi")
    scan = synthesize(cell, (), seed=2)
    moved = replace(
        cell,
        bin=replace(cell.bin, T_world_bin=cell.bin.T_world_bin * pose_from_rpy((-0.004, 0.003, 0))),
    )
    seen = scene_model(scan, moved).bin
    assert seen.walls[:, 0] == pytest.approx([0.004, -0.004, -0.003, 0.003], abs=0.0007)


@pytest.mark.parametrize("name", ["bracket", "keyed_cylinder"])
@pytest.mark.parametrize(("raised", "tilted"), [(0.005, 0.0), (-0.005, 0.0), (0.0, 1.0)])
def test_the_floor_under_a_heap_is_found(name, raised, tilted):
    cell, part = read_cell("yumi"), read_part(name)
    cell = replace(cell, parts=(part,))
    truth = drop_parts((part,) * 12, cell.bin, seed=4)
    scan = synthesize(cell, truth, seed=4)
    off = pose_from_rpy((0, 0, raised), (np.deg2rad(tilted), 0, 0))
    T = cell.bin.T_world_bin * off * cell.bin.T_world_bin.inverse() * scan.T_world_scanner
    seen = scene_model(Scan(scan.points, T, "off"), cell).bin
    corners = np.array([[x, y, 0.0] for x in (-0.1, 0, 0.1) for y in (-0.15, 0, 0.15)])
    there = corners @ off.rotation.T + off.translation
    assert np.abs(above_floor(seen, cell.bin.size, there)).max() < 0.0005


def test_the_same_points_give_the_same_bin():
    points, _ = box()
    assert fitted(points).floor.tolist() == fitted(points).floor.tolist()


def tops(count, seed=0):
    """Points on flat parts, 6 mm above the floor, and where they are seen on the floor, (n, 2)."""
    generator = np.random.default_rng(seed)
    middles = np.array([(-0.14, -0.09), (-0.05, 0.06), (0.06, -0.04), (0.13, 0.09)])
    places = (middles[:, None] + generator.uniform(-0.025, 0.025, (4, count, 2))).reshape(-1, 2)
    heights = 0.006 + 0.0002 * generator.standard_normal(len(places))
    return np.column_stack([places, heights])


def test_flat_tops_of_parts_are_no_floor_in_a_cloud_cropped_to_the_parts():
    seen = fitted(tops(4000))
    assert not seen.is_floor_seen
    np.testing.assert_array_equal(seen.floor, np.zeros(6))


def test_a_raised_floor_is_believed_where_something_is_measured_nearly_everywhere():
    points, count = box()
    low = points[:count] + (0, 0, 0.006)
    # Parts hide all but some patches: what lies on them is measured, far above the floor.
    is_hidden = (np.abs(low[:, 0]) > 0.06) | (np.abs(low[:, 1]) > 0.06)
    low[is_hidden, 2] += 0.05
    assert fitted(low).floor[0] == pytest.approx(0.006, abs=0.0005)
