"""From a candidate to configurations: grasp, the linear motions in and out, and the place."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Pick, Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.geometry import Floats
from workbench.model.messages.message import all_of
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.scan import Detection
from workbench.planning.collision.hands import turns_of
from workbench.planning.collision.legs import (
    approach_phase,
    grips,
    holding_phase,
    placing_phase,
)
from workbench.planning.collision.motion import arm_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.part_ways import Caught
from workbench.planning.collision.world import World
from workbench.planning.grasps.roll_symmetry import uneven
from workbench.planning.grasps.rolls import with_rolls
from workbench.planning.kinematics.chain import Chain
from workbench.planning.kinematics.inverse import Answers, configurations, starts_of
from workbench.planning.kinematics.quickness import Pace, draw_towards, legs_seconds, pace_of
from workbench.planning.kinematics.straight import follow
from workbench.planning.picking.lifts import (
    find_lifts_clear_for_part,
    find_lifts_clear_for_part_and_hand,
    has_several,
)
from workbench.planning.picking.put_down import (
    find_configurations_at_places,
    plan_straight_descents,
)
from workbench.planning.placing.assembling import arm_placing

CONFIGURATIONS_TRIED = 3
"""Grasp configurations of one candidate that are followed to the end."""

SAME_SOLUTION = np.deg2rad(5.0)
"""Two solutions closer than this in every joint are one."""

MOST_CLEAR = 8
"""Clear configurations that are enough to choose from: those that are reached soonest."""

SMALL_ROOM, EXTRA_TIME = 0.01, 0.1
"""[m, s] Less room than this counts like up to so much extra time."""


def resolve(world: World, candidate: Candidate, *, seed: int) -> Pick | Verdict:
    """The configurations by which a candidate works, or why it does not.

    Solutions of the inverse kinematics are tried in the order of their time from home, those with
    little clearance later.  When none works out, the verdict is that of the one which got
    furthest along the line.

    Args:
        world: cell and detections that the candidate was made from.
        candidate: one whose verdict is still OK; another is given its own verdict back.
        seed: of the request; together with the arm it determines every random start.
    """
    if not candidate.verdict.is_ok:
        return candidate.verdict
    result = _find_best(world, candidate, seed)
    return result if isinstance(result, Pick) else with_rolls(world.detections, result)


@dataclass(frozen=True, slots=True, eq=False)
class _Attempt:
    """A candidate, its arm with the places that count, and the `starts` (s, n) [rad] of the IK."""

    world: World
    candidate: Candidate
    arm: Arm
    starts: Floats

    @property
    def detection(self) -> Detection:
        """The part found."""
        return self.world.detections[self.candidate.detection]

    @property
    def chain(self) -> Chain:
        """The kinematic chain of the arm."""
        return self.world.chains[self.arm.name]

    @property
    def pace(self) -> Pace:
        """The joint limits of the arm at the policy's speed."""
        return pace_of(self.chain, self.world.policy.speed)

    def at(self, q: Floats) -> Floats:
        """The whole configuration (nq,) with the arm at `q` (n,) [rad]."""
        return self.world.configuration({self.arm.name: q})


def _find_best(world: World, candidate: Candidate, seed: int) -> Pick | Verdict:
    arm = arm_placing(world, world.arm(candidate.arm), candidate.detection)
    if isinstance(arm, Verdict):
        return arm
    if candidate.grasp.retreat is None:
        # The extraction of the part alone does not depend on the arm, and its check is cheap.
        _, blocked = find_lifts_clear_for_part(world, candidate, candidate.T_world_tcp)
        if blocked is not None:
            return blocked
    starts = starts_of(world.chains[arm.name], world.arm(arm.name), seed)
    attempt = _Attempt(world, candidate, arm, starts)
    if arm.part_places and not arm.Ts_world_place and not arm.places_for(attempt.detection.part):
        return _no_place(attempt)
    hands = _hands(attempt)
    if isinstance(hands, Verdict):
        return hands
    solutions, refusal = _grasp_solutions(attempt, hands)
    solutions, near, nowhere = _select_placeable(attempt, solutions)
    best = nowhere or refusal
    for solution in solutions[:CONFIGURATIONS_TRIED]:
        result = _complete(attempt, solution, near.get(solution.hand))
        if isinstance(result, Pick):
            return replace(result, solutions=tuple(each.q for each in solutions))
        if best is None or result.progress[0] >= best.progress[0]:
            best = result
    return best if best is not None else Verdict(Reason.OUT_OF_REACH, Stage.GRASP)


