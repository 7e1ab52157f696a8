"""Where parts lie in a scan that shows no rim."""

import numpy as np
import pytest

from workbench.model.geometry import pose_from_rpy
from workbench.perception.bins.lying import find_lying

LARGEST = 0.1


def block(rng, x, y, z, count=1500):
    """Top and two sides of a block of 60 x 60 x 40 mm whose top lies at a height."""
    sides = rng.uniform(-0.03, 0.03, (count, 2))
    top = np.column_stack([sides, np.full(count, z)])
    low = np.column_stack([
        np.full(count // 3, 0.03), rng.uniform(-0.03, 0.03, count // 3),
        rng.uniform(z - 0.025, z, count // 3),
    ])  # fmt: skip
    return np.concatenate([top, low, low[:, [1, 0, 2]]]) + [x, y, 0.0]


def seen(points, tilt=0.0, seed=1):
    """Points over a floor as a scanner 0.8 m above it sees them, with noise, and its pose there."""
    noise = np.random.default_rng(seed).normal(scale=0.0004, size=points.shape)
    T = pose_from_rpy((0, 0, 0.8), (np.pi + tilt, 0, 0))
    return (points + noise) @ T.rotation.T + T.translation, T


@pytest.mark.parametrize("tilt", [0.0, 0.6])
def test_parts_on_a_wide_table_are_found_aside_of_its_middle(tilt):
    rng = np.random.default_rng(0)
    table = np.column_stack([*(rng.uniform(-1, 1, (2, 20_000)) * [[0.5], [0.3]]), np.zeros(20_000)])
    parts = [block(rng, 0.2, -0.1, 0.04), block(rng, 0.32, -0.1, 0.04)]
    points, T = seen(np.concatenate([table, *parts]), tilt)
    lying = find_lying(points, LARGEST)
    assert lying is not None and lying.is_floor_seen
    apart = T.actInv(lying.T_scanner_region)
    assert apart.translation == pytest.approx([0.26, -0.1, 0.0], abs=0.02)
    assert lying.size == pytest.approx([0.24, 0.12, 0.05], abs=0.03)


def test_without_a_floor_the_lowest_parts_are_none():
    rng = np.random.default_rng(0)
    parts = [block(rng, 0.1 * k, 0.12 * (k % 2), 0.04 + 0.03 * (k % 3)) for k in range(6)]
    points, _ = seen(np.concatenate(parts))
    lying = find_lying(points, LARGEST)
    assert lying is not None and not lying.is_floor_seen and lying.below == LARGEST
    deepest = points[:, 2].max()
    assert lying.T_scanner_region.translation[2] == pytest.approx(deepest + LARGEST, abs=0.005)
    assert lying.size == pytest.approx([0.6, 0.22, 0.2], abs=0.06)


def test_a_floor_between_many_parts_is_one():
    rng = np.random.default_rng(0)
    grid = np.stack(np.meshgrid(np.arange(5), np.arange(3)), axis=-1).reshape(-1, 2)
    parts = [block(rng, *(0.075 * at), 0.04) for at in grid]
    low, high = 0.075 * grid.min(axis=0) - 0.035, 0.075 * grid.max(axis=0) + 0.035
    floor = np.column_stack([rng.uniform(low, high, (30_000, 2)), np.zeros(30_000)])
    near = (floor[:, None, :2] - 0.075 * grid).reshape(len(floor), -1, 2)
    floor = floor[(np.abs(near).max(axis=2) > 0.031).all(axis=1)]
    points, T = seen(np.concatenate([floor, *parts]))
    lying = find_lying(points, 0.6)
    assert lying is not None and lying.is_floor_seen
    assert abs(T.actInv(lying.T_scanner_region).translation[2]) < 0.003


def test_two_points_lie_nowhere():
    assert find_lying(np.zeros((2, 3)), LARGEST) is None
