"""The path on which an arm drops back what it holds, from where it stands.

Straight up out of the bin first, where it does not stand clear already, with the hand as it is.
Then freely to where the hand opens, and home.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.messages.plans import leg_message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.motion import LegName
from workbench.model.plan import Leg, Plan
from workbench.model.scan import Obstacle, Scene
from workbench.model.tools.held_body import (
    HeldAmount,
    ball_label,
    held_loads,
    held_reach,
    stand_below,
    with_held,
)
from workbench.planning.collision.bodies import obstacle_label
from workbench.planning.collision.motion import arm_contact
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.empty_hand.alone import arm_alone, plan_alone, random_of
from workbench.planning.kinematics.inverse import configurations, starts_of
from workbench.planning.kinematics.straight import follow
from workbench.planning.picking.put_down import home_of
from workbench.planning.picking.route import free_path, leg_of
from workbench.planning.planners.clock import processor_time, working_time

RISES, RISE_STEP = 0.6, 0.02
"""[m] How far up the hand goes at most, and by how much each try is higher."""

POINT_STEP = 0.005
"""[m] From waypoint to waypoint on the way up: it stays straight where joints turn fast."""

HAND_TURNS = np.deg2rad([0.0, 90.0, 180.0, 270.0, 45.0, 135.0, 225.0, 315.0])
"""[rad] Of the hand about its axis where it opens."""

MOST_GOALS = 6
"""Postures where the hand opens for which the free legs are planned."""


@dataclass(frozen=True, slots=True, eq=False)
class DropTask:
    """What is to be dropped back.

    The hand of the arm of that name holds `held`.  The arm stands at `start` (n,) [rad, m], chain
    order.  The hand opens with the TCP at `point` (3,) [m] in the world.
    """

    arm: str
    held: HeldAmount
    start: Floats
    point: Floats


def route_drop(
    cell: Cell,
    task: DropTask,
    scene: Scene,
    content: tuple[Obstacle, ...],
    *,
    seed: int,
    deadline: float,
) -> Plan | Verdict:
    """A plan in which an arm drops back what it holds.

    Args:
        cell: of the arm.
        task: what is dropped back, from where, and where to.
        scene: what the plan states of the bin: no parts, and what was placed.
        content: two boxes that stand for all that lies in the bin.
        seed: of the request.
        deadline: [s] of processor time.

    Returns:
        The plan, or the verdict on its first leg that was not found.
    """
    began, boxes = working_time(), (*content, *scene.obstacles)
    holding, empty = (
        World(each, (), boxes) for each in (with_held(cell, task.arm, task.held), cell)
    )
    holding.deadline = empty.deadline = deadline
    arm, chain = holding.arm(task.arm), holding.chains[task.arm]
    q_start = np.clip(holding.motion.rounded(task.start), chain.lower, chain.upper)
    lift = _lift(holding, arm, q_start)
    if isinstance(lift, Verdict):
        return lift
    found = _free(holding, empty, arm, lift[-1], task.point, seed)
    if isinstance(found, Verdict):
        return found
    closed, wide = arm.tool.stroke
    legs: list[Leg] = []
    if len(lift) > 1:
        legs.append(leg_of(holding, arm, "lift", lift, closed, None))
    legs.append(leg_of(holding, arm, "carry", found[0], closed, None))
    legs.append(leg_of(empty, empty.arm(task.arm), "home", found[1], wide, None))
    loads = held_loads(cell, task.arm, task.held)
    arm_plan = replace(arm_alone(arm, legs, loads), held=str(task.held))
    return plan_alone(cell, scene, arm_plan, seed=seed, began=began)


def _lift(world: World, arm: Arm, q: Floats) -> Floats | Verdict:
    """The waypoints (m, n) [rad] straight up to where all is clear; one where it is already."""
    chain, T_world_bin = world.chains[arm.name], world.cell.bin.T_world_bin
    below = _labels_below(world, chain.pose(q).translation)
    T_start, up = chain.pose(q), T_world_bin.rotation[:, 2]
    if _contact_while_carrying(world, arm, q) is None:
        return q[None]
    refusal = Verdict(Reason.OUT_OF_REACH, Stage.ROUTE, q=q)
    for height in np.arange(RISE_STEP, RISES + RISE_STEP / 2, RISE_STEP):
        T_end = pin.SE3(T_start.rotation, T_start.translation + height * up)
        path, share = follow(chain, q, T_end, 2 + int(height / POINT_STEP))
        if share < 1.0 or processor_time() > world.deadline:
            break
        path = np.clip(world.motion.rounded(path), chain.lower, chain.upper)
        if (verdict := _contact_while_carrying(world, arm, path[-1])) is not None:
            refusal = verdict
            continue
        _enter(world, arm, below=below)
        met = arm_contact(world, arm.name, path)
        if met is None:
            return path
        contact, at, _ = met
        refusal = contact.refuse(Reason.IN_COLLISION, Stage.ROUTE, at)
        break
    return _with_leg(world, arm, refusal, "lift")


def _contact_while_carrying(world: World, arm: Arm, q: Floats) -> Verdict | None:
    """What is too near to the arm, or to what it may hold, at a configuration (n,) [rad]."""
    _enter(world, arm)
    contact = world.contact(world.configuration({arm.name: q}))
    if contact is None:
        return None
    return contact.refuse(Reason.IN_COLLISION, Stage.ROUTE, q)


def _free(
    holding: World, empty: World, arm: Arm, q: Floats, point: Floats, seed: int
) -> tuple[Floats, Floats] | Verdict:
    """The paths (m, n) [rad] to where the hand opens and home from there."""
    rng, refusal = random_of(arm, seed), Verdict(Reason.OUT_OF_REACH, Stage.ROUTE)
    for goal in _goals(holding, arm, q, point, seed)[:MOST_GOALS]:
        _enter(holding, arm)
        carry = free_path(holding, arm, q[None], goal, rng)
        if isinstance(carry, Verdict):
            refusal = _with_leg(holding, arm, carry, "carry")
            continue
        _enter(empty, arm, arm.tool.stroke[1])
        home = free_path(empty, arm, carry[-1:], home_of(empty, arm), rng)
        if not isinstance(home, Verdict):
            return carry, home
        refusal = _with_leg(empty, arm, replace(home, reason=Reason.NO_RETURN), "home")
    return refusal


def _goals(world: World, arm: Arm, q: Floats, point: Floats, seed: int) -> list[Floats]:
    """Configurations (n,) [rad] with the hand at a point (3,) [m], pointing down; near ones first.

    Those at which something is too near come last: the first of them states the reason.
    """
    chain, starts = (
        world.chains[arm.name],
        np.vstack([q, starts_of(world.chains[arm.name], arm, seed)]),
    )
    along = world.cell.bin.T_world_bin.rotation[:, 0]
    yaw = math.atan2(along[1], along[0])
    found: list[Floats] = []
    for turn in HAND_TURNS:
        # Plumb down, however the bin stands: so falls what the hand lets go of.
        R = pose_from_rpy((0.0, 0.0, 0.0), (math.pi, 0.0, yaw + turn)).rotation
        answers = configurations(chain, pin.SE3(R, point), starts).q
        found += list(np.clip(world.motion.rounded(answers), chain.lower, chain.upper))
    meets = [_contact_while_carrying(world, arm, goal) is not None for goal in found]
    order = sorted(range(len(found)), key=lambda k: (meets[k], np.abs(found[k] - q).max()))
    return [found[k] for k in order]


def _labels_below(world: World, p: Floats) -> frozenset[str]:
    """What cannot be met on the way up from a point (3,) [m] of the TCP, by its labels."""
    bodies, fixtures = world.surroundings.bodies, {each.name for each in world.cell.fixtures}
    scanned = {obstacle_label(number) for number in range(len(bodies))}
    solids = [
        body
        for body in bodies
        if (body.kind == "bin" or (body.kind == "fixture" and body.owner in fixtures))
        and body.label not in scanned
    ]
    shapes = [(body.shape, body.T_joint_body) for body in solids]
    below = stand_below(shapes, p, held_reach(world.cell), world.cell.bin.T_world_bin)
    found = {body.label for body, is_below in zip(solids, below, strict=True) if is_below}
    known = {id(body) for body, is_below in zip(solids, below, strict=True) if is_below}
    return frozenset(found - {body.label for body in bodies if id(body) not in known})


def _enter(
    world: World, arm: Arm, opening: float | None = None, *, below: frozenset[str] | None = None
) -> None:
    """The phase of a leg; on the way up, where `below` is stated, the tool may be among the parts.

    The `opening` [m] does not count while a hand holds something: boxes are around its fingers.
    """
    moving, opening = frozenset({arm.name}), arm.tool.stroke[0] if opening is None else opening
    openings = {arm.name: float(opening)}
    phase = LegPhase(moving, openings)
    if below is not None:
        phase = replace(phase, straight=moving, stirs=moving, below=below)
    world.enter(phase)


def _with_leg(world: World, arm: Arm, verdict: Verdict, leg: LegName) -> Verdict:
    """The verdict with its leg; where the ball meets the arm that holds it, with what to do."""
    links = {world.cell.robot.joint(joint).child for joint in arm.joints}
    pair = set(verdict.pair or ())
    if ball_label(arm.name) in pair and pair & links:
        return replace(verdict, note=VerdictNote.HELD_MEETS_ARM(arm=arm.name))
    return replace(verdict, note=VerdictNote.LEG(leg=leg_message(leg)))
