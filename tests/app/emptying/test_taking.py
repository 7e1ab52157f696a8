"""A plan carried out against the truth."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.emptying.taking import carried_out, failure, in_turn
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


@pytest.fixture(scope="module")
def lying(cell):
    """One cylinder flat on the floor in the middle of the bin."""
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.019), (0, np.pi / 2, 0))
    return (Detection("keyed_cylinder", T),)


@pytest.fixture(scope="module")
def arm_plan(cell, lying):
    plan = plan_pick(cell, lying, "test").plan
    assert plan is not None
    (only,) = in_turn(plan)
    return only


def moved(lying, xyz) -> tuple[Detection, ...]:
    T = pin.SE3(np.eye(3), np.array(xyz, dtype=float)) * lying[0].T_world_part
    return (replace(lying[0], T_world_part=T),)


def test_a_part_that_lies_where_it_was_found_is_taken_without_a_touch(cell, lying, arm_plan):
    taking = carried_out(cell, lying, arm_plan, lying[0])
    assert (taking.number, taking.is_straight, taking.touches) == (0, True, 0)
    up = taking.way[-1].translation - taking.way[0].translation
    assert up[2] > 0.05


def test_a_part_a_little_way_off_is_gripped_crooked(cell, lying, arm_plan):
    taking = carried_out(cell, moved(lying, (0.004, 0, 0)), arm_plan, lying[0])
    assert (taking.number, taking.is_straight) == (0, False)


def test_a_part_that_lies_as_found_but_for_its_roll_is_told_apart(cell, lying, arm_plan):
    def rolled(degrees: float) -> tuple[Detection, ...]:
        roll = pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(degrees)))
        return (replace(lying[0], T_world_part=lying[0].T_world_part * roll),)

    turned = carried_out(cell, rolled(20), arm_plan, lying[0])
    assert (turned.number, turned.is_straight, turned.is_turned) == (0, False, True)
    aside = carried_out(cell, moved(rolled(20), (0.004, 0, 0)), arm_plan, lying[0])
    assert (aside.is_straight, aside.is_turned) == (False, False)
    # Its pads lie beside the key: they hold it so, too.
    assert turned.is_held and failure(turned, replace(lying[0], roll_known=False)) == ""
    loose = replace(turned, is_held=False)
    assert failure(loose, replace(lying[0], roll_known=False)) == "turned"
    assert failure(turned, lying[0]) == failure(aside, lying[0]) == "crooked"
    far = carried_out(cell, moved(lying, (0.03, 0, 0)), arm_plan, lying[0])
    assert failure(far, lying[0]) == "missed"


def test_a_part_that_the_grip_does_not_hold_slips_where_force_and_friction_are_stated(
    cell, lying, arm_plan
):
    def with_numbers(force: float | None, friction: float | None):
        part = replace(cell.part("keyed_cylinder"), friction=friction)
        arms = tuple(replace(arm, tool=replace(arm.tool, force=force)) for arm in cell.arms)
        return replace(cell, arms=arms, parts=(part,))

    weak = carried_out(with_numbers(1.0, 0.1), lying, arm_plan, lying[0])
    assert weak.is_straight and weak.slips and failure(weak, lying[0]) == "slipped"
    firm = carried_out(with_numbers(400.0, 0.8), lying, arm_plan, lying[0])
    assert firm.is_straight and not firm.slips and failure(firm, lying[0]) == ""
    for unstated in (with_numbers(1.0, None), with_numbers(None, 0.1)):
        assert failure(carried_out(unstated, lying, arm_plan, lying[0]), lying[0]) == ""


def test_fingers_close_on_nothing_where_no_part_of_that_kind_is(cell, lying, arm_plan):
    far = carried_out(cell, moved(lying, (0.03, 0, 0)), arm_plan, lying[0])
    assert (far.number, far.way) == (None, ())


def test_what_the_hand_runs_into_is_counted(cell, lying, arm_plan):
    hand = carried_out(cell, lying, arm_plan, lying[0]).way[0]
    over = pin.SE3(hand.rotation, hand.translation + np.array([0.0, 0.0, 0.035]))
    truth = (*lying, Detection("keyed_cylinder", over))
    assert carried_out(cell, truth, arm_plan, lying[0]).touches > 0
