"""Where an arm may put a part of an assembly, and whether it will mate there."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell
from workbench.model.derived.assembling import (
    assembled_kinds,
    assembled_pose,
    insertion_of,
    sight_problem,
)
from workbench.model.derived.by_tcp import by_taking
from workbench.model.messages.cells import KitText
from workbench.model.messages.message import Message
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import PartPlace
from workbench.model.plan import ArmPlan, Plan
from workbench.model.recipes.joint import PlacingError
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.world import World
from workbench.planning.placing.budget import budget_by
from workbench.planning.placing.sources import localization_error, moves_by_scanner


def arm_placing(world: World, arm: Arm, number: int) -> Arm | Verdict:
    """An arm with the places that count for a part found; or why there are none.

    What a recipe assembles has to lie in a known way: places of the hand do not count.  A part that
    comes onto another one has one place, its seat there.

    Args:
        world: whose obstacles say what stands in the assembly.
        arm: that brings the part.
        number: of the detection.
    """
    found = world.detections[number]
    if found.part not in assembled_kinds(world.cell):
        return arm
    note, insertion = None, insertion_of(world.cell, found.part)
    base = "" if insertion is None else insertion.base
    T_world_base = assembled_pose(world.cell, world.obstacles, base)
    if assembled_pose(world.cell, world.obstacles, found.part) is not None:
        note = KitText.HAS_ENOUGH(part=found.part)
    elif not found.roll_known:
        note = VerdictNote.PLACE_NEEDS_ROLL()
    elif base and T_world_base is None:
        note = VerdictNote.NO_BASE(base=base)
    elif insertion is not None:
        note = sight_problem(insertion, world.obstacles)
    if note is not None:
        return Verdict(Reason.NO_PLACE, Stage.PLACE, note=note)
    arm = replace(arm, Ts_world_place=(), place_names=())
    if insertion is None or T_world_base is None:
        return arm
    x, y, z = (T_world_base.rotation @ np.array(insertion.along)).tolist()
    T_seat = T_world_base * insertion.T_base_part
    seat = PartPlace(T_seat, found.part, approach=(x, y, z), length=insertion.length)
    return replace(arm, part_places=(seat,))


def placing_error(
    cell: Cell, found: Detection, arm_plan: ArmPlan, T_world_put: pin.SE3
) -> PlacingError:
    """How far a part that an arm puts down may be off: in a nest that centres it, what that leaves.

    Args:
        cell: of the arm.
        found: the part as it is taken.
        arm_plan: that takes it.
        T_world_put: where the hand lets go of it.
    """
    places = cell.arm(arm_plan.arm).places_for(found.part)
    nest = min(
        places if insertion_of(cell, found.part) is None else (),
        key=lambda place: float(
            np.linalg.norm(place.T_world_part.translation - T_world_put.translation)
        ),
        default=None,
    )
    if nest is None or nest.centred is None:
        return held_error(cell, found, arm_plan)
    return nest_error(nest)


def held_error(cell: Cell, found: Detection, arm_plan: ArmPlan) -> PlacingError:
    """How far a part in the hand of an arm, which has taken it as `found`, may be off."""
    taking = by_taking(cell, arm_plan)
    return budget_by(taking, found, arm_plan.arm, arm_plan.T_tcp_part.inverse()).error


def nest_error(nest: PartPlace) -> PlacingError:
    """How far a part may be off at a place: none is, where nothing is stated."""
    shift, turn = nest.centred or (0.0, 0.0)
    return PlacingError(np.zeros((6, 6)), np.diag(np.square([shift] * 3 + [turn] * 3)))


def base_errors(
    cell: Cell, placed: Iterable[Detection], obstacles: Iterable[Obstacle] = ()
) -> Mapping[str, PlacingError]:
    """By their kinds, the errors of the parts that surely are in the assembly.

    Args:
        cell: whose scanner sees them.
        placed: the parts as they were put down.
        obstacles: with what a scan shows of them.
    """
    errors = {
        detection.part: detection.placing
        for detection in placed
        if detection.placing is not None and detection.score > 0
    }
    for box in obstacles:
        if box.seen is not None and box.seen.problem is None:
            errors[box.part] = _seen_error(cell, box, errors.get(box.part))
    return errors


def _seen_error(cell: Cell, box: Obstacle, believed: PlacingError | None) -> PlacingError:
    """How far a part that a scan shows may be off the pose seen."""
    assert box.seen is not None and box.seen.T_world_part is not None
    found = Detection(box.part, box.seen.T_world_part, covariance=box.seen.covariance)
    to_part = np.kron(np.eye(2), found.T_world_part.rotation.T)
    by_scanner = to_part @ moves_by_scanner(cell.scanner, found)
    return PlacingError(by_scanner, to_part @ localization_error(found) @ to_part.T, believed)


def mating_notes(cell: Cell, plan: Plan, bases: Mapping[str, PlacingError]) -> Iterator[Message]:
    """A warning for each part of a plan of which fewer will mate than its joint asks for.

    Args:
        cell: of the plan.
        plan: whose bases stand already.
        bases: see `budget_by`.
    """
    for arm_plan in plan.picks:
        found = plan.detections[arm_plan.detection]
        insertion = insertion_of(cell, found.part)
        if insertion is None or insertion.joint is None or insertion.base not in bases:
            continue
        T_part_tcp = arm_plan.T_tcp_part.inverse()
        budget = budget_by(by_taking(cell, arm_plan), found, arm_plan.arm, T_part_tcp, bases)
        if budget.chance is not None and budget.mates_seldom and not arm_plan.station:
            yield PlanNote.MATES_SELDOM(
                chance=budget.chance,
                part=found.part,
                base=insertion.base,
                share=insertion.joint.share,
            )
