"""Where a part is put down: the linear motion to a place, and that of the hand out again."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain as one_by_one
from itertools import groupby
from operator import itemgetter
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.derived.assembling import insertion_of
from workbench.model.derived.upright import leans_too_far
from workbench.model.geometry import Floats
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import DOWN, PLACE_LIFT, PartPlace
from workbench.planning.collision.bodies import part_label
from workbench.planning.collision.legs import hand_turns
from workbench.planning.collision.motion import arm_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.unknown_rolls import axis_of
from workbench.planning.collision.world import World
from workbench.planning.grasps.put_poses import suits_any_roll, ways_to_lie
from workbench.planning.kinematics.inverse import configurations
from workbench.planning.kinematics.quickness import draw_towards, pace_of, seconds_to_all
from workbench.planning.kinematics.straight import follow
from workbench.planning.picking.leaving import along_placed, find_contact_after_release, is_around
from workbench.planning.placing.assembling import arm_placing
from workbench.planning.placing.pallets import open_places, why_full
from workbench.planning.planners.clock import processor_time

DRAWN = 4
"""The soonest configurations at a place that are moved in their null space to come sooner."""

FARTHER = 2.0
"""Times the last motion to a place that a hand goes back whose fingers reach around a part."""

LATE = Verdict(Reason.OUT_OF_TIME, Stage.PLACE)


@dataclass(frozen=True, slots=True, eq=False)
class PutDown:
    """Linear motions (m, n) [rad]: `down` to a place, and `out` of there with the empty hand.

    There is one row in `out` where the place is at home.
    """

    down: Floats
    out: Floats


def plan_straight_descents(
    world: World, arm: Arm, phase: LegPhase, q_from: Floats, near: Floats | None = None
) -> Iterator[Floats | Verdict]:
    """The linear motions (m, n) to the places of an arm, in order; what speaks against others.

    Those where the part has to lie in a certain way come first, those of the hand behind them.

    Args:
        world: is put into the phase whenever something is checked in it.
        arm: that brings a part.
        phase: of doing so.
        q_from: (n,) [rad] where the arm comes from.
        near: (k, n) [rad] configurations at places, where some are known.
    """
    starts = np.vstack([q_from, arm.home, (q_from + arm.home) / 2])
    for hands in _hands(world, arm, phase):
        if processor_time() > world.deadline:
            yield LATE
            return
        if isinstance(hands, Verdict):
            yield hands
        else:
            some = starts if near is None else np.vstack([starts, near])
            yield from _straight(world, arm, phase, hands, some)


class _Hands(NamedTuple):
    """Possible poses of a hand at a place.

    The last motion to it is `way` (3,) [m] in the world.
    """

    Ts_world_tcp: Sequence[pin.SE3]
    way: Floats = PLACE_LIFT * np.array(DOWN)


def _hands(world: World, arm: Arm, phase: LegPhase) -> Iterator[_Hands | Verdict]:
    """Where the hand would be at each place; or that the part stands in things.

    Places of the hand that differ in nothing but how it is turned are one.
    """
    number, T_tcp_part = phase.held[arm.name]
    for place in open_places(world, arm, number, phase):
        for T_world_part in _ways_at(world, place, number):
            if isinstance(T_world_part, Verdict):
                yield T_world_part
                continue
            T_world_tcp = T_world_part * T_tcp_part.inverse()
            refusal = _refuse_there(world, phase, arm, T_world_tcp)
            yield refusal or _Hands([T_world_tcp], place.length * np.array(place.approach))
    for _, turned in groupby(arm.Ts_world_place, key=lambda T: tuple(T.translation)):
        free: list[pin.SE3] = []
        for T_world_tcp in (T * T_turn for T in turned for T_turn in hand_turns(arm.tool)):
            refusal = _refuse_there(world, phase, arm, T_world_tcp)
            if refusal is None:
                free.append(T_world_tcp)
            else:
                yield refusal
        if free:
            yield _Hands(free)


def ways_at_places(world: World, arm: Arm, number: int) -> Iterator[pin.SE3 | Verdict]:
    """How a part found may lie at the places open to it, as T_world_part, in order.

    A place where a turn that nobody knows would matter is refused.
    """
    for place in open_places(world, arm, number):
        yield from _ways_at(world, place, number)


def _ways_at(world: World, place: PartPlace, number: int) -> Iterator[pin.SE3 | Verdict]:
    detection = world.detections[number]
    part = world.cell.part(detection.part)
    if detection.roll_known or suits_any_roll(place, part.symmetry, axis_of(part, detection)):
        yield from ways_to_lie(place, part.symmetry)
    else:
        note = VerdictNote.PLACE_NEEDS_ROLL()
        yield Verdict(Reason.ROLL_UNKNOWN, Stage.PLACE, note=note)


def _straight(
    world: World, arm: Arm, phase: LegPhase, hands: _Hands, starts: Floats
) -> Iterator[Floats | Verdict]:
    """The linear motions (m, n) to a place, and what speaks against others.

    That comes first which is soonest reached from where the arm comes from, the first of the
    `starts`, and left for home.
    """
    policy, chain, number = world.policy, world.chains[arm.name], phase.held[arm.name][0]
    pace, stops = pace_of(chain, policy.speed), np.stack([starts[0], arm.home])
    found: list[tuple[float, Floats, pin.SE3]] = []
    for T_world_tcp in hands.Ts_world_tcp:
        solved = configurations(chain, T_world_tcp, starts).q
        found += [
            (s, q, T_world_tcp)
            for s, q in zip(seconds_to_all(solved, stops, pace), solved, strict=True)
        ]
    found.sort(key=itemgetter(0))
    soonest: list[tuple[float, Floats, pin.SE3]] = []
    for _, q, T_world_tcp in found[:DRAWN]:
        nearer = draw_towards(chain, T_world_tcp, q[None], stops, pace)
        soonest.append((float(seconds_to_all(nearer, stops, pace)[0]), nearer[0], T_world_tcp))
    for _, q, T_world_tcp in sorted(soonest + found, key=itemgetter(0)):
        T_world_before = _back(T_world_tcp, hands.way)
        path, share = follow(chain, world.motion.rounded(q), T_world_before, policy.straight_points)
        if share < 1.0:
            note = VerdictNote.LINE_ENDS(share=share)
            yield Verdict(Reason.NO_PLACE, Stage.PLACE, q=path[-1], note=note)
            continue
        path = world.motion.rounded(path[::-1])
        world.enter(phase)
        met = arm_contact(world, arm.name, path)
        if met is None and insertion_of(world.cell, world.detections[number].part) is not None:
            # Where it begins, the part keeps its whole margin to what it comes onto, too.
            world.enter(replace(phase, inserts=frozenset()))
            contact = world.contact(world.configuration({arm.name: path[0]}))
            met = None if contact is None else (contact, path[0], 0)
        if met is None:
            yield path
        else:
            yield met[0].refuse(Reason.NO_PLACE, Stage.PLACE, met[1])


def _refuse_there(world: World, phase: LegPhase, arm: Arm, T_world_tcp: pin.SE3) -> Verdict | None:
    """Why a hand cannot let go of its part at a pose, whatever the arm does."""
    tilted = _refuse_tilted(world, phase, arm, T_world_tcp)
    return tilted or _refuse_standing(world, phase, arm, T_world_tcp)


def _refuse_standing(
    world: World, phase: LegPhase, arm: Arm, T_world_tcp: pin.SE3
) -> Verdict | None:
    """That the part in the hand would stand in something at a place, whatever the arm does.

    Most places that do not work are refused by it, and it is cheap.
    """
    number, T_tcp_part = phase.held[arm.name]
    label = world.part_ways.standing_in(number, T_world_tcp * T_tcp_part, world.policy.margin)
    if label is None:
        return None
    return Verdict(Reason.NO_PLACE, Stage.PLACE, (part_label(number), label))


def _refuse_tilted(world: World, phase: LegPhase, arm: Arm, T_world_tcp: pin.SE3) -> Verdict | None:
    """That the part in the hand, which has to stay upright, would be tilted at a place."""
    number, T_tcp_part = phase.held[arm.name]
    found = world.detections[number]
    part = world.cell.part(found.part)
    tilt = leans_too_far(part, found, (T_world_tcp * T_tcp_part).rotation)
    if tilt is None:
        return None
    note = VerdictNote.TILTED_THERE(tilt=tilt, most=part.tilt)
    return Verdict(Reason.NO_PLACE, Stage.PLACE, note=note)


@dataclass(slots=True)
class PlaceConfigurations:
    """What becomes of a part at the places for its kind, held in one way.

    `near` are configurations (n,) [rad] of the arm there that touch nothing; when there are none,
    `refusal` says why.
    """

    near: list[Floats]
    refusal: Verdict | None


def find_configurations_at_places(
    world: World, arm: Arm, phase: LegPhase, starts: Floats
) -> PlaceConfigurations:
    """Whether a part, held so, can be brought to a place for its kind: the place alone counts.

    Args:
        world: is put into the phase.
        arm: that has at least one place for parts of this kind.
        phase: of bringing the part.
        starts: (s, n) [rad] of the inverse kinematics.
    """
    chain = world.chains[arm.name]
    number, T_tcp_part = phase.held[arm.name]
    ways, stands = 0, 0
    far: list[tuple[float, Floats]] = []
    met: list[Verdict] = []
    none: Verdict | None = None
    for T_world_part in ways_at_places(world, arm, number):
        if isinstance(T_world_part, Verdict):
            none = none or T_world_part
            continue
        if processor_time() > world.deadline:
            return PlaceConfigurations([], LATE)
        T_world_tcp = T_world_part * T_tcp_part.inverse()
        tilted = _refuse_tilted(world, phase, arm, T_world_tcp)
        if tilted is not None:
            none = none or tilted
            continue
        ways += 1
        stood = _refuse_standing(world, phase, arm, T_world_tcp)
        if stood is not None:
            stands += 1
            met.append(stood)
            continue
        answers = configurations(chain, T_world_tcp, starts)
        if not len(answers.q):
            far.append((answers.shortfall, answers.nearest))
            continue
        world.enter(phase)
        near: list[Floats] = []
        for q in world.motion.rounded(answers.q):
            contact = world.contact(world.configuration({arm.name: q}))
            if contact is None:
                near.append(q)
            else:
                met.append(contact.refuse(Reason.NO_PLACE, Stage.PLACE, q))
        if near:
            return PlaceConfigurations(near, None)
    if ways == 0:
        return PlaceConfigurations([], none or why_full(world, arm, number))
    close = ways - stands - len(far)
    note = VerdictNote.TARGET_POSES(count=ways, blocked=stands, far=len(far), close=close)
    if met:
        # That which came nearest to being right: where the arm is meant, by how much is known.
        nearest = max(met, key=lambda verdict: (verdict.q is not None, verdict.distance or 0.0))
        return PlaceConfigurations([], replace(nearest, note=note))
    away, q = min(far, key=itemgetter(0))
    return PlaceConfigurations([], Verdict(Reason.NO_PLACE, Stage.PLACE, None, away, q, note))


def put_down(world: World, pick: Pick, others: LegPhase) -> PutDown | Verdict:
    """The motions to a place and out of it, clear of what other arms have placed.

    The motion of the pick is tried first.

    Args:
        world: of the cell and the detections that the pick was made from.
        pick: what is to be put down.
        others: what is true of the other arms meanwhile.
    """
    arm = arm_placing(world, world.arm(pick.candidate.arm), pick.candidate.detection)
    if isinstance(arm, Verdict):
        return arm
    grasp = pick.candidate.grasp
    held = (pick.candidate.detection, pick.T_tcp_part)
    moving = frozenset({arm.name})
    brings = replace(
        others,
        moving=moving,
        openings={**others.openings, arm.name: grasp.grip},
        held={arm.name: held},
        inserts=moving,
    )
    refusal: Verdict | None = None
    for down in one_by_one(
        [pick.place], plan_straight_descents(world, arm, brings, pick.extract[-1])
    ):
        if isinstance(down, Verdict):
            if down.reason is Reason.OUT_OF_TIME:
                return down
            refusal = refusal or down
            continue
        world.enter(brings)
        # All but what other arms have placed is known to be clear.
        found = along_placed(world, arm.name, down)
        met = None if found is None else found[0].refuse(Reason.NO_PLACE, Stage.PLACE, found[1])
        if met is None and np.array_equal(down[-1], home_of(world, arm)):
            return PutDown(down, down[-1:])
        if met is None:
            leaves = replace(
                others,
                moving=moving,
                openings={**others.openings, arm.name: grasp.opening},
                placed={**others.placed, arm.name: (*held, down[-1])},
            )
            out = _way_out(world, pick, arm, leaves, down)
            if not isinstance(out, Verdict):
                return PutDown(down, out)
            met = out
        refusal = refusal or met
    return refusal or Verdict(Reason.NO_PLACE, Stage.PLACE)


def home_of(world: World, arm: Arm) -> Floats:
    """Where an arm is at home (n,) [rad], as far as that can be sent."""
    return posture_of(world, arm, np.asarray(arm.home))


def posture_of(world: World, arm: Arm, q: Floats) -> Floats:
    """A posture `q` (n,) [rad] of an arm, as far as that can be sent."""
    chain = world.chains[arm.name]
    return np.clip(world.motion.rounded(q), chain.lower, chain.upper)


def _back(T_world_tcp: pin.SE3, way: Floats) -> pin.SE3:
    """Pose of a hand before the last motion (3,) [m] to a place."""
    return pin.SE3(T_world_tcp.rotation, T_world_tcp.translation - way)


def _way_out(world: World, pick: Pick, arm: Arm, phase: LegPhase, down: Floats) -> Floats | Verdict:
    """The linear motion (m, n) of the open hand out of where it has put the part `down`.

    It goes out as it had come to the part in the bin; where that is not possible, straight back,
    and farther where its fingers would still be around the part.
    """
    q_place, chain = down[-1], world.chains[arm.name]
    T_grasp_pregrasp = chain.pose(pick.q_grasp).actInv(chain.pose(np.asarray(pick.approach[0])))
    T_world_tcp = chain.pose(q_place)
    came = T_world_tcp.translation - chain.pose(down[0]).translation
    way = PLACE_LIFT * came / np.linalg.norm(came)
    back = [_back(T_world_tcp, far * way) for far in (1.0, FARTHER)]
    refusal: Verdict | None = None
    for T_world_out in (T_world_tcp * T_grasp_pregrasp, *back):
        path, share = follow(chain, q_place, T_world_out, world.policy.straight_points)
        if share < 1.0:
            note = VerdictNote.RETREAT_ENDS(share=share)
            refusal = refusal or Verdict(Reason.NO_PLACE, Stage.PLACE, q=path[-1], note=note)
            continue
        path = world.motion.rounded(path)
        world.enter(phase)
        world.allow_start_contacts(world.configuration({arm.name: q_place}))
        found = arm_contact(world, arm.name, path)
        found = found or find_contact_after_release(world, arm.name, path)
        if found is None and not is_around(world, arm, phase, path[-1]):
            return path
        if found is None:
            continue
        contact, q, _ = found
        note = VerdictNote.ON_RETREAT()
        refusal = refusal or contact.refuse(Reason.NO_PLACE, Stage.PLACE, q, note)
    return refusal or Verdict(Reason.NO_PLACE, Stage.PLACE)
