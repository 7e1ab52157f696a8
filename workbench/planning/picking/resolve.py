"""From a candidate to configurations: grasp, the linear motions in and out, and the place."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Pick, Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.geometry import Floats
from workbench.model.messages.message import all_of
from workbench.model.messages.verdicts import VerdictNote
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.hands import turns_of
from workbench.planning.collision.legs import (
    approach_phase,
    grips,
    holding_phase,
    placing_phase,
)
from workbench.planning.collision.motion import path_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.part_ways import Caught
from workbench.planning.collision.world import World
from workbench.planning.grasps.roll_symmetry import uneven
from workbench.planning.grasps.rolls import with_rolls
from workbench.planning.kinematics.chain import Chain
from workbench.planning.kinematics.inverse import Answers, configurations, starts_of
from workbench.planning.kinematics.quickness import draw_towards, legs_seconds, pace_of
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


def _find_best(world: World, candidate: Candidate, seed: int) -> Pick | Verdict:
    arm = arm_placing(world, world.arm(candidate.arm), candidate.detection)
    if isinstance(arm, Verdict):
        return arm
    if candidate.grasp.retreat is None:
        # The part's own way out does not depend on the arm: looked at first, it is cheap.
        _, blocked = find_lifts_clear_for_part(world, candidate, candidate.T_world_tcp)
        if blocked is not None:
            return blocked
    part = world.detections[candidate.detection].part
    if arm.part_places and not arm.Ts_world_place and not arm.places_for(part):
        return _no_place(world, candidate, arm)
    hands = _hands(world, candidate, arm)
    if isinstance(hands, Verdict):
        return hands
    solutions, refusal = _grasp_solutions(world, candidate, arm, hands, seed)
    solutions, near, nowhere = _that_can_be_put(world, candidate, arm, solutions, seed)
    best = nowhere or refusal
    for q_grasp, T_world_tcp, clearance in solutions[:CONFIGURATIONS_TRIED]:
        at = near.get(T_world_tcp.homogeneous.tobytes())
        result = _complete(world, candidate, arm, q_grasp, T_world_tcp, room=clearance, near=at)
        if isinstance(result, Pick):
            return replace(result, solutions=tuple(q for q, _, _ in solutions))
        if best is None or _progress(result) >= _progress(best):
            best = result
    return best if best is not None else Verdict(Reason.OUT_OF_REACH, Stage.GRASP)


def _hands(world: World, candidate: Candidate, arm: Arm) -> list[pin.SE3] | Verdict:
    """Where the hand may be: of the same grips those that fit, and that can be lifted out.

    Where there is but one lift it is left to the closer look that follows.
    """
    grasp, detection = candidate.grasp, world.detections[candidate.detection]
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


def _progress(verdict: Verdict) -> int:
    return list(Stage).index(verdict.stage)


Solution = tuple[Floats, pin.SE3, float]
"""A clear grasp configuration (n,) [rad] with hand pose and clearance [m]."""


def _that_can_be_put(
    world: World, candidate: Candidate, arm: Arm, solutions: list[Solution], seed: int
) -> tuple[list[Solution], dict[bytes, Floats], Verdict | None]:
    """The solutions whose hands bring the part to a place for its kind, and why others do not.

    How the hand holds the part decides how it stands at such a place.  Where the arm has places for
    its hand as well, those serve the others, which are tried later.

    Returns:
        Solutions in their order, and configurations (k, n) [rad] at a place by the hand's pose.
        When no solution is left, the first refusal; before all others that the time is over.
    """
    detection = world.detections[candidate.detection]
    if not arm.places_for(detection.part):
        return solutions, {}, None
    chain, near = world.chains[arm.name], dict[bytes, Floats]()
    starts = starts_of(chain, world.arm(arm.name), seed)
    refusals: dict[bytes, Verdict | None] = {}
    for _, T_world_tcp, _ in solutions:
        key = T_world_tcp.homogeneous.tobytes()
        if key in near or key in refusals:
            continue
        T_tcp_part = T_world_tcp.actInv(detection.T_world_part)
        phase = placing_phase(candidate, arm, T_tcp_part)
        found = find_configurations_at_places(world, arm, phase, starts)
        if found.near:
            near[key] = np.array(found.near)
        else:
            refusals[key] = found.refusal
    able = [solution for solution in solutions if solution[1].homogeneous.tobytes() in near]
    if arm.Ts_world_place:
        able += [
            solution for solution in solutions if solution[1].homogeneous.tobytes() not in near
        ]
    refused = [] if able else [refusal for refusal in refusals.values() if refusal]
    refused.sort(key=lambda refusal: refusal.reason is not Reason.OUT_OF_TIME)
    return able, near, next(iter(refused), None)


def _grasp_solutions(
    world: World, candidate: Candidate, arm: Arm, hands: Sequence[pin.SE3], seed: int
) -> tuple[list[Solution], Verdict | None]:
    """Clear grasp configurations with hand pose and clearance, best first; or the refusal."""
    chain = world.chains[arm.name]
    starts = starts_of(chain, world.arm(arm.name), seed)
    pace = pace_of(chain, world.policy.speed)
    home = np.asarray(arm.home)[None]
    found: list[tuple[Floats, pin.SE3]] = []
    every = [configurations(chain, T_world_tcp, starts) for T_world_tcp in hands]
    known = np.empty((2 * sum(len(hand_answers.q) for hand_answers in every), starts.shape[1]))
    for T_world_tcp, answers in zip(hands, every, strict=True):
        # Those that are reached sooner may be in the way of something: the others stay.
        for q in (*draw_towards(chain, T_world_tcp, answers.q, home, pace), *answers.q):
            if not (np.abs(known[: len(found)] - q).max(axis=1) < SAME_SOLUTION).any():
                known[len(found)] = q
                found.append((q, T_world_tcp))
    if not found:
        return [], _out_of_reach(every)
    world.enter(approach_phase(candidate, arm))
    times: list[float] = pace.seconds(known[: len(found)] - home).tolist()
    clear: list[tuple[float, Floats, pin.SE3, float]] = []
    refusal: Verdict | None = None
    for k in sorted(range(len(found)), key=times.__getitem__):
        q, T_world_tcp = found[k]
        contact, room = world.worst(world.configuration({arm.name: q}), reach=SMALL_ROOM)
        if contact is not None and room < 0:
            verdict = _refuse(Reason.IN_COLLISION, Stage.GRASP, contact, q)
            if refusal is None or (verdict.distance or 0) > (refusal.distance or 0):
                refusal = verdict
            continue
        clear.append((times[k] + EXTRA_TIME * (1.0 - room / SMALL_ROOM), q, T_world_tcp, room))
        if len(clear) == MOST_CLEAR:
            break
    clear.sort(key=lambda entry: entry[0])
    return [(q, T, room) for _, q, T, room in clear], refusal


def _out_of_reach(every: Sequence[Answers]) -> Verdict:
    """The verdict on hands that no configuration was found for, by that which comes nearest."""
    nearest = min(every, key=lambda answers: answers.shortfall)
    note = None
    if not all(answers.is_complete for answers in every):
        note = VerdictNote.NO_CONFIGURATION(starts=sum(answers.starts for answers in every))
    return Verdict(Reason.OUT_OF_REACH, Stage.GRASP, None, nearest.shortfall, nearest.nearest, note)


def _refuse(reason: Reason, stage: Stage, contact: Contact, q: Floats) -> Verdict:
    return Verdict(reason, stage, pair=contact.pair, distance=contact.distance, q=q)


def _broken_off(reason: Reason, stage: Stage, q: Floats, share: float) -> Verdict:
    """The verdict on a straight line that the arm can follow only up to `q`."""
    return Verdict(reason, stage, q=q, note=VerdictNote.LINE_ENDS(share=share))


def _complete(
    world: World,
    candidate: Candidate,
    arm: Arm,
    q_grasp: Floats,
    T_world_tcp: pin.SE3,
    *,
    room: float,
    near: Floats | None,
) -> Pick | Verdict:
    """Approach, extraction and place for one grasp; `near` as in `plan_straight_descents`."""
    q_grasp = world.motion.rounded(q_grasp)
    approach = _approach(world, candidate, arm, q_grasp, T_world_tcp)
    if isinstance(approach, Verdict):
        return approach
    T_world_part = world.detections[candidate.detection].T_world_part
    T_tcp_part = world.chains[arm.name].pose(q_grasp).actInv(T_world_part)
    if has_several(world, candidate):
        ways, refusal = find_lifts_clear_for_part_and_hand(world, candidate, T_world_tcp)
    else:
        ways, refusal = find_lifts_clear_for_part(
            world, candidate, world.chains[arm.name].pose(q_grasp)
        )
    for name, way in ways:
        extract = _extract(world, candidate, arm, q_grasp, T_tcp_part, way)
        if isinstance(extract, Verdict):
            refusal = refusal or extract
            continue
        place = _place(world, candidate, arm, extract[-1], T_tcp_part, near)
        if isinstance(place, Verdict):
            # No other lift makes the places come nearer.
            return place
        straight = [leg[[0, -1]] for leg in (approach, extract, place)]
        ends = np.vstack([arm.home, *straight, arm.home])
        seconds = legs_seconds(ends, pace_of(world.chains[arm.name], world.policy.speed))
        gain = np.inf
        if len(world.policy.lifts) > 1:
            # With one lift it would only change the order of parts.
            gain = world.part_ways.gain(candidate.detection, way)
        legs = (approach, extract, place)
        return Pick(candidate, T_tcp_part, *legs, room, seconds, lift=name, gain=gain)
    return refusal or Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT)


def _approach(
    world: World, candidate: Candidate, arm: Arm, q_grasp: Floats, T_world_tcp: pin.SE3
) -> Floats | Verdict:
    grasp, policy = candidate.grasp, world.policy
    chain, columns = world.chains[arm.name], world.kinematics.columns[arm.name]
    # Authored in the TCP frame of the grasp, which the hand may be turned against.
    way = grasp.approach_length * (candidate.T_world_tcp.rotation @ grasp.approach)
    T_pregrasp = pin.SE3(T_world_tcp.rotation, T_world_tcp.translation - way)
    backwards, share = follow(chain, q_grasp, T_pregrasp, policy.straight_points)
    if share < 1.0:
        return _broken_off(Reason.APPROACH_BLOCKED, Stage.APPROACH, backwards[-1], share)
    path = world.motion.rounded(backwards[::-1])
    path[-1] = q_grasp
    base = world.configuration({})
    world.enter(approach_phase(candidate, arm))
    found = path_contact(world, columns, base, path)
    if found is None:
        world.enter(LegPhase(frozenset({arm.name}), {arm.name: grasp.opening}))
        q = path[0]
        contact = world.contact(world.configuration({arm.name: q}))
    else:
        contact, q, _ = found
    if contact is not None:
        return _refuse(Reason.APPROACH_BLOCKED, Stage.APPROACH, contact, q)
    return path


def _extract(
    world: World,
    candidate: Candidate,
    arm: Arm,
    q_grasp: Floats,
    T_tcp_part: pin.SE3,
    way: Floats,
) -> Floats | Verdict:
    """The straight `way` (3,) [m] of the part out of the bin, shape (m, n)."""
    policy = world.policy
    caught = world.part_ways.find_snag(candidate.detection, way)
    if caught is not None:
        return _held_back(caught)
    chain, columns = world.chains[arm.name], world.kinematics.columns[arm.name]
    T_grasp = chain.pose(q_grasp)
    T_end = pin.SE3(T_grasp.rotation, T_grasp.translation + way)
    path, share = follow(chain, q_grasp, T_end, policy.straight_points)
    if share < 1.0:
        return _broken_off(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, path[-1], share)
    path = world.motion.rounded(path)
    world.enter(holding_phase(candidate, arm, T_tcp_part, straight=True))
    base = world.configuration({})
    sunk = world.allow_start_contacts(world.configuration({arm.name: q_grasp}))
    if sunk is not None:
        refused = _refuse(Reason.IN_COLLISION, Stage.EXTRACT, sunk, q_grasp)
        return refused.with_note(VerdictNote.TOO_DEEP())
    # What refuses most is asked first: it is quick, and slow where bodies touch.
    with world.at_full_margins():
        free = _beyond(chain, path, policy.release)
        found = path_contact(world, columns, base, free)
    if found is None:
        found = path_contact(world, columns, base, path)
    if found is None:
        world.enter(holding_phase(candidate, arm, T_tcp_part, straight=False))
        q = path[-1]
        contact = world.contact(world.configuration({arm.name: q}))
    else:
        contact, q, _ = found
    if contact is not None:
        return _refuse(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, contact, q)
    return path


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
    world: World,
    candidate: Candidate,
    arm: Arm,
    q_from: Floats,
    T_tcp_part: pin.SE3,
    near: Floats | None,
) -> Floats | Verdict:
    """The linear motion down to the first place that works, shape (m, n)."""
    refusal = _no_place(world, candidate, arm)
    phase = placing_phase(candidate, arm, T_tcp_part)
    for way in plan_straight_descents(world, arm, phase, q_from, near):
        if not isinstance(way, Verdict):
            return way
        refusal = way
    return refusal


def _no_place(world: World, candidate: Candidate, arm: Arm) -> Verdict:
    """That an arm comes to none of its places, or has none."""
    part = world.detections[candidate.detection].part
    note = VerdictNote.NO_PLACE_FOR_ARM()
    if arm.part_places:
        note = VerdictNote.NO_PLACE_FOR_PART(count=len(arm.part_places), part=part)
    if arm.Ts_world_place or arm.places_for(part):
        note = VerdictNote.PLACES_UNREACHABLE()
    return Verdict(Reason.NO_PLACE, Stage.PLACE, note=note)
