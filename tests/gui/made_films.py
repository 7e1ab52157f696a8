"""A film of a pile, made by hand: two parts are taken, one is pushed aside, one falls out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.emptying.film import Film, Filmed, FilmedPick, Shot
from workbench.model.cell import Cell
from workbench.model.messages.message import plain
from workbench.model.plan import Plan
from workbench.model.prediction import EmptiedPile, Emptying, LeftPart, PileTask
from workbench.model.scan import Detection
from workbench.planning.kinematics.robot import Kinematics


def film_of(cell: Cell, plan: Plan, detections: Sequence[Detection]) -> Film:
    """Part-1 and part-2 are those of the plan, part-3 is pushed aside, part-4 falls out."""
    kinematics = Kinematics(cell)
    aside, pushed, out = (
        Detection("keyed_cylinder", pin.SE3(np.eye(3), np.array(place)))
        for place in ((0.4, 0.0, 0.1), (0.44, 0.0, 0.1), (0.3, 0.3, 0.1))
    )
    before = (*enumerate(detections), (2, aside), (3, out))
    picks, rest = [], dict(before)
    for step in plan.sequence:
        for arm, name in step.runs:
            if name == "extract":
                number, q = plan.arm(arm).detection, plan.arm(arm).leg("extract").q[0]
                T_world_tcp = kinematics.tcp_pose(cell.arm(arm), np.asarray(q))
                T_tcp_part = T_world_tcp.actInv(rest.pop(number).T_world_part)
                rest |= {2: pushed}
                rest.pop(3, None)
                picks.append(FilmedPick(arm, number, T_tcp_part, "", tuple(rest.items())))
    shot = Shot(plan, before, tuple(picks))
    return Film(PileTask(cell.name, "keyed_cylinder", 4, 0), before, (shot,), ((2, pushed),))


def filmed_of(cell: Cell, plan: Plan, detections: Sequence[Detection]) -> Filmed:
    """What the worker brings: two piles alike, of which two parts are taken and one stays."""
    film = film_of(cell, plan, detections)
    left = (LeftPart("part-3", "tool collision", plain("the palm is in the wall by 2 mm"), ""),)
    pile = EmptiedPile(film.task, 4, 2, (0, 0, 0), 0, 1, 1, 4, plan.cycle_seconds, left, (0.1,),
                       (("propose", 0.1),), 0.0, outcomes=("", ""))  # fmt: skip
    other = replace(pile, task=replace(film.task, seed=1))
    films = (film, replace(film, task=other.task))
    return Filmed(Emptying(cell.digest, (pile, other)), films)
