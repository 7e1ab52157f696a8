"""The floor in a scan of which nobody knows where its scanner hangs."""

import numpy as np
import pytest

from workbench.model.geometry import pose_from_rpy
from workbench.perception.bins.floor_search import find_floor


def scene(tilt, seed=0):
    """A floor of 300 x 200 mm, with blocks on it whose tops are more than half of what is seen."""
    rng = np.random.default_rng(seed)
    floor = np.column_stack([*(rng.uniform(-1, 1, (2, 3000)) * [[0.15], [0.1]]), np.zeros(3000)])
    tops = np.column_stack([*(rng.uniform(-1, 1, (2, 5000)) * [[0.15], [0.1]]), np.zeros(5000)])
    tops[:, 2] = rng.choice([0.03, 0.05, 0.07], 5000)
    points = np.concatenate([floor, tops]) + rng.normal(scale=0.0005, size=(8000, 3))
    T = pose_from_rpy((0, 0, 0.5), (np.pi + tilt, 0, 0))
    return points @ T.rotation.T + T.translation, T


@pytest.mark.parametrize("tilt", [0.0, 0.2, 0.4])
def test_the_floor_is_what_nothing_lies_behind(tilt):
    points, T = scene(tilt)
    found = find_floor(points)
    assert found is not None
    T_floor, sides = found
    apart = T.actInv(T_floor)
    assert abs(apart.translation[2]) < 0.002
    assert apart.rotation[2, 2] > np.cos(np.deg2rad(1.5))
    assert np.linalg.norm(apart.translation[:2]) < 0.01
    assert sides == pytest.approx([0.3, 0.2], abs=0.02)


def test_points_anywhere_are_no_floor():
    rng = np.random.default_rng(1)
    assert find_floor(rng.uniform(-0.4, 0.4, (5000, 3)) + [0, 0, 0.9]) is None
    assert find_floor(np.zeros((2, 3))) is None
