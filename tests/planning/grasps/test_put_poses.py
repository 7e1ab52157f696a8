"""In which poses a part lies right at a place."""

import numpy as np
import pytest

from workbench.model.geometry import pose_from_rpy
from workbench.model.part import PartPlace
from workbench.model.symmetry import Symmetry, SymmetryAxis, make_turn
from workbench.planning.grasps.put_poses import suits_any_roll, ways_to_lie

X, Z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
HERE = pose_from_rpy((0.3, -0.2, 0.1), (0.3, -0.4, 1.2))


@pytest.mark.parametrize(
    ("symmetry", "free", "count"),
    [
        (Symmetry(), 0.0, 1),
        (Symmetry(), np.deg2rad(30), 3),
        (Symmetry(), np.pi, 12),
        (Symmetry(Z, 6), 0.0, 6),
        (Symmetry(Z, 6), np.pi, 12),
        (Symmetry(Z, 0), 0.0, 12),
        (Symmetry(Z, 0), np.pi, 12),
        (Symmetry(Z, 0, also=(SymmetryAxis(X, 2),)), 0.0, 24),
        (Symmetry(X, 2), np.pi, 24),
    ],
)
def test_what_is_alike_is_counted_once_and_the_stated_pose_comes_first(symmetry, free, count):
    ways = ways_to_lie(PartPlace(HERE, free_rotation=free), symmetry)
    assert len(ways) == count
    assert ways[0].isApprox(HERE, 1e-9)
    for number, T in enumerate(ways):
        assert not any(T.isApprox(other, 1e-6) for other in ways[:number])


def test_a_symmetry_beside_the_origin_turns_about_its_own_point():
    point = (0.01, 0.0, 0.02)
    symmetry = Symmetry(Z, 2, point)
    _, other = ways_to_lie(PartPlace(HERE), symmetry)
    assert np.allclose(other.act(np.array(point)), HERE.act(np.array(point)), atol=1e-12)
    assert other.isApprox(HERE * make_turn(Z, np.pi, np.array(point)), 1e-9)


@pytest.mark.parametrize(
    ("free", "symmetry", "axis", "suits"),
    [
        (np.pi, Symmetry(), ((0, 0, 0.02), (0, 0, -1)), True),
        (np.pi, Symmetry(), ((0.002, 0, 0), (0, 0, 1)), False),
        (np.pi, Symmetry(), ((0, 0, 0), (1, 0, 0)), False),
        (np.deg2rad(170), Symmetry(), ((0, 0, 0), (0, 0, 1)), False),
        (0.0, Symmetry(X, 0), ((0.3, 0, 0), (1, 0, 0)), True),
        (0.0, Symmetry(X, 0), ((0, 0.001, 0), (1, 0, 0)), False),
        (0.0, Symmetry(Z, 6), ((0, 0, 0), (0, 0, 1)), False),
        (0.0, Symmetry(Z, 0, also=(SymmetryAxis(X, 0),)), ((0, 0, 0), (0.6, 0, 0.8)), True),
    ],
)
def test_which_places_take_a_part_whose_roll_nobody_knows(free, symmetry, axis, suits):
    place = PartPlace(HERE, free_rotation=free)
    assert suits_any_roll(place, symmetry, np.array(axis, float)) is suits
