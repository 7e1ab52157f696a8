"""How deep an arm's hand goes through a part that lies somewhere, by dense sampling with Coal.

It knows nothing of phases, margins and bounds: bodies at states, and their distances.
"""

from itertools import pairwise

import coal
import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.plan import ArmPlan, Plan
from workbench.planning.collision.bodies import coal_shape
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.robot import Kinematics

STATES = 40
"""Between two waypoints."""


def T_world_put(cell: Cell, one: ArmPlan) -> pin.SE3:
    """Where an arm has put its part."""
    arm, q = cell.arm(one.arm), np.asarray(one.leg("place").q[-1])
    return Kinematics(cell).tcp_pose(arm, q) * one.T_tcp_part


def deepest(cell: Cell, plan: Plan, one: ArmPlan, name: str, placer: ArmPlan) -> float:
    """The smallest distance [m] on a leg of `one` between its hand and what `placer` has put down.

    A part in the hand counts as the hand.
    """
    part = cell.part(plan.detections[placer.detection].part)
    return nearest(cell, plan, one, name, part, T_world_put(cell, placer))


def nearest(cell: Cell, plan: Plan, one: ArmPlan, name: str, part, T_world_part) -> float:
    """As `deepest`, of any part that lies anywhere."""
    leg, world = one.leg(name), World(cell, ())
    world.enter(LegPhase(frozenset({one.arm}), {one.arm: leg.opening}))
    hand = tuple(f"{one.arm} {s.name}" for s in cell.arm(one.arm).tool.body)
    hand += tuple(f"{one.arm} {f.solid.name}" for f in cell.arm(one.arm).tool.fingers)
    held = cell.part(plan.detections[one.detection].part).pieces if leg.holding else ()
    least = np.inf
    for a, b in pairwise(np.asarray(leg.q)):
        for share in np.linspace(0.0, 1.0, STATES):
            whole = world.configuration({one.arm: a + share * (b - a)})
            bodies = list(world.place_shapes(whole, hand))
            T_world_tcp = world.chains[one.arm].pose(a + share * (b - a))
            bodies += [(s.shape, T_world_tcp * one.T_tcp_part * s.T_owner_shape) for s in held]
            for shape, T in bodies:
                for piece in part.pieces:
                    T_piece = T_world_part * piece.T_owner_shape
                    least = min(least, _distance(shape, T, piece.shape, T_piece))
    return least


def _distance(shape, T, other, T_other) -> float:
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    request.enable_signed_distance = True
    poses = (coal.Transform3s(p.rotation, p.translation) for p in (T, T_other))
    first, second = poses
    return coal.distance(coal_shape(shape), first, coal_shape(other), second, request, result)


def on_its_lift(cell: Cell, plan: Plan, one: ArmPlan, other: int) -> list[tuple[float, float]]:
    """How near [m] pieces of the part that `one` lifts are to pieces of another: first, and at all.

    Args:
        cell: that the plan is for.
        plan: whose parts lie.
        one: the arm that lifts.
        other: number of the part that stays.
    """
    lying, chain = plan.detections[other], World(cell, ()).chains[one.arm]
    kinds = [cell.part(plan.detections[k].part).pieces for k in (one.detection, other)]
    path = np.asarray(one.leg("extract").q)
    states = [a + s * (b - a) for a, b in pairwise(path) for s in np.linspace(0, 1, STATES)]
    Ts_world_part = [chain.pose(q) * one.T_tcp_part for q in states]
    found: list[tuple[float, float]] = []
    for piece in kinds[0]:
        for bed in kinds[1]:
            T_bed = lying.T_world_part * bed.T_owner_shape
            gaps = [
                _distance(piece.shape, T * piece.T_owner_shape, bed.shape, T_bed)
                for T in Ts_world_part
            ]
            found.append((gaps[0], min(gaps)))
    return found
