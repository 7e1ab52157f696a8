"""What the planning of a drop back brings, by what samples there are of a plan."""

from dataclasses import replace

import numpy as np

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.plan import NO_PART, Leg, PlanResult, Step

OVER_BIN = np.deg2rad([-105.69, -49.44, 76.84, 39.27, 56.97, 11.99, 60.0])
"""[rad] Where the right arm of cell `yumi` has its hand 0.2 m over the bin, pointing down."""


def keeping_hand(cell: Cell) -> Cell:
    """A cell whose robot link begins with something in the hand."""
    motion = replace(cell.controller.motion, keeps_hand=True)
    return replace(cell, controller=replace(cell.controller, motion=motion))


def drop_result(samples, cell, held: str = "unknown") -> PlanResult:
    plan = samples.plan(digest_of(()), cell=cell)
    times, q = np.array([0.0, 1.0]), np.deg2rad([[20.0], [30.0], [60.0]])
    legs = (
        Leg("lift", "linear", True, 0.0, q[:2], times),
        Leg("carry", "joint", True, 0.0, q[1:], times),
        Leg("home", "joint", False, 0.0, np.deg2rad([[60.0], [0.0]]), times),
    )
    arm = replace(plan.arms[0], detection=NO_PART, grasp="", legs=legs, held=held)
    steps = tuple(Step((("right", leg.name),)) for leg in legs)
    plan = replace(plan, arms=(arm,), sequence=steps, detections=())
    verdict = Verdict(Reason.OK, Stage.ROUTE)
    return PlanResult((), plan, samples.proof(plan), verdict, {"route": 0.1})
