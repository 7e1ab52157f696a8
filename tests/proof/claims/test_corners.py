"""Corners: what a controller that stops at waypoints does there, and one that rounds them."""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_leg
from blend_curves import curves_of

from workbench.app.core.cycle.approval import approve
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import Guarantee, are_in_step
from workbench.model.scan import Detection
from workbench.planning.collision.legs import stretches
from workbench.planning.collision.motion import chain_contact, segment
from workbench.planning.collision.world import World
from workbench.planning.kinematics.execution import compute_times
from workbench.plugins.robot_link import spoken_to_by

PROTOCOLS = ["abb-socket", "abb-socket/2"]
ZONE = 0.2


def entered(cell, plan, arm: str, name: str):
    """A world in the phase of a leg, and all joints where they are then."""
    world = World(cell, plan.detections)
    stretch = next(
        one for one in stretches(plan) if any((p.arm, g.name) == (arm, name) for p, g in one.runs)
    )
    world.enter(stretch.phase)
    return world, world.configuration(stretch.standing)


def spike(world, base, arm: str, q, pair: tuple[str, str], among=None):
    """Waypoints from `q` to where `pair` meets and back, the rounded corner clear; [first, deep].

    A corner is rounded by a tenth of the way to it: the deep waypoint lies a twentieth of the way
    behind the contact.
    """
    chain, columns = world.chains[arm], world.kinematics.columns[arm]
    rng, alone = np.random.default_rng(0), world.pairs.alone(arm)
    for _ in range(4000):
        goal = q + rng.normal(0.0, 1.0, len(q))
        if np.any(goal < chain.lower) or np.any(goal > chain.upper):
            continue
        found = chain_contact(world, columns, base, segment(q, goal), among=among)
        if found is None or not all(any(part in label for label in found[0].pair) for part in pair):
            continue
        low, high = 0.0, 1.0
        while high - low > 1e-3:
            middle = (low + high) / 2
            way = segment(q, q + middle * (goal - q))
            is_clear = chain_contact(world, columns, base, way, among=among) is None
            low, high = (middle, high) if is_clear else (low, middle)
        deep = world.motion.rounded(q + 1.05 * high * (goal - q))
        if 1.05 * high > 1.0 or np.linalg.norm(deep - q) < 0.4:
            continue
        inside = base.copy()
        inside[columns] = deep
        if world.contact(inside) is None:
            continue
        rounded = curves_of(np.array([q, deep, q]), ZONE)
        if chain_contact(world, columns, base, rounded) is not None:
            continue
        if (
            among is None
            or chain_contact(world, columns, base, segment(q, deep), among=alone) is None
        ):
            return deep
    raise AssertionError(f"no way from here brings {pair} together")


def with_spike(plan, arm: str, name: str, number: int, deep):
    """The plan with a way to `deep` and back at a waypoint of a leg, in ample time."""
    leg = plan.arm(arm).leg(name)
    q = np.insert(leg.q, [number + 1, number + 1], [deep, leg.q[number]], axis=0)
    t = np.insert(leg.t, [number + 1, number + 1], leg.t[number] + [10.0, 20.0])
    t[number + 3 :] += 20.0
    return with_leg(plan, arm, name, q=q, t=t)


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize(
    ("pair", "name"), [(("left_link", "left_link"), "home"), (("left", "bin_wall"), "reach")]
)
def test_a_waypoint_inside_something_is_found_though_the_rounded_corner_is_clear(
    cell, result, protocol, pair, name
):
    arm = "left"
    number = min(3, len(result.plan.arm(arm).leg(name).q) - 2)
    q = np.asarray(result.plan.arm(arm).leg(name).q[number])
    world, base = entered(spoken_to_by(cell, "abb-socket/2"), result.plan, arm, name)
    deep = spike(world, base, arm, q, pair)
    inside = base.copy()
    inside[world.kinematics.columns[arm]] = deep
    assert world.contact(inside) is not None
    proof = prove(spoken_to_by(cell, protocol), with_spike(result.plan, arm, name, number, deep))
    (violation,) = [one for one in proof.violations if one.pair is not None]
    assert (violation.arm, violation.leg) == (arm, name)
    assert violation.distance < cell.policy.margin


