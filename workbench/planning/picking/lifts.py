"""Ways in which a part is taken out of the bin, by name, in the order of the policy.

`leaning`: up, leaning to the middle of the bin, as the thesis does.  `up`: straight up.  `back`:
out again as the hand came in.  `off-wall`: up, leaning away from the wall that is nearest.
`around`: up, leaning to each of six sides, for parts that others hold down.
"""

from collections.abc import Iterator
from weakref import WeakKeyDictionary

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import Bin, LiftName
from workbench.model.geometry import Floats
from workbench.planning.collision.bodies import part_label
from workbench.planning.collision.part_ways import PartWays
from workbench.planning.collision.world import World

AUTHORED = "as authored"
"""The way of a grasp that says how the part is taken out."""

SIDES = 6

STEEPEST = np.cos(np.deg2rad(60.0))
"""The way back out is a lift when it rises at least like this."""

ALIKE = np.cos(np.deg2rad(4.0))
"""Ways that differ by less than this angle are one."""


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
    tried: list[Floats] = []
    for name in policy.lifts:
        for direction in _directions(world, candidate, T_world_tcp, name):
            if not any(direction @ other > ALIKE for other in tried):
                tried.append(direction)
                yield name, policy.lift_length * direction


def free_lifts(
    world: World, candidate: Candidate, T_world_tcp: pin.SE3
) -> tuple[list[tuple[str, Floats]], Verdict | None]:
    """The lifts (3,) [m] on which the part itself meets nothing; else what the first of them meets.

    Where there is but one lift it is left to the closer look that follows.  See `lifts`.
    """
    every = list(lifts(world, candidate, T_world_tcp))
    if len(every) < 2:
        return every, None
    if world not in _WAYS:
        _WAYS[world] = PartWays(world.cell, world.detections, world.obstacles)
    met = _WAYS[world].blocked(candidate.detection, [way for _, way in every])
    free = [lift for lift, what in zip(every, met, strict=True) if what is None]
    if free or met[0] is None:
        return free, None
    label, far = met[0]
    note = f"after {far * 1000:.0f} mm; {len(every)} lifts tried"
    pair = (part_label(candidate.detection), label)
    return [], Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, pair, 0.0, note=note)


_WAYS: WeakKeyDictionary[World, PartWays] = WeakKeyDictionary()


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
            if back @ up >= STEEPEST:
                yield back
        case "off-wall":
            yield _leaning(up, R @ _from_wall(bin, T_world_tcp), policy.lift_lean)
        case "around":
            for angle in np.arange(SIDES) * 2 * np.pi / SIDES:
                side = R @ np.array([np.cos(angle), np.sin(angle), 0.0])
                yield _leaning(up, side, policy.lift_lean)


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
