"""Whether a hand takes a part alike at every turn about its axis."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Box, Mesh, Solid, pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, Part
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry, make_turn
from workbench.planning.grasps.roll_symmetry import uneven

Z = np.array([0.0, 0.0, 1.0])


@pytest.fixture(scope="module")
def arm():
    return read_cell("yumi").arms[0]


@pytest.fixture(scope="module")
def part():
    return read_cell("robots/yumi/full_bin.toml").parts[0]


def rolled(part: Part) -> Detection:
    return Detection(part.name, pin.SE3.Identity(), roll_known=False)


def problems(part, arm, grasp):
    return [
        None if one is None else str(one.message) for one in uneven(part, rolled(part), arm, grasp)
    ]


def named(part, name):
    return next(grasp for grasp in part.grasps if grasp.name == name)


def test_beside_the_key_every_turn_will_do_and_on_it_none(part, arm):
    for name in ("side-1-1", "side-3-2", "end-1-1"):
        assert problems(part, arm, named(part, name))[0] is None, name
    on_key = uneven(part, rolled(part), arm, named(part, "key"))[0]
    assert on_key is not None and on_key.amount > 0.003
    assert "closed to 8 mm" in str(on_key.message) and "inside the part" in str(on_key.message)
    last = named(part, "side-3-1")  # its pads end 3 mm before the key
    overlaps = [replace(last, T_part_tcp=pose_from_rpy((0, 0, z)) * last.T_part_tcp)
                for z in (0.0025, 0.004)]  # fmt: skip
    assert [problems(part, arm, one)[0] is None for one in overlaps] == [True, False]


def test_a_hand_that_leans_over_the_key_is_told_from_the_same_upright(part, arm):
    """Of the ways of one grasp some will do: the fingers of others pass where the key may be."""
    found = problems(part, arm, named(part, "around-4-1"))
    assert found[0] is None and any(found)


def test_what_is_right_does_not_depend_on_the_turn_as_found(part, arm):
    for name in ("side-1-2", "key", "beside_key-1-1"):
        grasp = named(part, name)
        told = [one is None for one in problems(part, arm, grasp)]
        for angle in (0.4, 2.0, 4.4):
            other = replace(grasp, T_part_tcp=make_turn(Z, angle) * grasp.T_part_tcp)
            assert [one is None for one in problems(part, arm, other)] == told


def plate(half: float) -> Part:
    """A rod with wings of little thickness: across them it is wide at some turns only."""
    size = np.array([0.03, 2 * half, 0.06])
    surface = trimesh.creation.box(size)
    mesh = Mesh(surface.vertices, surface.faces)
    solid = Solid("plate", Box(size), pin.SE3.Identity())
    return Part("plate", mesh, (solid,), 0.1, Symmetry(), GraspLibrary())


def test_what_is_narrower_at_another_turn_slips_out(arm):
    """Nothing is cut at any turn, since the grip is wide: at most turns it holds nothing."""
    grasp = Grasp("wide", pose_from_rpy((-0.003, 0, 0), (0, -np.pi / 2, 0)), 0.045, 0.0335)
    (text, *_) = problems(plate(0.0035), arm, grasp)
    assert text is not None and "wide between the fingers" in text


def test_a_cup_has_to_seal_at_every_turn():
    cell = read_cell("tx2_90")
    (arm, *_), (puck, *_) = cell.arms, cell.parts
    assert set(problems(puck, arm, puck.grasps[0])) == {None}
    beside = pose_from_rpy((0.01, 0, 0)) * puck.grasps[0].T_part_tcp
    tilted = make_turn(np.array([1.0, 0.0, 0.0]), 0.1)
    assert set(problems(puck, arm, replace(puck.grasps[0], T_part_tcp=tilted * beside))) != {None}
    wings, on_top = plate(0.02), Grasp("top", pose_from_rpy((0, 0, 0.03), (np.pi, 0, 0)), 0.0, 0.0)
    (text, *_) = problems(wings, arm, on_top)
    assert text is not None and "of the lip of the cup" in text
