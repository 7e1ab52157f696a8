"""Plans of a row warn of parts that will mate too seldom with what stands there."""

from dataclasses import replace

import numpy as np
import pytest
from assembling import assembly_cell, insertion, placed_bolt, standing_spacer, with_insertion

from workbench.app.picking.row import plan_row
from workbench.app.picking.stations import put_down
from workbench.model.messages.grasps import BudgetText
from workbench.model.messages.plans import PlanNote
from workbench.model.recipes.joint import PlacingError
from workbench.planning.placing.assembling import base_errors, mating_notes, placing_error
from workbench.planning.placing.budget import budget_by

EXACT = PlacingError(np.zeros((6, 6)), np.zeros((6, 6)))


@pytest.fixture(scope="module")
def cell():
    return assembly_cell()


@pytest.fixture(scope="module")
def sure(cell):
    """A spacer that the search has found to a tenth of a millimetre and degree."""
    lying = standing_spacer(cell)
    deviations = [1e-4] * 3 + [np.deg2rad(0.1)] * 3
    return replace(lying, covariance=np.diag(np.square(deviations)))


@pytest.fixture(scope="module")
def plan(cell, sure):
    result = plan_row(cell, (sure,), "scan", obstacles=placed_bolt(cell), bases={"bolt": EXACT})
    assert result.plan is not None
    return result.plan


def notes(cell, plan, bases):
    return [str(note) for note in mating_notes(cell, plan, bases)]


def test_a_plan_warns_only_where_too_few_parts_will_mate(cell, plan):
    assert not any(note.text is PlanNote.MATES_SELDOM for note in plan.notes)
    off = PlacingError(np.zeros((6, 6)), np.diag(np.square([2e-3] * 3 + [0.01] * 3)))
    (warning,) = notes(cell, plan, {"bolt": off})
    assert "of picks mate spacer with bolt, 95% are asked for" in warning
    # Of a base of which nothing is known nothing is said, nor of a joint that nobody states.
    assert (
        notes(cell, plan, {}) == notes(with_insertion(cell, joint=None), plan, {"bolt": off}) == []
    )
    joint = replace(insertion(cell).joint, share=0.01)
    assert notes(with_insertion(cell, joint=joint), plan, {"bolt": off}) == []


def test_a_row_carries_the_warning_and_its_plan_stays_the_same(cell, sure, plan):
    off = PlacingError(np.zeros((6, 6)), np.diag(np.square([2e-3] * 3 + [0.01] * 3)))
    bases = {"bolt": off}
    result = plan_row(cell, (sure,), "scan", obstacles=placed_bolt(cell), bases=bases)
    assert result.plan is not None and result.plan.digest == plan.digest
    assert PlanNote.MATES_SELDOM in [note.text for note in result.plan.notes]


def test_a_candidate_states_how_many_parts_will_mate(cell, sure, plan):
    (arm_plan,) = plan.arms
    asked = cell, sure, arm_plan.arm, arm_plan.T_tcp_part.inverse()
    assert budget_by(*asked).chance is None
    budget = budget_by(*asked, {"bolt": EXACT})
    assert budget.chance is not None and budget.chance > 0.95
    assert budget.words.text is BudgetText.MATES
    assert "of picks mate with bolt" in str(budget.words)


def test_what_is_put_down_brings_its_error_along(cell, sure, plan):
    (put,) = put_down(cell, plan)
    (arm_plan,) = plan.arms
    budget = budget_by(cell, sure, arm_plan.arm, arm_plan.T_tcp_part.inverse())
    known = base_errors(cell, [put])["spacer"]
    assert np.array_equal(known.covariance, budget.error.covariance)
    assert np.array_equal(known.by_scanner, budget.error.by_scanner)
    # Nothing is known of one that may be there or not.
    assert base_errors(cell, [replace(put, score=0.0)]) == {}


def test_a_nest_that_centres_a_part_leaves_what_it_says(cell, plan):
    place = replace(cell.arm("right").part_places[0], centred=(2e-4, 0.01))
    right = replace(cell.arm("right"), part_places=(place,))
    nested = replace(cell, arms=(right, *cell.arms[1:]))
    bolt = replace(standing_spacer(cell), part="bolt")
    arm_plan = replace(plan.arms[0], arm="right")
    found = placing_error(nested, bolt, arm_plan, place.T_world_part)
    assert not found.by_scanner.any()
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx([2e-4] * 3 + [0.01] * 3)
