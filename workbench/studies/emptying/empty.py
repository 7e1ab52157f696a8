"""One pile taken out of the bin, plan after plan, as far as it goes."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import cycle, islice

import numpy as np

from workbench.app.core.outcomes import AVOID_SCANS, MOST_FAILURES, SAME_PLACE
from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.row import plan_row
from workbench.app.runtime.work import find_parts
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.candidate import Verdict
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.part import Part
from workbench.model.plan import Plan, PlanResult
from workbench.model.scan import ALL_KINDS, Detection, Obstacle
from workbench.perception.scene.unexplained import unexplained
from workbench.perception.simulation.piles import check_room, drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.simulation.unloading import is_in_bin, unloaded
from workbench.planning.collision.world import World
from workbench.planning.picking.propose import propose
from workbench.planning.planners.clock import working_time
from workbench.plugins.progress import never, silent
from workbench.studies.emptying.bound import bound_of
from workbench.studies.emptying.changes import changed
from workbench.studies.emptying.left import left_in
from workbench.studies.emptying.scene import FAILURES, TOGETHER, Scene, Task
from workbench.studies.emptying.taking import carried_out, failure, in_turn

IDLE = 3
"""So many looks in a row that bring no plan end it."""

SEEDS = 1000
"""Each pile has so many seeds for its looks; no bin takes as many."""


def cell_of(name: str, part: str) -> Cell:
    """The cell, picking what `Task.part` names.

    Raises:
        InputError: cell or part cannot be read.
    """
    cell = read_cell(name)
    if part in ("", ALL_KINDS):
        return cell if part else replace(cell, parts=cell.parts[:1])
    known = {one.name: one for one in cell.parts}
    kinds = (known[one] if one in known else read_part(one) for one in part.split(TOGETHER))
    return replace(cell, parts=tuple(kinds))


def check_task(task: Task) -> None:
    """Look whether a pile can be made and anything in it be taken at all.

    Raises:
        InputError: no parts, more than fit, one larger than the bin, no grasps, or none that any
            tool of the cell can do.
    """
    cell = cell_of(task.cell, task.part)
    if not cell.parts:
        raise InputError(f"cell {cell.name} has no part, so there is nothing to drop into its bin")
    check_room(_kinds(cell, task.count), cell.bin)
    for part in cell.parts:
        _check_grasps(cell, part)


def _check_grasps(cell: Cell, part: Part) -> None:
    grasps = [grasp for grasp in part.grasps if grasp.is_enabled]
    if not grasps:
        raise InputError(f"part {part.name} has no grasp, so nothing can take it; author one first")
    reasons: Counter[str] = Counter()
    for grasp in grasps:
        for arm in cell.arms:
            low, high = arm.tool.stroke
            if grasp.arms and arm.name not in grasp.arms:
                reasons[f"is for arm {' or '.join(grasp.arms)}"] += 1
            elif grasp.tool and grasp.tool != arm.tool.name:
                reasons[f"is for tool {grasp.tool}, arm {arm.name} carries {arm.tool.name}"] += 1
            elif arm.tool.fingers and not low <= grasp.opening <= high:
                reasons[
                    f"needs an opening of {grasp.opening * 1e3:g} mm, tool {arm.tool.name} opens "
                    f"{low * 1e3:g} to {high * 1e3:g} mm"
                ] += 1
            else:
                return
    why, _ = reasons.most_common(1)[0]
    raise InputError(
        f"no tool of cell {cell.name} fits a grasp of part {part.name}: each of {len(grasps)} "
        f"grasps is refused, most of them so: it {why}"
    )


def _kinds(cell: Cell, count: int) -> tuple[Part, ...]:
    return tuple(islice(cycle(cell.parts), count))


@dataclass(slots=True)
class _Tally:
    """What has happened so far with one pile."""

    taken: int = 0
    rolled: int = 0
    failed: Counter[str] = field(default_factory=Counter[str])
    touches: int = 0
    knocked_out: int = 0
    cycles: int = 0
    scans: int = 0
    motion: float = 0.0
    planning: list[float] = field(default_factory=list[float])
    stages: Counter[str] = field(default_factory=Counter[str])
    finding: float = 0.0
    seen: tuple[Detection, ...] = ()


def emptied(task: Task) -> Scene:
    """Drop a pile and take its parts out until nothing can be taken, or pick after pick fails.

    The seed of the pile decides everything: it is the same wherever this runs, but for the measured
    times.
    """
    cell = _warm(task.cell, task.part, task.seen, task.change)
    lying = list(enumerate(pile_of(task, cell)))
    tally = _Tally()
    refusal: Verdict | None = None
    avoided: list[tuple[Detection, int]] = []
    idle = failures = 0
    while lying and idle < IDLE and failures < MOST_FAILURES:
        seed = (task.seed * SEEDS + tally.scans) % SEED_LIMIT
        tally.scans += 1
        avoided = [(one, age - 1) for one, age in avoided if age > 0]
        result = _look_and_plan(cell, task, [one for _, one in lying], avoided, seed, tally)
        plan = None if result is None else result.plan
        if result is None or plan is None or result.proof is None or not result.proof.holds:
            has_pick = result is not None and any(one.verdict.is_ok for one in result.candidates)
            refusal = result.verdict if result is not None and has_pick else None
            # What is left alone for a while gets its turn before this counts as the end.
            idle += not avoided
            continue
        idle = 0
        tally.cycles += 1
        for plan in result.plans:
            missed = _carry_out(cell, task, plan, lying, tally)
            failures = failures + len(missed) if len(missed) == len(plan.arms) else 0
            avoided += [(plan.detections[number], AVOID_SCANS) for number in missed]
            if missed:
                # Whatever is in doubt ends a row.
                break
    known = _as_seen(lying, tally.seen)
    left = left_in(
        cell,
        known,
        refusal=refusal,
        seed=task.seed,
        is_stopped=failures >= MOST_FAILURES,
        fixes=not task.change,
    )
    more = None
    if task.bounds:
        rest = [one for _, one in lying]
        told, more = bound_of(cell, rest, settles=task.settles, seed=task.seed)
        left = tuple(
            replace(one, any_grasp=str(found)) for one, found in zip(left, told, strict=True)
        )
    return Scene(
        task,
        task.count,
        tally.taken,
        tuple(tally.failed[kind] for kind in FAILURES),
        tally.touches,
        tally.knocked_out,
        tally.cycles,
        tally.scans,
        tally.motion,
        left,
        tuple(tally.planning),
        tuple(tally.stages.items()),
        tally.finding,
        more,
        tally.rolled,
    )


def pile_of(task: Task, cell: Cell) -> tuple[Detection, ...]:
    """The parts in the bin of `cell`, lying in it as in the bin of the task's cell unchanged."""
    plain = cell_of(task.cell, task.part)
    pile = drop_parts(_kinds(plain, task.count), plain.bin, seed=task.seed)
    if not task.change:
        return pile
    step = cell.bin.T_world_bin * plain.bin.T_world_bin.inverse()
    return tuple(replace(one, T_world_part=step * one.T_world_part) for one in pile)