def _hands(attempt: _Attempt) -> list[pin.SE3] | Verdict:
    """Poses of the hand: of the same grips those that fit, and that can be lifted out.

    A single lift is left to the closer check that follows.
    """
    world, candidate, arm = attempt.world, attempt.candidate, attempt.arm
    grasp, detection = candidate.grasp, attempt.detection
    every = [candidate.T_world_tcp * T for T in grips(arm.tool, grasp)]
    fits = world.tool_check.free(arm, candidate.detection, turns_of(arm.tool, grasp))
    if not detection.roll_known:
        wrong = uneven(world.cell.part(detection.part), detection, arm, grasp)
        fits = fits & np.array([what is None for what in wrong])
        if not fits.any():
            return Verdict(Reason.ROLL_UNKNOWN, Stage.GRASP, note=VerdictNote.ROLL_UNSEEN())
    fitting = [T for T, is_free in zip(every, fits, strict=True) if is_free] or every
    if not has_several(world, candidate):
        return fitting
    found: list[pin.SE3] = []
    refusal: Verdict | None = None
    for T_world_tcp in fitting:
        ways, blocked = find_lifts_clear_for_part_and_hand(world, candidate, T_world_tcp, most=1)
        if ways:
            found.append(T_world_tcp)
        refusal = refusal or blocked
    return found or refusal or Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT)


class _Solution(NamedTuple):
    """A clear grasp configuration `q` (n,) [rad] with hand pose and clearance [m]."""

    q: Floats
    T_world_tcp: pin.SE3
    clearance: float

    @property
    def hand(self) -> bytes:
        """The hand pose as a key."""
        return self.T_world_tcp.homogeneous.tobytes()


def _select_placeable(
    attempt: _Attempt, solutions: list[_Solution]
) -> tuple[list[_Solution], dict[bytes, Floats], Verdict | None]:
    """The solutions whose hands bring the part to a place for its kind, and why others do not.

    The grip decides the part's orientation at such a place.  If the arm has places for its hand as
    well, those serve the other solutions, which are tried later.

    Returns:
        Solutions in their order, and configurations (k, n) [rad] at a place by `_Solution.hand`.
        When no solution is left, the first refusal; a passed deadline before all others.
    """
    arm, detection = attempt.arm, attempt.detection
    if not arm.places_for(detection.part):
        return solutions, {}, None
    near: dict[bytes, Floats] = {}
    refusals: dict[bytes, Verdict | None] = {}
    for solution in solutions:
        if solution.hand in near or solution.hand in refusals:
            continue
        T_tcp_part = solution.T_world_tcp.actInv(detection.T_world_part)
        phase = placing_phase(attempt.candidate, arm, T_tcp_part)
        found = find_configurations_at_places(attempt.world, arm, phase, attempt.starts)
        if found.near:
            near[solution.hand] = np.array(found.near)
        else:
            refusals[solution.hand] = found.refusal
    able = [solution for solution in solutions if solution.hand in near]
    if arm.Ts_world_place:
        able += [solution for solution in solutions if solution.hand not in near]
    refused = [] if able else [refusal for refusal in refusals.values() if refusal]
    refused.sort(key=lambda refusal: refusal.reason is not Reason.OUT_OF_TIME)
    return able, near, next(iter(refused), None)


