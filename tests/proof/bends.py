"""Plans bent by a seed: most must be refused, and none may hold that a judge refuses."""

from dataclasses import replace

import numpy as np
from bending import with_leg

from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import ArmPlan, Leg, Plan
from workbench.model.scan import Obstacle


def bent(cell: Cell, plan: Plan, draw: np.random.Generator) -> tuple[str, Plan]:
    """A plan with one thing changed, and what that was."""
    one = plan.arms[draw.integers(len(plan.arms))]
    leg = one.legs[draw.integers(len(one.legs))]
    kinds = (_moved, _dropped, _cut_short, _seen, _sunk, _turned, _opened, _stretched)
    kind = kinds[draw.integers(len(kinds))]
    return kind.__name__[1:], kind(cell, plan, one, leg, draw)


def _moved(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """One waypoint elsewhere, by half a degree to thirty."""
    q, row = np.array(leg.q), draw.integers(1, len(leg.q) - 1)
    way = draw.normal(size=q.shape[1])
    q[row] += way / np.linalg.norm(way) * np.deg2rad(10 ** draw.uniform(-0.3, 1.5))
    return with_leg(plan, one.arm, leg.name, q=cell.controller.motion.rounded(q), t=leg.t * 3)


def _dropped(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """Some waypoints left out, so that the way between the others is cut."""
    stays = draw.random(len(leg.q)) < 0.4
    stays[[0, -1]] = True
    return with_leg(plan, one.arm, leg.name, q=leg.q[stays], t=leg.t[stays] * 3)


def _cut_short(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """Straight from the first waypoint to the last."""
    return with_leg(plan, one.arm, leg.name, q=leg.q[[0, -1]], t=leg.t[[0, -1]] * 3)


def _seen(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """Something that the scan shows, near the bin."""
    size = draw.uniform(0.01, 0.08, 3)
    room = np.append(cell.bin.size[:2] * 0.8, 0.4)
    at = cell.bin.T_world_bin.act((draw.random(3) - [0.5, 0.5, -0.2]) * room)
    box = Obstacle(pose_from_rpy(at, (0.0, 0.0, draw.uniform(0.0, 3.0))), size)
    return replace(plan, obstacles=(*plan.obstacles, box))


def _sunk(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """Every part deeper in the bin, or higher, than where it is."""
    shift = pose_from_rpy((0.0, 0.0, draw.uniform(-0.006, 0.006)))
    parts = tuple(replace(d, T_world_part=shift * d.T_world_part) for d in plan.detections)
    return replace(plan, detections=parts)


def _turned(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """A part in the hand otherwise than it was taken."""
    way = pose_from_rpy(draw.normal(0.0, 0.004, 3), draw.normal(0.0, 0.05, 3))
    arms = tuple(
        replace(arm, T_tcp_part=arm.T_tcp_part * way) if arm is one else arm for arm in plan.arms
    )
    return replace(plan, arms=arms)


def _opened(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """Fingers otherwise than the grasp says."""
    high = cell.arm(one.arm).tool.stroke[1]
    return with_leg(plan, one.arm, leg.name, opening=float(draw.uniform(0.0, max(high, 0.01))))


def _stretched(cell: Cell, plan: Plan, one: ArmPlan, leg: Leg, draw) -> Plan:
    """A way that swings out, as a whole, between its ends."""
    swing = np.sin(np.linspace(0.0, np.pi, len(leg.q)))[:, None]
    way = draw.normal(size=leg.q.shape[1]) * np.deg2rad(10 ** draw.uniform(-0.5, 1.3))
    q = cell.controller.motion.rounded(leg.q + swing * way)
    return with_leg(plan, one.arm, leg.name, q=q, t=leg.t * 3)
