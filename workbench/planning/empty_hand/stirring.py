"""The path on which a hand stirs the parts in a bin: round along its walls, then inwards.

Parts that lean on a wall or on each other, or lie beneath others, come to lie otherwise, and many
can be taken then.  The hand goes in straight at the corner that has the most room.  It goes around
the bin in rings that grow narrower, which pushes parts away from the walls, and out in the middle.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise, product

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.load import tool_loads
from workbench.model.plan import Leg, Plan
from workbench.model.scan import Scene
from workbench.planning.collision.motion import arm_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.empty_hand.alone import arm_alone, plan_alone, random_of
from workbench.planning.kinematics.inverse import configurations, starts_of
from workbench.planning.kinematics.straight import follow
from workbench.planning.picking.put_down import home_of
from workbench.planning.picking.route import free_path, leg_of
from workbench.planning.planners.clock import processor_time, working_time

INSETS = (0.02, 0.035, 0.05, 0.07, 0.09)
"""[m] From the walls to the TCP on the first ring, the nearest first."""

HEIGHTS = (0.0, 0.01, 0.02)
"""[m] Of the TCP above the height that serves best, one after the other."""

OVER_FLAT, HIGHEST_TIP = 0.001, 0.02
"""[m] Just above a part that lies flat, the hand tips those that lean on a wall or on others.
Above `HIGHEST_TIP` it passes over most parts."""

HAND_TURNS = np.deg2rad([0.0, 90.0, 45.0, 135.0, 180.0, 270.0])
"""[rad] Of the hand about its axis, one after the other."""

HALVES = ((-1.0, 1.0), (0.0, 1.0), (-1.0, 0.0))
"""Along the bin's width from its middle: all of it, then what one arm may reach."""

LEAST_RING, MOST_RINGS = 0.03, 6
"""[m] Between two rings, where parts are smaller; and how many a large bin has: a controller has
room for some hundred waypoints."""

POINT_STEP = 0.05
"""[m] From waypoint to waypoint."""

ABOVE_PARTS = 0.005
"""[m] Above all parts and the margin the hand begins and ends."""

MOST_STARTS = 8
"""Postures above the first corner that are tried."""


@dataclass(frozen=True, slots=True)
class _Rings:
    """Corners (k, 2) [m] of the path in the bin's frame, at `height` [m], under `turn` [rad]."""

    corners: Floats
    height: float
    turn: float


def route_stir(world: World, top: float, scene: Scene, *, seed: int) -> Plan | Verdict:
    """A plan in which one arm stirs the parts in the bin.

    Args:
        world: without parts; its first two obstacles stand for all of them.
        top: [m] of these obstacles, above the bin's floor.
        scene: what the plan states of the bin.
        seed: of the request.

    Returns:
        The plan; or the verdict on the path that came farthest.
    """
    began, refusal = working_time(), Verdict(Reason.OUT_OF_REACH, Stage.ROUTE)
    for arm, rings in product(world.cell.arms, _rings(world.cell, scene)):
        if processor_time() > world.deadline:
            return Verdict(Reason.OUT_OF_TIME, Stage.ROUTE)
        path = _stir_path(world, arm, rings, top, seed)
        legs = path if isinstance(path, Verdict) else _legs(world, arm, path, seed)
        if isinstance(legs, Verdict):
            refusal = max(refusal, legs, key=lambda verdict: verdict.progress)
            continue
        arm_plan = arm_alone(arm, legs, tool_loads(arm.tool))
        return plan_alone(world.cell, scene, arm_plan, seed=seed, began=began)
    return refusal


def stir_opening(cell: Cell, arm: Arm) -> float:
    """How far open [m] the fingers of an arm that stirs are: closed, where its link can say so."""
    closed, wide = arm.tool.stroke
    return closed if cell.controller.motion.takes_openings else wide


def _rings(cell: Cell, scene: Scene) -> Iterator[_Rings]:
    """What is tried: the whole bin before its halves, near walls and floor before far off."""
    sizes = [np.ptp(part.mesh.points, axis=0) for part in cell.parts]
    longest, narrow = max(np.linalg.norm(size) for size in sizes), min(cell.bin.size[:2])
    apart = float(max(longest / 2, LEAST_RING, narrow / (2 * MOST_RINGS)))
    best = min(min(float(size.min()) for size in sizes) + OVER_FLAT, HIGHEST_TIP)
    for half, inset, height, turn in product(HALVES, INSETS, HEIGHTS, HAND_TURNS):
        low, high = np.array([-0.5, half[0] / 2]), np.array([0.5, half[1] / 2])
        size = np.asarray(cell.bin.size[:2])
        low, high = low * size + inset, high * size - inset
        if np.all(high >= low):
            corners = _corners(low, high, apart, _places(cell, scene))
            yield _Rings(corners, best + height, float(turn))


