"""Ways in which a part is taken out of the bin, by name, in the order of the policy.

Where there are several, those that lead away from what the part lies against come first: before
those on which it only rubs along that, and may drag it.  Last come those on which it is pushed into
that: the arm may not go there, so they must not keep it from trying others.

`leaning`: up, leaning to the middle of the bin, as the thesis does.  `up`: straight up.  `back`:
out again as the hand came in.  `off-wall`: up, leaning away from the wall that is nearest;
straight up where there is none.
`around`: up, leaning to each of twelve sides by half and by all of the policy's angle, for parts
that others hold down.  `any`: of ways all over the half sphere above those on which the part itself
comes off, for parts that are caught in others.
"""

from collections.abc import Iterator
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.candidate import RUBS, Candidate, Reason, Stage, Verdict
from workbench.model.cell import LiftName
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import Bin
from workbench.planning.collision.bodies import part_label
from workbench.planning.collision.part_ways import PartLifts, PartWays
from workbench.planning.collision.world import World

AUTHORED = "as authored"
"""Name of the lift of a grasp that states its retreat."""

LEAN_SIDES = 12

MOST_CLEAR = 6
"""Clear lifts that are tried with the arm, in their order."""

LIFT_COSINE = np.cos(np.deg2rad(60.0))
"""The way back out is a lift if the cosine of its angle to the vertical is at least this."""

SAME_DIRECTION = np.cos(np.deg2rad(4.0))
"""Cosine of the angle between directions below which they count as equal."""


def lift_message(name: str) -> Message | str:
    """A lift for people: the policy's are called by their names."""
    return VerdictNote.AUTHORED() if name == AUTHORED else name


def lifts(world: World, candidate: Candidate, T_world_tcp: pin.SE3) -> Iterator[tuple[str, Floats]]:
    """The names and ways (3,) [m] in the world in which a candidate's part may be taken out.

    Args:
        world: whose policy and bin.
        candidate: whose grasp; where that says how to go out, there is no other way.
        T_world_tcp: the hand as it holds the part.
    """
    grasp, policy = candidate.grasp, world.policy
    if grasp.retreat is not None:
        R = candidate.T_world_tcp.rotation
        yield AUTHORED, grasp.retreat_length * (R @ grasp.retreat)
        return
    named = [
        (name, direction)
        for name in policy.lifts
        for direction in _directions(world, candidate, T_world_tcp, name)
    ]
    kept = _unlike(np.array([direction for _, direction in named]).reshape(-1, 3))
    ways = [(named[k][0], policy.lift_length * named[k][1]) for k in kept]
    if len(ways) > 1:
        part_ways, number = world.part_ways, candidate.detection
        ways.sort(key=lambda way: _how_bad(part_ways, number, way[1]))
    yield from ways


def _how_bad(part_ways: PartWays, number: int, way: Floats) -> int:
    """Whether a part's way (3,) [m] leads away (0), rubs along something (1), or into it (2)."""
    return 2 if part_ways.is_pushed(number, way) else int(part_ways.gain(number, way) < RUBS)


def _unlike(directions: Floats) -> list[int]:
    """The indices of unit vectors (k, 3) that differ by `SAME_DIRECTION` from those before them."""
    is_alike = directions @ directions.T > SAME_DIRECTION
    is_kept = np.zeros(len(directions), bool)
    for k, row in enumerate(is_alike):
        is_kept[k] = not (row & is_kept).any()
    return np.flatnonzero(is_kept).tolist()


def has_several(world: World, candidate: Candidate) -> bool:
    """Whether there is a choice of lifts: then they are checked without the arm first."""
    return candidate.grasp.retreat is None and len(world.policy.lifts) > 1


def find_lifts_clear_for_part(
    world: World, candidate: Candidate, T_world_tcp: pin.SE3
) -> PartLifts:
    """The lifts (3,) [m] on which the part alone collides with nothing; else what the first meets.

    A single lift is returned unchecked, for the closer look that follows.  See `lifts`.
    """
    if candidate.grasp.retreat is not None:
        return list(lifts(world, candidate, T_world_tcp)), None
    # The hands of a part's candidates are often in the same place, and asked about several times.
    approach = candidate.T_world_tcp.rotation @ candidate.grasp.approach
    key = (candidate.detection, T_world_tcp.translation.tobytes(), approach.tobytes())
    known = world.part_ways.known_lifts
    if key not in known:
        known[key] = _check_lifts(world, candidate, T_world_tcp)
    return known[key]


