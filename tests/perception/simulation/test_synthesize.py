"""The simulated scanner: what it measures of a known scene."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.simulation.noise_models import FINE_SCANNER
from workbench.perception.simulation.synthesize import synthesize


def world_points(scan) -> np.ndarray:
    T = scan.T_world_scanner
    return scan.points @ T.rotation.T + T.translation


def above_floor(cell, scan) -> np.ndarray:
    """Points inside the bin that are well above its floor."""
    p_bin = (world_points(scan) - cell.bin.T_world_bin.translation) @ cell.bin.T_world_bin.rotation
    inside = np.all(np.abs(p_bin[:, :2]) < cell.bin.size[:2] / 2 - 0.004, axis=1)
    return p_bin[inside & (p_bin[:, 2] > 0.004)]


def test_the_same_seed_gives_the_same_scan(cell, pile, scan):
    assert synthesize(cell, pile, seed=11).digest == scan.digest
    assert synthesize(cell, pile, seed=12).digest != scan.digest


def test_every_point_is_finite_in_range_and_in_its_pixel(cell, scan):
    assert np.all(np.isfinite(scan.points))
    depth = scan.points[:, 2]
    assert depth.min() >= cell.scanner.near
    assert depth.max() <= cell.scanner.far
    columns, _ = scan.resolution
    focal = columns / 2 / np.tan(cell.scanner.field_of_view / 2)
    across = scan.points[:, 0] / depth * focal
    order = np.argsort(scan.pixels % columns, kind="stable")
    assert np.all(np.diff(across[order]) > -0.01), "columns do not go with x"


def test_parts_are_seen_and_an_empty_bin_is_flat(cell, scan):
    assert len(above_floor(cell, scan)) > 3000
    # But for the few points that are decoded wrongly.
    assert len(above_floor(cell, synthesize(cell, (), seed=0))) < 100


def test_what_lies_under_something_is_not_seen(cell, part):
    low, high = (
        Detection(part.name, cell.bin.T_world_bin * pose_from_rpy((0, 0, z), (0, np.pi / 2, 0)))
        for z in (0.015, 0.045)
    )
    both = above_floor(cell, synthesize(cell, (low, high), seed=0))
    alone = above_floor(cell, synthesize(cell, (low,), seed=0))
    middle = np.abs(both[:, 1]) < 0.008
    # But for some in a hundred: flying pixels, and what is decoded wrongly.
    assert np.quantile(both[middle, 2], 0.05) > 0.035
    assert np.quantile(alone[:, 2], 0.99) < 0.035


def test_noise_is_as_declared(cell, part):
    quiet = replace(cell, scanner=replace(cell.scanner, depth_noise=0.0))
    noisy = replace(cell, scanner=replace(cell.scanner, depth_noise=0.001))
    steady = replace(FINE_SCANNER, outliers=0.0, flying=0.0)
    scans = [synthesize(one, (), seed=3, noise=steady) for one in (quiet, noisy)]
    common, first, second = np.intersect1d(scans[0].pixels, scans[1].pixels, return_indices=True)
    difference = scans[1].points[second, 2] - scans[0].points[first, 2]
    depth = scans[0].points[first, 2]
    middle = np.abs(scans[0].points[first, :2]).max(axis=1) < 0.05  # the floor, met head-on
    assert len(common) > 10_000
    ratio = difference[middle] / depth[middle] ** 2
    assert 0.0009 < ratio.std() < 0.0011
    assert abs(ratio.mean()) < 1e-4


def test_a_scanner_that_sees_nothing_says_so(cell, part):
    blind = replace(cell, scanner=replace(cell.scanner, near=0.1, far=0.2))
    with pytest.raises(InputError, match=r"0\.1 m and 0\.2 m"):
        synthesize(blind, (), seed=0)
