"""Parts stirred by a hand in simulation, where nothing in the bin can be taken any more."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.empty_hand.stirring import plan_stir
from workbench.app.emptying.film import Numbered, Shot
from workbench.model.cell import Cell, Tool
from workbench.model.geometry import Solid
from workbench.model.scan import Detection, Scene
from workbench.perception.simulation.stirring import stirred
from workbench.perception.simulation.unloading import is_in_bin
from workbench.planning.kinematics.chain import chain_of


def stir_pile(
    cell: Cell, lying: Sequence[tuple[int, Detection]], scene: Scene, *, seed: int
) -> Shot | None:
    """A proven plan by which a hand stirs the parts, and how they lie meanwhile; None: no plan.

    There is none either where the last look has found no part.

    Args:
        cell: with the bin.
        lying: the parts as they truly lie, with their numbers.
        scene: the parts as the last look has shown them.
        seed: of everything random.
    """
    if not scene.detections:
        return None
    result = plan_stir(cell, scene, seed=seed)
    plan = result.plan
    if plan is None or result.proof is None or not result.proof.holds:
        return None
    arm, leg = cell.arm(plan.arms[0].arm), plan.arms[0].leg("stir")
    chain, T_tcp_flange = chain_of(cell, arm), arm.tool.T_flange_tcp.inverse()
    way = [chain.pose(np.asarray(q)) * T_tcp_flange for q in leg.q]
    truth = [detection for _, detection in lying]
    frames = stirred(cell, truth, _solids(arm.tool, leg.opening), way, leg.t)
    return Shot(plan, tuple(lying), (), tuple(_remaining(cell, lying, frame) for frame in frames))


def _remaining(
    cell: Cell, lying: Sequence[tuple[int, Detection]], frame: Sequence[Detection]
) -> Numbered:
    """The parts that are still in the bin, with their numbers."""
    return tuple(
        (number, detection)
        for (number, _), detection in zip(lying, frame, strict=True)
        if is_in_bin(cell.bin, cell.part(detection.part), detection.T_world_part)
    )


def _solids(tool: Tool, opening: float) -> list[Solid]:
    """What a tool is made of, in the flange's frame, its fingers `opening` [m] apart."""
    fingers = [
        replace(
            finger.solid,
            T_owner_shape=pin.SE3(np.eye(3), opening / 2 * np.asarray(finger.direction))
            * finger.solid.T_owner_shape,
        )
        for finger in tool.fingers
    ]
    return [*tool.body, *fingers]
