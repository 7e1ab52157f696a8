"""What the search for a handover in the air says, where it is known what it has to."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection
from workbench.studies.picking.exchanges import Exchanges, Got
from workbench.studies.picking.picks import in_the_air

LYING = (np.pi / 2, 0.0, 0.4)


@pytest.fixture(scope="module")
def cell():
    return read_cell("robots/yumi/regrasp.toml")


def asked(cell, x=0.03, y=-0.05, z=0.0191):
    at = cell.bin.T_world_bin.translation + np.array([x, y, z])
    pile = (Detection("keyed_cylinder", pose_from_rpy(at, LYING), 0.9),)
    return Exchanges(cell, pile, 0).try_exchange(0)


def with_some_grasps(cell, names):
    (part,) = cell.parts
    kept = tuple(one for one in part.library.grasps if one.name.startswith(names))
    assert kept
    return replace(cell, parts=(replace(part, library=GraspLibrary(kept)),))


def test_a_part_alone_in_the_bin_goes_from_hand_to_hand(cell):
    assert asked(cell) is Got.OK


def test_two_hands_have_no_room_where_every_grasp_is_at_one_height(cell):
    assert asked(with_some_grasps(cell, ("side-3",))) is Got.HANDS_MEET


def test_what_no_arm_reaches_is_lifted_by_none(cell):
    assert asked(cell, x=1.5) is Got.NOT_LIFTED


def test_without_a_place_no_second_hand_helps(cell):
    none = tuple(replace(arm, part_places=()) for arm in cell.arms)
    assert asked(replace(cell, arms=none)) is Got.NOT_PLACED


def test_an_arm_does_not_hand_over_to_itself(cell):
    """The only arm that has a place is the only one that may take the part from the bin."""
    right, left = cell.arms
    (part,) = cell.parts
    grasps = tuple(replace(one, arms=("right",)) for one in part.library.grasps)
    only = replace(
        cell,
        arms=(right, replace(left, part_places=())),
        parts=(replace(part, library=GraspLibrary(grasps)),),
    )
    assert asked(only) is Got.NOT_PLACED


def test_only_parts_that_are_not_placed_directly_are_asked(cell):
    far = cell.bin.T_world_bin.translation + np.array([1.5, 0.0, 0.0])
    pile = (Detection("keyed_cylinder", pose_from_rpy(far, LYING), 0.9),) * 2
    said = list(in_the_air(cell, pile, ("ok", "out of reach"), ("ok", "out of reach"), 0))
    assert said == ["out of reach; in the air: no hand lifts it out of the bin"]
