"""Where something that was not found may go on unseen, plans do not go if there is another way."""

import numpy as np
import pytest

from workbench.app.picking.row import plan_row, prove_row
from workbench.formats.cells.reading import read_cell
from workbench.model.derived.row_parts import parts_taken
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Obstacle

CELL = read_cell("yumi")


def lying(x, y, yaw):
    place = CELL.bin.T_world_bin.translation + np.array([x, y, 0.0191])
    return Detection("keyed_cylinder", pose_from_rpy(place, (np.pi / 2, 0.0, yaw)), 0.9)


PARTS = lying(-0.05, -0.08, 0.4), lying(0.05, 0.08, -0.6)


def beside(part):
    """Boxes around a part, up to its height: every finger that takes it goes into one."""
    around = (0.045, 0.0), (-0.045, 0.0), (0.0, 0.045), (0.0, -0.045)
    here = part.T_world_part.translation - (0.0, 0.0, 0.002)
    size = np.array([0.04, 0.04, 0.034])
    return tuple(Obstacle(pose_from_rpy(here + (*by, 0.0)), size) for by in around)


def planned(parts, unseen, **about):
    return plan_row(CELL, parts, digest_of(parts), unseen=unseen, **about)


@pytest.mark.parametrize("other", [0, 1])
def test_the_part_is_taken_beside_which_nothing_may_be(other):
    result = planned(PARTS, beside(PARTS[1 - other]), strategy="auto")
    assert parts_taken(result.plan, result.plan) == (other,)
    assert not result.plan.goes_unseen
    assert result.proof.holds


def test_where_there_is_no_other_way_the_plan_says_so_and_is_the_same_plan():
    result = planned(PARTS[:1], beside(PARTS[0]))
    assert result.plan.goes_unseen
    plain = planned(PARTS[:1], ())
    assert not plain.plan.goes_unseen
    assert result.plan.digest == plain.plan.digest, "a remark makes no other plan"
    assert result.proof.digest == plain.proof.digest
    assert result.proof.holds and result.proof.plan_digest == result.plan.digest
    (proven,) = prove_row(CELL, result.plans)
    assert proven.proof.holds


def test_a_plan_that_stays_clear_of_all_is_the_same_as_without():
    below = PARTS[0].T_world_part.translation - (0.0, 0.0, 0.5)
    far = Obstacle(pose_from_rpy(below), np.full(3, 0.1))
    kept, plain = planned(PARTS, (far,)), planned(PARTS, ())
    assert kept.plan.arms[0].grasp == plain.plan.arms[0].grasp
    assert kept.plan.notes == plain.plan.notes