def _grasp_solutions(
    attempt: _Attempt, hands: Sequence[pin.SE3]
) -> tuple[list[_Solution], Verdict | None]:
    """Clear grasp configurations, best first; or the refusal."""
    world, chain, starts, pace = attempt.world, attempt.chain, attempt.starts, attempt.pace
    home = np.asarray(attempt.arm.home)[None]
    found: list[tuple[Floats, pin.SE3]] = []
    every = [configurations(chain, T_world_tcp, starts) for T_world_tcp in hands]
    known = np.empty((2 * sum(len(hand_answers.q) for hand_answers in every), starts.shape[1]))
    for T_world_tcp, answers in zip(hands, every, strict=True):
        # Quicker configurations may be blocked: the original ones stay in the list.
        for q in (*draw_towards(chain, T_world_tcp, answers.q, home, pace), *answers.q):
            if not (np.abs(known[: len(found)] - q).max(axis=1) < SAME_SOLUTION).any():
                known[len(found)] = q
                found.append((q, T_world_tcp))
    if not found:
        return [], _out_of_reach(every)
    world.enter(approach_phase(attempt.candidate, attempt.arm))
    times: list[float] = pace.seconds(known[: len(found)] - home).tolist()
    clear: list[tuple[float, _Solution]] = []
    refusal: Verdict | None = None
    for k in sorted(range(len(found)), key=times.__getitem__):
        q, T_world_tcp = found[k]
        contact, room = world.worst(attempt.at(q), reach=SMALL_ROOM)
        if contact is not None and room < 0:
            verdict = contact.refuse(Reason.IN_COLLISION, Stage.GRASP, q)
            if refusal is None or (verdict.distance or 0) > (refusal.distance or 0):
                refusal = verdict
            continue
        rank = times[k] + EXTRA_TIME * (1.0 - room / SMALL_ROOM)
        clear.append((rank, _Solution(q, T_world_tcp, room)))
        if len(clear) == MOST_CLEAR:
            break
    clear.sort(key=itemgetter(0))
    return [solution for _, solution in clear], refusal


def _out_of_reach(every: Sequence[Answers]) -> Verdict:
    """The verdict on hands that no configuration was found for, by that which comes nearest."""
    nearest = min(every, key=lambda answers: answers.shortfall)
    note = None
    if not all(answers.is_complete for answers in every):
        note = VerdictNote.NO_CONFIGURATION(starts=sum(answers.starts for answers in every))
    return Verdict(Reason.OUT_OF_REACH, Stage.GRASP, None, nearest.shortfall, nearest.nearest, note)


def _broken_off(reason: Reason, stage: Stage, q: Floats, share: float) -> Verdict:
    """The verdict on a straight line that the arm can follow only up to `q`."""
    return Verdict(reason, stage, q=q, note=VerdictNote.LINE_ENDS(share=share))


def _complete(attempt: _Attempt, solution: _Solution, near: Floats | None) -> Pick | Verdict:
    """Approach, extraction and place for one grasp; `near` as in `plan_straight_descents`."""
    world, candidate, chain = attempt.world, attempt.candidate, attempt.chain
    q_grasp = world.motion.rounded(solution.q)
    approach = _approach(attempt, q_grasp, solution.T_world_tcp)
    if isinstance(approach, Verdict):
        return approach
    T_tcp_part = chain.pose(q_grasp).actInv(attempt.detection.T_world_part)
    if has_several(world, candidate):
        ways, refusal = find_lifts_clear_for_part_and_hand(world, candidate, solution.T_world_tcp)
    else:
        ways, refusal = find_lifts_clear_for_part(world, candidate, chain.pose(q_grasp))
    for name, way in ways:
        extract = _extract(attempt, q_grasp, T_tcp_part, way)
        if isinstance(extract, Verdict):
            refusal = refusal or extract
            continue
        place = _place(attempt, extract[-1], T_tcp_part, near)
        if isinstance(place, Verdict):
            # No other lift makes the places come nearer.
            return place
        legs = (approach, extract, place)
        home, ends = attempt.arm.home, (leg[[0, -1]] for leg in legs)
        seconds = legs_seconds(np.vstack([home, *ends, home]), attempt.pace)
        gain = np.inf
        if len(world.policy.lifts) > 1:
            # With one lift it would only change the order of parts.
            gain = world.part_ways.gain(candidate.detection, way)
        room = solution.clearance
        return Pick(candidate, T_tcp_part, *legs, room, seconds, lift=name, gain=gain)
    return refusal or Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT)


def _approach(attempt: _Attempt, q_grasp: Floats, T_world_tcp: pin.SE3) -> Floats | Verdict:
    """The linear motion (m, n) to the grasp."""
    world, candidate, arm = attempt.world, attempt.candidate, attempt.arm
    grasp = candidate.grasp
    # Authored in the TCP frame of the grasp, which the hand may be turned against.
    way = grasp.approach_length * (candidate.T_world_tcp.rotation @ grasp.approach)
    T_pregrasp = pin.SE3(T_world_tcp.rotation, T_world_tcp.translation - way)
    points = world.policy.straight_points
    backwards, share = follow(attempt.chain, q_grasp, T_pregrasp, points)
    if share < 1.0:
        return _broken_off(Reason.APPROACH_BLOCKED, Stage.APPROACH, backwards[-1], share)
    path = world.motion.rounded(backwards[::-1])
    path[-1] = q_grasp
    world.enter(approach_phase(candidate, arm))
    found = arm_contact(world, arm.name, path)
    if found is None:
        world.enter(LegPhase(frozenset({arm.name}), {arm.name: grasp.opening}))
        q = path[0]
        contact = world.contact(attempt.at(q))
    else:
        contact, q, _ = found
    return path if contact is None else contact.refuse(Reason.APPROACH_BLOCKED, Stage.APPROACH, q)


