"""Energy in a contact: by hand, as a limit of speed, and in a plan that is proven."""

import math
from dataclasses import replace

import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.derived.speed_limits import (
    effective_mass,
    energy_speed,
    limits_speed,
    speed_limits,
)
from workbench.model.messages.proofs import ProofText
from workbench.perception.simulation.piles import drop_parts
from workbench.proof.claims.prove import prove


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


def limited(cell, energy, mass=9.0):
    arms = tuple(replace(arm, moving_mass=mass) for arm in cell.arms)
    return replace(cell, arms=arms, policy=replace(cell.policy, contact_energy=energy))


def test_half_of_the_arm_counts_and_all_that_it_carries(cell):
    cell = limited(cell, 0.5)
    arm = cell.arms[0]
    heaviest = max(part.mass for part in cell.parts)
    assert effective_mass(cell, arm, False) == pytest.approx(4.5 + arm.tool.mass)
    assert effective_mass(cell, arm, True) == pytest.approx(4.5 + arm.tool.mass + heaviest)


def test_the_speed_has_just_that_energy(cell):
    cell = limited(cell, 0.5)
    for holding in (False, True):
        mass, speed = (of(cell, cell.arms[0], holding) for of in (effective_mass, energy_speed))
        assert mass * speed**2 / 2 == pytest.approx(0.5)
        assert speed_limits(cell, cell.arms[0], holding)[1] == speed


def test_without_masses_or_a_limit_nothing_is_limited(cell):
    assert effective_mass(cell, cell.arms[0], True) is None
    assert not limits_speed(cell) and not limits_speed(limited(cell, None))
    assert energy_speed(limited(cell, None), cell.arms[0], True) == math.inf
    assert limits_speed(limited(cell, 0.5))


def test_a_plan_keeps_the_energy_and_a_quicker_one_is_refused(cell):
    slow = limited(cell, 0.2)
    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=3)
    usual = plan_pick(cell, pile, "scan", strategy="right", seed=0)
    found = plan_pick(slow, pile, "scan", strategy="right", seed=0)
    assert found.proof.holds and found.plan.cycle_seconds > usual.plan.cycle_seconds
    assert max(bound.energy for bound in found.proof.speeds) <= 0.2 + 1e-9
    quick = replace(usual.plan, cell_digest=slow.digest)
    texts = {v.problem.text for v in prove(slow, quick.scene, quick).violations}
    assert texts == {ProofText.POINT_TOO_FAST}