def _places(cell: Cell, scene: Scene) -> Floats:
    """Where the middles of the parts are (k, 2) [m] in the bin's frame, seen from above."""
    T_bin_world = cell.bin.T_world_bin.inverse()
    middles = [
        (T_bin_world * found.T_world_part).act(np.asarray(cell.part(found.part).mesh.middle))[:2]
        for found in scene.detections
    ]
    return np.array(middles).reshape(-1, 2)


def _corners(low: Floats, high: Floats, apart: float, parts: Floats) -> Floats:
    """Corners (k, 2) [m] of rings between two corners (2,) [m], this far `apart`, then the middle.

    The first one is that farthest from the next of the `parts` (p, 2) [m].  Of the narrower side
    half a ring may be left.
    """
    corners: list[Floats] = []
    first = None
    while np.all(high - low > apart / 2):
        around = np.array([low, (high[0], low[1]), high, (low[0], high[1])])
        if first is None:
            away = np.linalg.norm(around[:, None] - parts, axis=2).min(axis=1, initial=np.inf)
            first = int(away.argmax())
        around = np.roll(around, -first, axis=0)
        corners += [*around, around[0]]
        low, high = low + apart, high - apart
    middle = (low + high) / 2
    return np.vstack([*corners, middle]) if corners else np.vstack([low, high])


def _stir_path(world: World, arm: Arm, rings: _Rings, top: float, seed: int) -> Floats | Verdict:
    """The arm's waypoints (m, n) [rad] from above the parts through them and up again."""
    chain, T_world_bin = world.chains[arm.name], world.cell.bin.T_world_bin
    R = pose_from_rpy((0.0, 0.0, 0.0), (math.pi, 0.0, rings.turn)).rotation
    inside = [np.array([*corner, rings.height]) for corner in rings.corners]
    over = [
        np.array([*point[:2], top + world.policy.margin + ABOVE_PARTS])
        for point in (inside[0], inside[-1])
    ]
    points = [over[0], *inside, over[1]]
    Ts_world_tcp = [T_world_bin * pin.SE3(R, point) for point in points]
    phase = LegPhase(
        moving=frozenset({arm.name}),
        openings={arm.name: stir_opening(world.cell, arm)},
        straight=frozenset({arm.name}),
        stirs=frozenset({arm.name}),
    )
    world.enter(phase)
    refusal = Verdict(Reason.OUT_OF_REACH, Stage.ROUTE)
    for q in configurations(chain, Ts_world_tcp[0], starts_of(chain, arm, seed)).q[:MOST_STARTS]:
        path = _follow_clear(world, arm, q, Ts_world_tcp)
        if not isinstance(path, Verdict):
            return path
        refusal = max(refusal, path, key=lambda verdict: verdict.reason is Reason.IN_COLLISION)
    return refusal


def _follow_clear(
    world: World, arm: Arm, q: Floats, Ts_world_tcp: list[pin.SE3]
) -> Floats | Verdict:
    """Waypoints (m, n) [rad] from pose to pose of the TCP, checked in the world's present phase."""
    chain, path = world.chains[arm.name], q[None]
    for T_a, T_b in pairwise(Ts_world_tcp):
        length = float(np.linalg.norm(T_b.translation - T_a.translation))
        way, share = follow(chain, path[-1], T_b, 2 + int(length / POINT_STEP))
        if share < 1.0:
            return Verdict(Reason.OUT_OF_REACH, Stage.ROUTE, q=way[-1])
        way = np.clip(world.motion.rounded(way), chain.lower, chain.upper)
        # The corner before is rounded, too.
        found = arm_contact(world, arm.name, np.vstack([path[-2:-1], way]))
        if found is not None:
            contact, at, _ = found
            return contact.refuse(Reason.IN_COLLISION, Stage.ROUTE, at)
        path = np.vstack([path[:-1], way])
    return path


def _legs(world: World, arm: Arm, path: Floats, seed: int) -> tuple[Leg, ...] | Verdict:
    """The legs there, through the parts and home again."""
    home, opening = home_of(world, arm), stir_opening(world.cell, arm)
    rng = random_of(arm, seed)
    world.enter(LegPhase(frozenset({arm.name}), {arm.name: opening}))
    reach = free_path(world, arm, home[None], path[0], rng)
    if isinstance(reach, Verdict):
        return reach
    back = free_path(world, arm, path[-1:], home, rng)
    if isinstance(back, Verdict):
        return replace(back, reason=Reason.NO_RETURN)
    return (
        leg_of(world, arm, "reach", reach, opening, None),
        leg_of(world, arm, "stir", path, opening, None),
        leg_of(world, arm, "home", back, opening, None),
    )
