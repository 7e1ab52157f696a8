"""Parts that fall into the bin."""

from dataclasses import replace

import mujoco
import numpy as np
import open3d as o3d
import pinocchio as pin
import pytest

from workbench.formats.parts.reading import read_part
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Mesh
from workbench.model.part import GraspLibrary
from workbench.model.symmetry import Symmetry
from workbench.perception.simulation import physics
from workbench.perception.simulation.physics import LONGEST_SETTLING, LOST, come_to_rest, model_of
from workbench.perception.simulation.piles import OUTSIDE, drop_parts
from workbench.perception.simulation.room import radius_of
from workbench.perception.simulation.unloading import is_in_bin, unloaded
from workbench.perception.views.surfaces import add_surface, triangles_of


def digests_of(pile) -> list[str]:
    return [digest_of(one) for one in pile]


def test_the_same_seed_gives_the_same_pile(cell, part, pile):
    assert digests_of(drop_parts((part,) * 3, cell.bin, seed=11)) == digests_of(pile)
    assert digests_of(drop_parts((part,) * 3, cell.bin, seed=12)) != digests_of(pile)


@pytest.mark.parametrize("seed", range(4))
def test_parts_lie_inside_the_bin_and_on_its_floor(cell, part, seed):
    points = np.asarray(part.mesh.points)
    lowest = []
    for one in drop_parts((part,) * 4, cell.bin, seed=seed):
        T = one.T_world_part
        p_bin = points @ (cell.bin.T_world_bin.inverse() * T).rotation.T
        p_bin = p_bin + cell.bin.T_world_bin.actInv(T).translation
        assert np.all(np.abs(p_bin[:, :2]) <= cell.bin.size[:2] / 2 + OUTSIDE)
        assert p_bin[:, 2].min() >= -OUTSIDE
        lowest.append(p_bin[:, 2].min())
    assert min(lowest) < 0.001, "nothing lies on the floor"


def test_parts_do_not_reach_into_each_other(cell, part):
    pile = [one.T_world_part for one in drop_parts((part,) * 6, cell.bin, seed=5)]
    points = np.asarray(part.mesh.points)
    for number, T in enumerate(pile):
        scene = o3d.t.geometry.RaycastingScene()
        add_surface(scene, triangles_of(part.mesh), T)
        for other in pile[number + 1 :]:
            p_world = points @ other.rotation.T + other.translation
            depth = scene.compute_signed_distance(o3d.core.Tensor(p_world.astype(np.float32)))
            assert depth.numpy().min() > -0.002


def test_none_fall_when_none_are_asked_for(cell):
    assert drop_parts((), cell.bin, seed=0) == ()


def test_what_cannot_fit_is_refused(cell, part):
    with pytest.raises(
        InputError, match=r"60 parts keyed_cylinder do not fit into the bin; take \d+ or fewer"
    ):
        drop_parts((part,) * 60, cell.bin, seed=0)


def test_parts_of_several_kinds_fall_together_each_with_its_own_mass(cell):
    kinds = [read_part(name) for name in ("bolt", "bracket", "keyed_cylinder")]
    pile = drop_parts(kinds * 2, cell.bin, seed=0)
    assert [one.part for one in pile] == [kind.name for kind in kinds * 2]
    for kind, one in zip(kinds * 2, pile, strict=True):
        T = cell.bin.T_world_bin.actInv(one.T_world_part)
        p_bin = np.asarray(kind.mesh.points) @ T.rotation.T + T.translation
        assert np.all(np.abs(p_bin[:, :2]) <= cell.bin.size[:2] / 2 + OUTSIDE)
        assert p_bin[:, 2].min() >= -OUTSIDE
    masses = model_of(kinds, cell.bin).body_mass[1:]
    assert masses == pytest.approx([kind.mass for kind in kinds])


def test_from_a_surface_without_walls_parts_may_roll_off_and_are_not_told(cell, part):
    narrow = replace(cell.bin, size=np.array([0.1, 0.1, 0.1]), has_walls=False)
    pile = drop_parts((part,) * 5, narrow, seed=3)
    assert 1 <= len(pile) < 5, "so many cylinders do not stay on so little room"
    assert all(is_in_bin(narrow, part, one.T_world_part) for one in pile)
    assert digests_of(drop_parts((part,) * 5, narrow, seed=3)) == digests_of(pile)


def test_what_falls_off_does_not_hold_up_what_lies_still(cell, part):
    """A part beside a surface falls for ever: the others have come to rest all the same."""
    model = model_of((part, part), replace(cell.bin, has_walls=False))
    model.body_gravcomp[1:] = 0.0
    data = mujoco.MjData(model)
    data.qpos[:3], data.qpos[7:10] = (0.0, 0.0, 0.06), (1.0, 0.0, 0.06)
    come_to_rest(model, data, radius_of(part))
    assert data.time < LONGEST_SETTLING - 1.0
    assert data.qpos[9] < LOST < 0.0 < data.qpos[2]


def far_off(part, shift):
    """The same part, drawn about an origin that is this far off [m]."""
    away = pin.SE3(np.eye(3), np.asarray(shift, float))
    return replace(
        part,
        mesh=Mesh(part.mesh.points + away.translation, part.mesh.triangles),
        pieces=tuple(replace(s, T_owner_shape=away * s.T_owner_shape) for s in part.pieces),
        symmetry=Symmetry(),
        library=GraspLibrary(),
    )


def test_a_part_whose_origin_is_far_off_falls_like_others_and_is_unloaded_like_others(cell):
    part = far_off(cell.parts[0], (0.4, 0.3, -0.5))
    pile = drop_parts((part,) * 5, cell.bin, seed=3)
    assert len(pile) == 5
    floor = cell.bin.T_world_bin.translation[2]
    for lying in pile:
        points = part.mesh.points @ lying.T_world_part.rotation.T + lying.T_world_part.translation
        assert abs(points[:, 2].min() - floor) < 0.06 and points[:, 2].max() - floor < 0.15
    T = pile[0].T_world_part
    way = [T, pin.SE3(T.rotation, T.translation + np.array([0.0, 0.0, 0.1]))]
    rest = unloaded(replace(cell, parts=(part,)), pile, 0, way)
    moved = [
        float(
            np.linalg.norm(
                a.T_world_part.act(part.mesh.middle) - b.T_world_part.act(part.mesh.middle)
            )
        )
        for a, b in zip(rest, pile[1:], strict=True)
    ]
    assert np.median(moved) < 0.005


def test_contacts_for_which_there_is_no_memory_are_an_error(cell, part, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)  # MuJoCo writes a log where it runs
    monkeypatch.setattr(physics, "MEMORY", 1 << 17)
    with pytest.raises(InputError, match="touch at too many points"):
        drop_parts((replace(part),) * 20, cell.bin, seed=3)
