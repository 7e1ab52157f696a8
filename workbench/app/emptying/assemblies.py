"""Kits that are assembled in simulated emptying: as they are believed, and as they truly stand."""

from collections import Counter
from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

from workbench.app.picking.pallets import boxes_around
from workbench.app.picking.pile_check import kinds_in_turn
from workbench.app.picking.stations import put_down
from workbench.app.standing.seen_again import with_sight
from workbench.model.cell import Cell
from workbench.model.derived.assembling import (
    assembled_kinds,
    assembled_pose,
    insertion_of,
    rest_pose,
)
from workbench.model.derived.by_recipe import kit_of
from workbench.model.geometry import Floats
from workbench.model.plan import ArmPlan, Plan
from workbench.model.prediction import PileTask
from workbench.model.recipes.kit import Insertion, lacking
from workbench.model.recipes.seen_base import SeenBase
from workbench.model.scan import Detection, Obstacle, Scan
from workbench.planning.placing.chance import draw_errors
from workbench.planning.placing.mating import mate


@dataclass(slots=True)
class Assembled:
    """The kit that is being filled, and what came of those before.

    `kit` are the kinds that it has, `placed` its parts as the hands have let go of them, `truth`
    how they truly stand.  Of the kits before, `complete` have all their parts and `unmated` have a
    part that has jammed; the latter are only counted where bases are displaced.
    """

    kit: list[str] = field(default_factory=list[str])
    placed: tuple[Detection, ...] = ()
    truth: tuple[Detection, ...] = ()
    complete: int = 0
    unmated: int = 0
    is_jammed: bool = False

    def boxes(self, cell: Cell, task: PileTask, scan: Scan | None) -> tuple[Obstacle, ...]:
        """Around its parts, bases that have to be seen where they are seen."""
        boxes = boxes_around(cell, self.placed)
        if task.seen == "scan":
            return with_sight(cell, scan, boxes)
        wanted = {box.part for box in with_sight(cell, None, boxes) if box.seen is not None}
        return tuple(self._truly(cell, box) if box.part in wanted else box for box in boxes)

    def _truly(self, cell: Cell, box: Obstacle) -> Obstacle:
        """The box around a part by its true pose, which nothing states better."""
        T_box_part = box.T_world_box.actInv(rest_pose(cell, box))
        T = next(each.T_world_part for each in self.truth if each.part == box.part)
        seen = SeenBase(TRUE_POSES, T, np.zeros((6, 6)), visible=1.0)
        return replace(box, T_world_box=T * T_box_part.inverse(), seen=seen)

    def add(self, cell: Cell, task: PileTask, plan: Plan, arm_plan: ArmPlan) -> None:
        """Count a part that was put down; after a complete kit an empty one follows."""
        items, part = kit_of(cell), plan.detections[arm_plan.detection].part
        self.kit.append(part)
        if part in assembled_kinds(cell):
            (put,) = put_down(cell, replace(plan, arms=(arm_plan,)))
            self._stand(cell, task, plan, put)
        if items and not lacking(items, Counter(self.kit)):
            self.unmated += self.is_jammed
            self.complete += not self.is_jammed
            self.kit.clear()
            self.placed, self.truth, self.is_jammed = (), (), False

    def _stand(self, cell: Cell, task: PileTask, plan: Plan, put: Detection) -> None:
        self.placed += (put,)
        T = rest_pose(cell, boxes_around(cell, self.placed)[-1])
        rng = np.random.default_rng([task.seed, self.complete + self.unmated, len(self.placed)])
        insertion = insertion_of(cell, put.part)
        if task.displaced > 0 and insertion is None:
            angle = rng.uniform(0.0, 2 * np.pi)
            shift = task.displaced * np.array([np.cos(angle), np.sin(angle), 0.0])
            T = pin.SE3(T.rotation, T.translation + shift)
        elif task.displaced > 0 and insertion is not None:
            seed = int(rng.integers(2**31))
            self.is_jammed |= not self._mates(cell, insertion, plan, put, seed)
        self.truth += (Detection(put.part, T),)

    def _mates(
        self, cell: Cell, insertion: Insertion, plan: Plan, put: Detection, seed: int
    ) -> bool:
        """Whether a part mates with its base where that truly stands.

        The simulated scanner is calibrated exactly, so that only the part's other errors count.
        """
        T_planned = assembled_pose(cell, plan.obstacles, insertion.base)
        true = next(each for each in self.truth if each.part == insertion.base)
        if T_planned is None or put.placing is None:
            return False
        off = _error(T_planned.actInv(true.T_world_part))
        if insertion.joint is None:
            return bool(np.linalg.norm(off[:3]) <= insertion.clearance)
        part = draw_errors(put.placing.covariance, 1, seed)
        return bool(mate(insertion, part, off[None])[0])


TRUE_POSES = "study"
"""Names the scan where plans are made by true poses."""


def kits_possible(cell: Cell, count: int) -> int:
    """How many whole kits a pile of this many parts makes."""
    kinds = Counter(part.name for part in kinds_in_turn(cell, count))
    return min(kinds[item.part] // item.count for item in kit_of(cell))


def _error(T: pin.SE3) -> Floats:
    """A motion as shifts, then turns (6,) [m, rad]."""
    return np.concatenate([T.translation, pin.log3(T.rotation)])
