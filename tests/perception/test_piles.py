"""Parts that fall into the bin."""

import numpy as np
import open3d as o3d
import pytest

from workbench.model.errors import InputError
from workbench.perception.piles import OUTSIDE, drop_parts
from workbench.perception.surfaces import add_surface, surface_of


def poses_of(pile) -> np.ndarray:
    return np.array([T.homogeneous for T in pile])


def test_the_same_seed_gives_the_same_pile(cell, part, pile):
    assert np.array_equal(poses_of(drop_parts(part, cell.bin, 3, seed=11)), poses_of(pile))
    assert not np.array_equal(poses_of(drop_parts(part, cell.bin, 3, seed=12)), poses_of(pile))


@pytest.mark.parametrize("seed", range(4))
def test_parts_lie_inside_the_bin_and_on_its_floor(cell, part, seed):
    points = np.asarray(part.mesh.points)
    lowest = []
    for T in drop_parts(part, cell.bin, 4, seed=seed):
        p_bin = points @ (cell.bin.T_world_bin.inverse() * T).rotation.T
        p_bin = p_bin + cell.bin.T_world_bin.actInv(T).translation
        assert np.all(np.abs(p_bin[:, :2]) <= cell.bin.size[:2] / 2 + OUTSIDE)
        assert p_bin[:, 2].min() >= -OUTSIDE
        lowest.append(p_bin[:, 2].min())
    assert min(lowest) < 0.001, "nothing lies on the floor"


def test_parts_do_not_reach_into_each_other(cell, part):
    pile = drop_parts(part, cell.bin, 6, seed=5)
    points = np.asarray(part.mesh.points)
    for number, T in enumerate(pile):
        scene = o3d.t.geometry.RaycastingScene()
        add_surface(scene, surface_of(part.mesh), T)
        for other in pile[number + 1 :]:
            p_world = points @ other.rotation.T + other.translation
            depth = scene.compute_signed_distance(o3d.core.Tensor(p_world.astype(np.float32)))
            assert depth.numpy().min() > -0.002


def test_none_fall_when_none_are_asked_for(cell, part):
    assert drop_parts(part, cell.bin, 0, seed=0) == ()


def test_what_cannot_fit_is_refused(cell, part):
    with pytest.raises(InputError, match="-1"):
        drop_parts(part, cell.bin, -1, seed=0)
    with pytest.raises(
        InputError, match=r"60 parts keyed_cylinder do not fit into the bin; take \d+ or fewer"
    ):
        drop_parts(part, cell.bin, 60, seed=0)