@lru_cache(maxsize=4)
def _warm(name: str, part: str, seen: str, change: str) -> Cell:
    """The cell, after one plan: compiled code is loaded before a clock runs."""
    cell = changed(cell_of(name, part), change)
    pile = drop_parts(_kinds(cell, 2), cell.bin, seed=0)
    if seen == "scan":
        scan = synthesize(cell, pile, seed=0)
        find_parts(cell, {"scan": scan, "seed": 0}, silent, never)
    plan_pick(cell, pile, "warm")
    propose(World(cell, pile))  # also spares, which that plan did not need
    return cell


def _look_and_plan(
    cell: Cell,
    task: Task,
    lying: Sequence[Detection],
    avoided: Sequence[tuple[Detection, int]],
    seed: int,
    tally: _Tally,
) -> PlanResult | None:
    """A plan for what is seen; None when nothing is."""
    detections, digest = tuple(lying), "study"
    obstacles: tuple[Obstacle, ...] = ()
    if task.seen == "scan":
        scan = synthesize(cell, lying, seed=seed)
        began = working_time()
        detections = find_parts(cell, {"scan": scan, "seed": seed}, silent, never).detections
        obstacles = unexplained(cell, scan, detections)
        tally.finding += working_time() - began
        tally.seen = detections
        digest = scan.digest
    if not detections:
        return None
    result = plan_row(
        cell,
        detections,
        digest,
        picks=task.picks,
        strategy=task.strategy,
        obstacles=obstacles,
        avoided=_left_alone(detections, [one for one, _ in avoided]),
        seed=seed,
    )
    tally.planning.append(sum(result.seconds.values()))
    tally.stages.update(result.seconds)
    return result


def _as_seen(
    lying: Sequence[tuple[int, Detection]], seen: Sequence[Detection]
) -> list[tuple[int, Detection]]:
    """What lies in the bin as it lies, its roll unknown where the last scan does not show it."""

    def of(one: Detection) -> Detection:
        for found in seen:
            off = found.T_world_part.translation - one.T_world_part.translation
            if not found.roll_known and found.part == one.part and np.linalg.norm(off) < SAME_PLACE:
                return replace(one, roll_known=False, roll_axis=found.roll_axis)
        return one

    return [(number, of(one)) for number, one in lying]


def _left_alone(detections: Sequence[Detection], failed: Sequence[Detection]) -> Mapping[int, str]:
    """Numbers of the parts whose pick has failed a short while ago, and why they are left."""
    return {
        number: "a pick of it has failed"
        for number, one in enumerate(detections)
        for other in failed
        if one.part == other.part
        and np.linalg.norm(one.T_world_part.translation - other.T_world_part.translation)
        <= SAME_PLACE
    }


def _carry_out(
    cell: Cell, task: Task, plan: Plan, lying: list[tuple[int, Detection]], tally: _Tally
) -> list[int]:
    """Take the plan's parts out of `lying`; the detections whose picks have failed."""
    tally.motion += plan.cycle_seconds
    failed: list[int] = []
    for arm_plan in in_turn(plan):
        truth = [one for _, one in lying]
        taking = carried_out(cell, truth, arm_plan, plan.detections[arm_plan.detection].part)
        tally.touches += taking.touches
        if kind := failure(taking, plan.detections[arm_plan.detection]):
            tally.failed[kind] += 1
            failed.append(arm_plan.detection)
        else:
            tally.taken += 1
            tally.rolled += taking.is_turned
        if taking.number is None:
            continue
        rest = [entry for k, entry in enumerate(lying) if k != taking.number]
        if task.settles:
            settled = unloaded(cell, truth, taking.number, taking.way)
            rest = [(number, one) for (number, _), one in zip(rest, settled, strict=True)]
        stays = [
            (number, one)
            for number, one in rest
            if is_in_bin(cell.bin, cell.part(one.part), one.T_world_part)
        ]
        tally.knocked_out += len(rest) - len(stays)
        lying[:] = stays
    return failed
