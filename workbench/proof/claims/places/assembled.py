"""Whether a part of an assembly comes straight onto another one and ends in its seat there."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.assembling import (
    assembled_kinds,
    assembled_pose,
    insertion_of,
    sight_problem,
)
from workbench.model.messages.message import Message
from workbench.model.messages.proofs import ProofText
from workbench.model.part import Part, PartPlace
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.recipes.kit import Insertion
from workbench.model.scan import Detection, Scene
from workbench.proof.claims.motion import dense_path
from workbench.proof.claims.places.layers import FALL, SEARCHED_BELOW, fall, standing_problem
from workbench.proof.claims.places.placed_poses import OFF_LINE, lying_violations, right_poses
from workbench.proof.claims.stages import in_hand, tcp
from workbench.proof.claims.tolerances import INSERTED, displacement
from workbench.proof.engine.robot import Tree


def assembly_violations(
    cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan
) -> Iterator[Violation]:
    """Whether a part that others come onto stands in its place, or one that comes onto it is there.

    How near the two come to each other, and to everything else, `walk` asks.
    """

    def violation(problem: Message, at: int | None = None) -> Violation:
        return Violation(problem, arm_plan.arm, "place", at)

    found = plan.detections[arm_plan.detection]
    part, insertion = cell.part(found.part), insertion_of(cell, found.part)
    kinds = [obstacle.part for obstacle in plan.obstacles]
    for kind in assembled_kinds(cell):
        if kinds.count(kind) > (kind != found.part):
            yield violation(ProofText.IN_ASSEMBLY(part=kind))
            return
    if not found.roll_known:
        yield violation(ProofText.ASSEMBLY_ROLL())
        return
    rows, at = dense_path(np.asarray(arm_plan.leg("place").q))
    T_tcp_part, arm = in_hand(cell, tree, plan, arm_plan), cell.arm(arm_plan.arm)
    way = [tcp(tree, tree.rest, arm, q) * T_tcp_part for q in rows]
    most = FALL
    if insertion is None:
        came = way[-1].translation - way[0].translation
        yield from lying_violations(arm, part, found, way[-1], came)
        if (problem := standing_problem(part, PartPlace(way[-1]), way[-1])) is not None:
            yield violation(problem)
        most += cell.policy.margin
    elif (T_base := assembled_pose(cell, plan.obstacles, insertion.base)) is None:
        yield violation(ProofText.NO_BASE(part=found.part, base=insertion.base))
        return
    else:
        for problem, number in _insertion_problems(part, insertion, T_base, way):
            yield violation(problem, None if number is None else int(at[number]))
    if (problem := _falls_far(cell, plan, found, way[-1], most)) is not None:
        yield violation(problem)


def sight_violations(
    cell: Cell, scene: Scene, plan: Plan, arm_plan: ArmPlan
) -> Iterator[Violation]:
    """Whether the scan shows the base of a part, as the scene has it whatever the plan states."""
    insertion = insertion_of(cell, plan.detections[arm_plan.detection].part)
    if insertion is None or arm_plan.station:
        return
    if (why := sight_problem(insertion, scene.obstacles, plan.scan_digest)) is not None:
        yield Violation(why, arm_plan.arm, "place")


def _insertion_problems(
    part: Part, insertion: Insertion, T_world_base: pin.SE3, way: list[pin.SE3]
) -> Iterator[tuple[Message, int | None]]:
    """What is wrong with the poses of a part on its straight motion, and at which of them."""
    points = np.asarray(part.mesh.points)
    nominal = PartPlace(T_world_base * insertion.T_base_part)
    seats = [nominal.T_world_part * T for T in right_poses(nominal, part.symmetry, way[-1])]
    T_seat = min(seats, key=lambda T: displacement(points, T, way[-1]))
    far = displacement(points, T_seat, way[-1])
    if far > INSERTED:
        yield ProofText.NOT_SEATED(far=far, most=INSERTED), None
        return
    along = T_world_base.rotation @ np.array(insertion.along)
    left = np.array([(T_seat.translation - T.translation) @ along for T in way])
    if abs(left[0] - insertion.length) > OFF_LINE:
        length, wanted = float(left[0]), insertion.length
        yield ProofText.INSERTION_LENGTH(length=length, wanted=wanted), 0
    # Past the seat it is nowhere on the line, and backing up is no way to a seat.
    on_line = np.maximum.accumulate(np.maximum(left, 0.0)[::-1])[::-1]
    for number, (T, rest) in enumerate(zip(way, on_line, strict=True)):
        T_line = pin.SE3(T_seat.rotation, T_seat.translation - rest * along)
        if (far := displacement(points, T_line, T)) > INSERTED:
            yield ProofText.OFF_INSERTION(far=far, most=INSERTED), number
            return


def _falls_far(
    cell: Cell, plan: Plan, found: Detection, T_world_put: pin.SE3, most: float
) -> Message | None:
    """That nothing carries a part, by more than `most` [m] beneath where it is released."""
    falls = fall(cell, plan.obstacles, found, T_world_put)
    if falls >= SEARCHED_BELOW:
        return ProofText.NOTHING_BENEATH(far=SEARCHED_BELOW)
    return ProofText.RELEASED_HIGH(falls=falls, most=most) if falls > most else None