def _extract(
    attempt: _Attempt, q_grasp: Floats, T_tcp_part: pin.SE3, way: Floats
) -> Floats | Verdict:
    """The straight `way` (3,) [m] of the part out of the bin, shape (m, n)."""
    world, candidate, arm, chain = attempt.world, attempt.candidate, attempt.arm, attempt.chain
    policy = world.policy
    caught = world.part_ways.find_snag(candidate.detection, way)
    if caught is not None:
        return _held_back(caught)
    T_grasp = chain.pose(q_grasp)
    T_end = pin.SE3(T_grasp.rotation, T_grasp.translation + way)
    path, share = follow(chain, q_grasp, T_end, policy.straight_points)
    if share < 1.0:
        return _broken_off(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, path[-1], share)
    path = world.motion.rounded(path)
    world.enter(holding_phase(candidate, arm, T_tcp_part, straight=True))
    sunk = world.allow_start_contacts(attempt.at(q_grasp))
    if sunk is not None:
        return sunk.refuse(Reason.IN_COLLISION, Stage.EXTRACT, q_grasp, VerdictNote.TOO_DEEP())
    # What refuses most is asked first: it is quick, and slow where bodies touch.
    with world.at_full_margins():
        found = arm_contact(world, arm.name, _beyond(chain, path, policy.release))
    if found is None:
        found = arm_contact(world, arm.name, path)
    if found is None:
        world.enter(holding_phase(candidate, arm, T_tcp_part, straight=False))
        q = path[-1]
        contact = world.contact(attempt.at(q))
    else:
        contact, q, _ = found
    return path if contact is None else contact.refuse(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, q)


def _held_back(caught: Caught) -> Verdict:
    """The verdict on a part that does not come off what it lies on at every turn."""
    pair, distance = (caught.part, caught.bed), caught.distance
    if caught.is_sunk:
        note = VerdictNote.TOO_DEEP()
        return Verdict(Reason.IN_COLLISION, Stage.EXTRACT, pair, distance, note=note)
    note = all_of((VerdictNote.STAYS_ON(), VerdictNote.ROLL_UNSEEN()))
    return Verdict(Reason.ROLL_UNKNOWN, Stage.EXTRACT, pair, distance, note=note)


def _beyond(chain: Chain, path: Floats, far: float) -> Floats:
    """The waypoints (k, n) of a linear motion (m, n) from `far` [m] of the hand's way on."""
    places = np.array([chain.pose(q).translation for q in path])
    gone = np.linalg.norm(places - places[0], axis=1)
    if gone[-1] <= far:
        return path[-1:].repeat(2, axis=0)
    after = int(np.flatnonzero(gone > far)[0])
    share = (far - gone[after - 1]) / (gone[after] - gone[after - 1])
    start = path[after - 1] + share * (path[after] - path[after - 1])
    return np.vstack([start, path[after:]])


def _place(
    attempt: _Attempt, q_from: Floats, T_tcp_part: pin.SE3, near: Floats | None
) -> Floats | Verdict:
    """The linear motion down to the first place that works, shape (m, n)."""
    refusal = _no_place(attempt)
    phase = placing_phase(attempt.candidate, attempt.arm, T_tcp_part)
    for way in plan_straight_descents(attempt.world, attempt.arm, phase, q_from, near):
        if not isinstance(way, Verdict):
            return way
        refusal = way
    return refusal


def _no_place(attempt: _Attempt) -> Verdict:
    """That an arm comes to none of its places, or has none."""
    arm, part = attempt.arm, attempt.detection.part
    note = VerdictNote.NO_PLACE_FOR_ARM()
    if arm.part_places:
        note = VerdictNote.NO_PLACE_FOR_PART(count=len(arm.part_places), part=part)
    if arm.Ts_world_place or arm.places_for(part):
        note = VerdictNote.PLACES_UNREACHABLE()
    return Verdict(Reason.NO_PLACE, Stage.PLACE, note=note)