def _check_lifts(world: World, candidate: Candidate, T_world_tcp: pin.SE3) -> PartLifts:
    """What `find_lifts_clear_for_part` returns, where the policy names the lifts."""
    every = list(lifts(world, candidate, T_world_tcp))
    if len(every) < 2:
        return every, None
    met = world.part_ways.find_blocks(candidate.detection, [way for _, way in every])
    free = [lift for lift, what in zip(every, met, strict=True) if what is None]
    if free or met[0] is None:
        return free, None
    label, far = met[0]
    note = VerdictNote.LIFTS_TRIED(way=far, lifts=len(every))
    pair = (part_label(candidate.detection), label)
    return [], Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, pair, note=note)


def find_lifts_clear_for_part_and_hand(
    world: World, candidate: Candidate, T_world_tcp: pin.SE3, most: int = MOST_CLEAR
) -> tuple[list[tuple[str, Floats]], Verdict | None]:
    """The first lifts on which neither the part nor the hand collides with anything.

    Args:
        world: of the cell and the detections.
        candidate: part, arm and grasp.
        T_world_tcp: pose of the tool at the part.
        most: this many are enough.

    Returns:
        As `find_lifts_clear_for_part`: names with ways (3,) [m], and why there is none.
    """
    free, refusal = find_lifts_clear_for_part(world, candidate, T_world_tcp)
    arm, tools = world.arm(candidate.arm), world.tool_check
    clear: list[tuple[str, Floats]] = []
    for lift in free:
        met = tools.on_way(
            arm, T_world_tcp, candidate.grasp.grip, candidate.detection, way := lift[1]
        )
        if met is None:
            clear.append(lift)
            if len(clear) == most:
                break
        elif refusal is None:
            note = VerdictNote.LIFT_ENDS(
                way=met[1], whole=float(np.linalg.norm(way)), lift=lift_message(lift[0])
            )
            refusal = Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, met[0], note=note)
    return clear, None if clear else refusal


def _directions(
    world: World, candidate: Candidate, T_world_tcp: pin.SE3, name: LiftName
) -> Iterator[Floats]:
    """Unit vectors (3,) of the ways with a name."""
    bin, policy = world.cell.bin, world.policy
    R = bin.T_world_bin.rotation
    up = R[:, 2]
    match name:
        case "leaning":
            yield lift_direction(world, T_world_tcp)
        case "up":
            yield up
        case "back":
            back = -(candidate.T_world_tcp.rotation @ candidate.grasp.approach)
            if back @ up >= LIFT_COSINE:
                yield back
        case "off-wall":
            away = R @ _from_wall(bin, T_world_tcp)
            yield _leaning(up, away, policy.lift_lean) if bin.has_walls else up
        case "around":
            angles = np.arange(LEAN_SIDES) * 2 * np.pi / LEAN_SIDES
            for lean, angle in product((policy.lift_lean, policy.lift_lean / 2), angles):
                side = R @ np.array([np.cos(angle), np.sin(angle), 0.0])
                yield _leaning(up, side, lean)
        case "any":
            for way in world.part_ways.ways_off(candidate.detection):
                yield way / policy.lift_length


def lift_direction(world: World, T_world_tcp: pin.SE3) -> Floats:
    """Straight up, leaning by the policy's angle to the middle of the bin: a unit vector (3,)."""
    up = world.cell.bin.T_world_bin.rotation[:, 2]
    inwards = world.cell.bin.T_world_bin.translation - T_world_tcp.translation
    inwards = inwards - up * (up @ inwards)
    far = float(np.linalg.norm(inwards))
    if far < 1e-3:
        return up
    lean = world.policy.lift_lean
    # Near the middle a full lean would carry the part past it.
    lean = min(lean, float(np.arctan2(far, world.policy.lift_length)))
    return _leaning(up, inwards / far, lean)


def _leaning(up: Floats, side: Floats, lean: float) -> Floats:
    return np.cos(lean) * up + np.sin(lean) * side


def _from_wall(bin: Bin, T_world_tcp: pin.SE3) -> Floats:
    """Away from the wall that is nearest to the hand, in the bin's frame: a unit vector (3,)."""
    p = bin.T_world_bin.actInv(T_world_tcp).translation
    axis = int(np.argmin(np.asarray(bin.size[:2]) / 2 - np.abs(p[:2])))
    away = np.zeros(3)
    away[axis] = -1.0 if p[axis] > 0 else 1.0
    return away
