"""How parts can stand on a level surface: physics is asked whether they do."""

from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Box, Cylinder, Mesh, pose_from_rpy
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.resting import VERTICAL_TURNS, resting_poses, ways_to_lie

DROP = 0.007
"""[m] The margin of the shipped cells and what a proof lets pass above it."""


def geom(number, solid):
    T, shape = solid.T_owner_shape, solid.shape
    w, x, y, z = np.roll(pin.Quaternion(T.rotation).coeffs(), 1)
    at = f'pos="{" ".join(map(str, T.translation))}" quat="{w} {x} {y} {z}"'
    match shape:
        case Box(size=size):
            how = f'type="box" size="{" ".join(map(str, np.asarray(size) / 2))}"'
        case Cylinder(radius=radius, length=length):
            how = f'type="cylinder" size="{radius} {length / 2}"'
        case Mesh(points=points):
            return (
                f'<geom type="mesh" mesh="m{number}" {at}/>',
                f'<mesh name="m{number}" vertex="{" ".join(map(str, np.ravel(points)))}"/>',
            )
        case _:
            raise AssertionError(shape)
    return f"<geom {how} {at}/>", ""


def settled(part, T):
    """Where physics brings a part that is let go of at T above a level surface."""
    geoms, meshes = zip(*(geom(k, one) for k, one in enumerate(part.pieces)), strict=True)
    model = mujoco.MjModel.from_xml_string(
        f"""<mujoco><option timestep="0.0005"/>
        <default><geom friction="0.4 0.005 0.0001"/></default>
        <asset>{"".join(meshes)}</asset><worldbody><geom type="plane" size="1 1 1"/>
        <body><freejoint/>{"".join(geoms)}</body></worldbody></mujoco>"""
    )
    data = mujoco.MjData(model)
    # MuJoCo moves the frame of a free body, which is that of the part.
    data.qpos[:3] = T.translation
    data.qpos[3:] = np.roll(pin.Quaternion(T.rotation).coeffs(), 1)
    for _ in range(3000):
        mujoco.mj_step(model, data)
    quaternion = pin.Quaternion(np.roll(data.qpos[3:], -1))
    return pin.SE3(quaternion.normalized().matrix(), data.qpos[:3].copy())


def lean(T, U):
    """How far [rad] a part is tilted against how it was."""
    cosine = T.rotation[2] @ U.rotation[2]
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


PARTS = ("keyed_cylinder", "puck", "bracket", "bolt")


@pytest.mark.parametrize("name", PARTS)
def test_a_part_let_go_of_so_stands_so(name):
    part = read_part(name)
    poses = resting_poses(part)
    assert poses
    tried: list[np.ndarray] = []
    for T in poses:
        if any(T.rotation[2] @ known > 1 - 1e-6 for known in tried):
            continue  # turned about the vertical
        tried.append(T.rotation[2].copy())
        up = pin.SE3(T.rotation, T.translation + [0, 0, DROP])
        rests = settled(part, up)
        assert lean(T, rests) < np.deg2rad(2.0), name
        assert np.linalg.norm((rests.translation - T.translation)[:2]) < 0.004, name
        assert abs(rests.translation[2] - T.translation[2]) < 0.001


def test_a_part_on_edge_does_not_stay():
    part = read_part("keyed_cylinder")
    T = resting_poses(part)[0]
    tilted = pose_from_rpy((0, 0, 0.02), (0.6, 0.0, 0.0)) * T
    assert lean(tilted, settled(part, tilted)) > 0.3


@pytest.mark.parametrize("name", PARTS)
def test_the_lowest_points_are_on_the_surface(name):
    part = read_part(name)
    for T in resting_poses(part):
        heights = part.mesh.points @ T.rotation[2] + T.translation[2]
        assert abs(heights.min()) < 1e-6 and (heights < 2e-4).sum() >= 3


def test_turns_that_a_symmetry_makes_alike_are_there_once():
    part = read_cell("yumi").parts[0]
    every = len(resting_poses(part))
    assert every % VERTICAL_TURNS == 0
    fourfold = replace(part, symmetry=Symmetry(fold=4))
    assert len(resting_poses(fourfold)) == every // 4
    round_ = replace(part, symmetry=Symmetry(fold=0))
    assert len(resting_poses(round_)) == every // VERTICAL_TURNS


def test_a_cylinder_stands_on_its_ends_and_would_roll_on_its_side():
    part = read_part("keyed_cylinder")
    assert {round(float(T.rotation[2, 2])) for T in resting_poses(part)} == {-1, 1}


def test_the_same_part_stands_in_the_same_ways():
    one, other = resting_poses(read_part("bracket")), resting_poses(read_part("bracket"))
    assert len(one) == len(other)
    for T, U in zip(one, other, strict=True):
        np.testing.assert_array_equal(T.homogeneous, U.homogeneous)


def test_a_flat_part_mostly_lies_flat():
    ups, often = ways_to_lie(read_part("puck"))
    assert often.sum() == pytest.approx(1.0)
    flat = np.abs(ups[:, 2]) > 0.99
    assert flat.sum() == 2 and often[flat].sum() > 0.8


def test_a_cylinder_mostly_lies_on_its_side():
    ups, often = ways_to_lie(read_part("keyed_cylinder"))
    assert often[np.abs(ups[:, 2]) < 0.1].sum() > 0.8