@pytest.fixture(scope="module")
def coordinated(cell):
    floor = cell.bin.T_world_bin.translation
    ends = [
        pose_from_rpy(floor + [0.0, y, 0.0191], (np.pi / 2, 0.0, np.pi / 2)) for y in (-0.1, 0.1)
    ]
    parts = tuple(Detection(cell.parts[0].name, T_world_part) for T_world_part in ends)
    return plan_pick(cell, parts, "scan", strategy="coordinated", seed=0).plan


@pytest.mark.parametrize("protocol", PROTOCOLS)
@pytest.mark.parametrize("guarantee", [Guarantee.TIME_INDEPENDENT, Guarantee.SYNCHRONISED])
def test_arms_that_meet_at_a_sharp_corner_only_are_found(cell, coordinated, protocol, guarantee):
    first, second = coordinated.sequence[-1].runs
    assert {first[1], second[1]} == {"home"}
    legs = [coordinated.arm(arm).leg("home") for arm, _ in (first, second)]
    world, base = entered(cell, coordinated, first[0], "home")
    number = len(legs[1].q) - 2
    post = np.asarray(legs[1].q[number])
    base[world.kinematics.columns[second[0]]] = post
    q = np.asarray(legs[0].q[number])
    deep = spike(world, base, first[0], q, ("right", "left"), world.pairs.between())
    bent = with_spike(coordinated, first[0], "home", number, deep)
    if guarantee is Guarantee.SYNCHRONISED:
        # The other arm stands meanwhile, and passes its waypoints at the same times.
        bent = with_spike(bent, second[0], "home", number, post)
        bent = with_leg(bent, second[0], "home", t=bent.arm(first[0]).leg("home").t)
        assert are_in_step([bent.arm(arm).leg("home") for arm, _ in (first, second)])
    proof = prove(spoken_to_by(cell, protocol), replace(bent, guarantee=guarantee))
    violation = next(one for one in proof.violations if one.pair is not None)
    assert {label.split("_")[0].split()[0] for label in violation.pair} == {"right", "left"}


def test_a_plan_for_a_controller_that_stops_takes_the_time_of_the_stops(cell, detections):
    stopping = spoken_to_by(cell, "abb-socket")
    result = plan_pick(stopping, detections, "scan", strategy="alternated", seed=0)
    assert result.proof.holds, result.proof.violations
    for one in result.plan.arms:
        arm = cell.arm(one.arm)
        speed = cell.robot.limits(arm.joints)[2] * cell.policy.speed
        for leg in one.legs:
            stops = compute_times(np.asarray(leg.q), speed, np.asarray(arm.acceleration), 0.0)
            np.testing.assert_allclose(leg.t, stops)


def test_what_was_proven_with_stops_is_not_approved_for_a_controller_that_rounds(cell, detections):
    stopping, rounding = (spoken_to_by(cell, protocol) for protocol in PROTOCOLS)
    # A controller that stops moves one arm at a time.
    result = plan_pick(stopping, detections, "scan", strategy="alternated", seed=0)
    with_stops, rounded = prove(stopping, result.plan), prove(rounding, result.plan)
    assert with_stops.holds and rounded.holds
    with pytest.raises(CommandRefused, match=r"rounds corners by 0\.2"):
        approve(rounding, result.plan, with_stops, "ada", 0.0)
    assert approve(rounding, result.plan, rounded, "ada", 0.0).proof_digest == rounded.digest
    assert approve(stopping, result.plan, with_stops, "ada", 0.0).proof_digest == with_stops.digest
    # Sharp corners are part of what was walked.
    assert approve(stopping, result.plan, rounded, "ada", 0.0).proof_digest == rounded.digest


def test_a_cell_with_zone_0_stops_in_either_protocol(cell):
    sharp = replace(cell, policy=replace(cell.policy, zone=0.0))
    assert [spoken_to_by(sharp, protocol).zone for protocol in PROTOCOLS] == [0.0, 0.0]
    assert [spoken_to_by(cell, protocol).zone for protocol in PROTOCOLS] == [0.0, ZONE]
