"""Where a part is put down: the straight way to a place, and the hand's straight way out again."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import chain as one_by_one

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.geometry import Floats
from workbench.planning.collision.bodies import part_label
from workbench.planning.collision.legs import hand_turns
from workbench.planning.collision.motion import path_contact
from workbench.planning.collision.pairing import Phase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution
from workbench.planning.kinematics.straight import follow
from workbench.planning.picking.leaving import comes_back

PLACE_LIFT = 0.05
"""[m] The last straight way down to the place."""

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class PutDown:
    """Straight ways (m, n) [rad]: `down` to a place, and `out` of there with the empty hand.

    There is one row in `out` where the place is at home.
    """

    down: Floats
    out: Floats


def ways_down(world: World, arm: Arm, phase: Phase, q_from: Floats) -> Iterator[Floats | Verdict]:
    """The straight ways down (m, n) to the places of an arm, in order; what speaks against others.

    Args:
        world: is put into the phase whenever something is looked at in it.
        arm: that brings a part.
        phase: of doing so.
        q_from: (n,) [rad] where the arm comes from.
    """
    policy, base = world.policy, world.configuration({})
    chain, columns = world.chains[arm.name], world.kinematics.columns[arm.name]
    for T_world_place in arm.Ts_world_place:
        for T_world_tcp in (T_world_place * T for T in hand_turns(arm)):
            met = _standing_in(world, arm, phase, T_world_tcp)
            if met is not None:
                yield Verdict(Reason.NO_PLACE, Stage.PLACE, met)
                continue
            answers, residuals = chain.solve(T_world_tcp, np.vstack([q_from, arm.home]))
            for q in answers[is_solution(residuals)]:
                above = _raised(T_world_tcp)
                path, share = follow(chain, world.motion.rounded(q), above, policy.straight_points)
                if share < 1.0:
                    note = f"the arm can follow only {share:.0%} of the line"
                    yield Verdict(Reason.NO_PLACE, Stage.PLACE, q=path[-1], note=note)
                    continue
                path = world.motion.rounded(path[::-1])
                world.enter(phase)
                found = path_contact(world, columns, base, path, policy.zone)
                if found is None:
                    yield path
                else:
                    pair, distance = found[0].pair, found[0].distance
                    yield Verdict(Reason.NO_PLACE, Stage.PLACE, pair, distance, found[1])


def _standing_in(
    world: World, arm: Arm, phase: Phase, T_world_tcp: pin.SE3
) -> tuple[str, str] | None:
    """What the part in the hand would stand in at a place, whatever the arm does: two labels.

    Most places that do not work are refused by it, and it is cheap.
    """
    number, T_tcp_part = phase.held[arm.name]
    label = world.part_ways.standing_in(number, T_world_tcp * T_tcp_part, world.policy.margin)
    return None if label is None else (part_label(number), label)


def put_down(world: World, pick: Pick, others: Phase) -> PutDown | Verdict:
    """A way to a place and out of there, beside what other arms have placed.

    That of the pick comes first.

    Args:
        world: of the cell and the detections that the pick was made from.
        pick: what is to be put down.
        others: what is true of the other arms meanwhile.
    """
    arm, grasp = world.arm(pick.candidate.arm), pick.candidate.grasp
    held = (pick.candidate.detection, pick.T_tcp_part)
    moving = frozenset({arm.name})
    brings = replace(
        others,
        moving=moving,
        openings={**others.openings, arm.name: grasp.grip},
        held={arm.name: held},
    )
    refusal: Verdict | None = None
    for down in one_by_one([pick.place], ways_down(world, arm, brings, pick.extract[-1])):
        if isinstance(down, Verdict):
            refusal = refusal or down
            continue
        world.enter(brings)
        met = _met(world, arm, down)
        if met is None and np.array_equal(down[-1], home_of(world, arm)):
            return PutDown(down, down[-1:])
        if met is None:
            leaves = replace(
                others,
                moving=moving,
                openings={**others.openings, arm.name: grasp.opening},
                placed={**others.placed, arm.name: (*held, down[-1])},
            )
            out = _way_out(world, pick, arm, leaves, down[-1])
            if not isinstance(out, Verdict):
                return PutDown(down, out)
            met = out
        refusal = refusal or met
    return refusal or Verdict(Reason.NO_PLACE, Stage.PLACE)


def home_of(world: World, arm: Arm) -> Floats:
    """Where an arm is at home (n,) [rad], as far as that can be sent."""
    chain = world.chains[arm.name]
    return np.clip(world.motion.rounded(np.asarray(arm.home)), chain.lower, chain.upper)


def _raised(T_world_tcp: pin.SE3) -> pin.SE3:
    return pin.SE3(T_world_tcp.rotation, T_world_tcp.translation + PLACE_LIFT * UP)


def _met(world: World, arm: Arm, path: Floats) -> Verdict | None:
    """What a way to a place meets of what other arms have placed; the rest is known to be clear."""
    among = world.pairs.to_placed(arm.name)
    if len(among) == 0:
        return None
    columns, base = world.kinematics.columns[arm.name], world.configuration({})
    found = path_contact(world, columns, base, path, world.policy.zone, among=among)
    if found is None:
        return None
    contact, q, _ = found
    return Verdict(Reason.NO_PLACE, Stage.PLACE, contact.pair, contact.distance, q)


def _way_out(world: World, pick: Pick, arm: Arm, phase: Phase, q_place: Floats) -> Floats | Verdict:
    """The straight way (m, n) of the open hand out of where it has put the part down.

    It goes out as it had come to the part in the bin; where that is not possible, straight up.
    """
    policy, base = world.policy, world.configuration({})
    chain, columns = world.chains[arm.name], world.kinematics.columns[arm.name]
    T_grasp_pregrasp = chain.pose(pick.q_grasp).actInv(chain.pose(np.asarray(pick.approach[0])))
    T_world_tcp = chain.pose(q_place)
    refusal: Verdict | None = None
    for T_world_out in (T_world_tcp * T_grasp_pregrasp, _raised(T_world_tcp)):
        path, share = follow(chain, q_place, T_world_out, policy.straight_points)
        if share < 1.0:
            note = f"the hand can follow only {share:.0%} of its way out"
            refusal = refusal or Verdict(Reason.NO_PLACE, Stage.PLACE, q=path[-1], note=note)
            continue
        path = world.motion.rounded(path)
        world.enter(phase)
        world.allow_start_contacts(world.configuration({arm.name: q_place}))
        found = path_contact(world, columns, base, path, policy.zone)
        found = found or comes_back(world, (arm.name,), columns, base, path)
        if found is None:
            return path
        contact, q, _ = found
        note = "on the hand's way out"
        refusal = refusal or Verdict(
            Reason.NO_PLACE, Stage.PLACE, contact.pair, contact.distance, q, note
        )
    return refusal or Verdict(Reason.NO_PLACE, Stage.PLACE)
