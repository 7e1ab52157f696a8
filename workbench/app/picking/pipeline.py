"""The line from detections to a proven plan: one function for page, command line and studies."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from types import MappingProxyType

import numpy as np

from workbench.app.core.rules import strategies_of
from workbench.model.candidate import Candidate, Pick, Reason, Stage, Verdict
from workbench.model.cell import Cell, Wishes
from workbench.model.errors import InputError, JobCancelled
from workbench.model.plan import Plan, PlanResult, Strategy
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.planning.collision.part_ways import heaps
from workbench.planning.collision.world import World
from workbench.planning.picking.dual_arm import OFFSETS, coordinate, pairs_of, side_by_side
from workbench.planning.picking.order import Cost, cost_of
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve
from workbench.planning.picking.route import route
from workbench.planning.planners.clock import working_time
from workbench.plugins.robot_link import misfit
from workbench.proof.prove import prove

Report = Callable[[float, str], None]
"""Called with the share done, 0..1, and what is being done."""

BOTH = (Strategy.ALTERNATED, Strategy.COORDINATED)

AS_THE_CELL = Wishes()

NOTHING: Mapping[int, str] = MappingProxyType({})

SIDE_BY_SIDE = 3
"""Pairs of picks that are planned side by side before one arm follows the other."""

ENOUGH = 2
"""Grasps of a priority below 0 that work for an arm and a part, before the others are left out."""

ATTEMPTS = 6
"""Assignments of parts to arms that are planned before giving up."""


def plan_pick(
    cell: Cell,
    detections: tuple[Detection, ...],
    scan_digest: str,
    *,
    strategy: str = "auto",
    threshold: float | None = None,
    wishes: Wishes = AS_THE_CELL,
    obstacles: tuple[Obstacle, ...] = (),
    avoided: Mapping[int, str] = NOTHING,
    seed: int = 0,
    report: Report = lambda done, note: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> PlanResult:
    """Judge every candidate, choose, plan, and prove.

    Args:
        cell: with its parts and policy.
        detections: the parts found, at least one.
        scan_digest: what they were found in.
        strategy: see `check_strategy`.
        threshold: [m] distance between the parts; None takes the cell's policy.
        wishes: what this request changes of the cell's policy.
        obstacles: what the scan shows beside the parts.
        avoided: indices of parts that are left alone for now, and why; they stay obstacles.
        seed: of everything random.
        report: progress.
        cancelled: asked between candidates; True ends the work.

    Raises:
        InputError: no detections, or a strategy that is not known or not available.
        JobCancelled: `cancelled` said so.
    """
    if not detections:
        raise InputError("no parts were given, so there is nothing to plan")
    check_strategy(cell, strategy)
    began = working_time()
    seconds: dict[str, float] = {}

    def lap(stage: str) -> None:
        nonlocal began
        now = working_time()
        seconds[stage], began = now - began, now

    proposed = _without(avoided, propose(cell, detections, obstacles))
    lap("propose")
    policy = wishes.on(cell.policy)
    world = World(cell, detections, obstacles, policy)
    world.deadline = working_time() + policy.seconds
    judged, picks = _judged(world, proposed, seed, report, cancelled)
    lap("resolve")
    threshold = cell.policy.threshold if threshold is None else threshold
    wanted = BOTH if strategy == "both" else (strategy,)
    results: list[PlanResult] = []
    for one in wanted:
        took = dict(seconds)
        began = working_time()
        plan, verdict, proof = None, _summary(judged), None
        if picks:
            plan, verdict = _planned(world, picks, one, threshold, scan_digest, seed, cancelled)
            took["route"], began = working_time() - began, working_time()
        if plan is not None:
            report(0.9, "proving the plan")
            proof = prove(cell, Scene(scan_digest, detections, obstacles), plan)
            took["prove"] = working_time() - began
            plan = replace(plan, seconds=took)
        results.append(PlanResult(judged, plan, proof, verdict, took, obstacles, policy.planner))
    return _best(cell, results)


def check_strategy(cell: Cell, strategy: str) -> None:
    """Look whether a strategy says anything about a cell.

    One for two arms does so in a cell with one: that none comes of it is the verdict of planning.

    Raises:
        InputError: it is neither a word for strategies nor the name of an arm of the cell.
    """
    if strategy not in (*BOTH, *strategies_of(cell), "both"):
        raise InputError(
            f"strategy {strategy!r:.60} is not one of {', '.join(strategies_of(cell))} "
            f"in cell {cell.name}"
        )


def _without(
    avoided: Mapping[int, str], candidates: tuple[Candidate, ...]
) -> tuple[Candidate, ...]:
    """The candidates, those of avoided parts refused."""
    return tuple(
        replace(one, verdict=Verdict(Reason.DISABLED, Stage.PROPOSE, note=avoided[one.detection]))
        if one.detection in avoided
        else one
        for one in candidates
    )


def _best(cell: Cell, results: list[PlanResult]) -> PlanResult:
    """Of several strategies the quickest that holds and can be sent, the others beside it."""

    def rank(result: PlanResult) -> tuple[bool, bool, float]:
        plan, proof = result.plan, result.proof
        if plan is None or proof is None:
            return (True, True, math.inf)
        return (not proof.holds, misfit(plan, cell) != "", plan.cycle_seconds)

    best, *others = sorted(results, key=rank)
    return replace(best, beside=tuple(others))


def judge(
    cell: Cell,
    detections: tuple[Detection, ...],
    *,
    obstacles: tuple[Obstacle, ...] = (),
    seed: int = 0,
    report: Report = lambda done, note: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> tuple[Candidate, ...]:
    """Every candidate with its verdict, up to the place; see `plan_pick`."""
    world = World(cell, detections, obstacles)
    return _judged(world, propose(cell, detections, obstacles), seed, report, cancelled)[0]


def _judged(
    world: World,
    candidates: tuple[Candidate, ...],
    seed: int,
    report: Report,
    cancelled: Callable[[], bool],
) -> tuple[tuple[Candidate, ...], list[Pick]]:
    """Every candidate with its final verdict, and the picks of those that work."""
    judged: list[Candidate] = []
    picks: list[Pick] = []
    working: dict[tuple[str, int], list[Candidate]] = {}
    for number, candidate in enumerate(candidates):
        if cancelled():
            raise JobCancelled("planning was cancelled")
        report(
            0.05 + 0.6 * number / len(candidates), f"candidate {number + 1} of {len(candidates)}"
        )
        if working_time() > world.deadline:
            if candidate.verdict.is_ok:
                late = Verdict(Reason.OUT_OF_TIME, candidate.verdict.stage)
                judged.append(replace(candidate, verdict=late))
            else:
                judged.append(candidate)
            continue
        others = working.setdefault((candidate.arm, candidate.detection), [])
        if candidate.verdict.is_ok and _is_spare(candidate, others):
            note = f"a spare: {others[0].grasp.name} works and goes first"
            spare = Verdict(Reason.DISABLED, candidate.verdict.stage, note=note)
            judged.append(replace(candidate, verdict=spare))
            continue
        result = resolve(world, candidate, seed=seed)
        if isinstance(result, Pick):
            picks.append(result)
            others.append(candidate)
            verdict = Verdict(Reason.OK, Stage.PLACE, note=_told(world, result))
            judged.append(replace(candidate, verdict=verdict))
        else:
            judged.append(replace(candidate, verdict=result))
    return tuple(judged), picks


def _is_spare(candidate: Candidate, working: Sequence[Candidate]) -> bool:
    """Whether nobody needs a grasp any more, since others of the same arm and part work.

    Grasps of a priority below 0 are for parts that nothing else takes: they are looked at only
    then, and `ENOUGH` of them that work will do.
    """
    if candidate.grasp.priority >= 0 or not working:
        return False
    before = working[0].grasp.priority > candidate.grasp.priority
    return before or len(working) >= ENOUGH


def _told(world: World, pick: Pick) -> str:
    """What to know of a candidate that works: how far it goes, its lift and its opening."""
    candidate = pick.candidate
    note = f"joint travel {np.rad2deg(pick.travel):.0f} degrees"
    if len(world.policy.lifts) > 1:
        note += f", lift {pick.lift}"
    if world.policy.least_air is not None and world.arm(candidate.arm).tool.fingers:
        note += f", fingers {candidate.grasp.opening * 1e3:.0f} mm apart"
    return note


def _summary(candidates: tuple[Candidate, ...]) -> Verdict:
    """Why nothing works: the refusal of the candidate that got furthest."""
    if not candidates:
        note = "the parts found have no grasp for any arm; author one first"
        return Verdict(Reason.DISABLED, Stage.PROPOSE, note=note)
    stages = list(Stage)
    late = next((c.verdict for c in candidates if c.verdict.reason is Reason.OUT_OF_TIME), None)
    return late or max((c.verdict for c in candidates), key=lambda v: stages.index(v.stage))


def _assignments(
    world: World, picks: list[Pick], strategy: str, cost: Cost
) -> Iterator[tuple[Strategy, tuple[Pick, ...]]]:
    """Ways to give parts to arms, best first: two arms where possible, then one.

    Of more arms any two may work, while the others stand at home.  For each arm and part the pick
    with the least joint travel stands, or all of them where the grasps of a part go by pairs;
    pairs are ordered by the sum of their costs, and the arm with the less goes first.
    """
    best: dict[tuple[str, int], Pick] = {}
    for pick in picks:
        key = (pick.candidate.arm, pick.candidate.detection)
        priority = pick.candidate.grasp.priority
        if key not in best or (-priority, pick.travel) < (
            -best[key].candidate.grasp.priority,
            best[key].travel,
        ):
            best[key] = pick
    ordered = sorted(best.values(), key=lambda pick: (cost(pick), pick.travel))
    if strategy in ("auto", *BOTH):
        has_pairs = any(part.library.pairs for part in world.cell.parts)
        pairs = pairs_of(world, picks if has_pairs else ordered, cost)
        for pair in filter(_of_several_heaps(world), pairs):
            yield Strategy.ALTERNATED, pair
    for pick in ordered:
        alone = Strategy.single(pick.candidate.arm)
        if strategy in ("auto", alone):
            yield alone, (pick,)


def _planned(
    world: World,
    picks: list[Pick],
    strategy: str,
    threshold: float,
    scan_digest: str,
    seed: int,
    cancelled: Callable[[], bool],
) -> tuple[Plan | None, Verdict]:
    """The first assignment for which a plan comes out; coordinated ones fall back to alternated.

    `auto` lets both arms work at once on parts that lie at least `threshold` [m] apart, where the
    controller can move them so.
    """
    verdict = Verdict(Reason.NO_PATH, Stage.ROUTE, note=_nobody_for(picks, strategy))
    refused, cost = "", cost_of(world, world.policy.order)
    is_auto = strategy == "auto"
    if strategy == Strategy.COORDINATED or (is_auto and world.cell.moves_both_arms):
        for offsets, pair in _side_by_side_or_behind(world, picks, cost):
            if cancelled():
                raise JobCancelled("planning was cancelled")
            if is_auto and _apart(world, pair) < threshold:
                continue
            result = coordinate(world, pair, scan_digest=scan_digest, seed=seed, offsets=offsets)
            if isinstance(result, Plan):
                if is_auto:
                    note = f"{_note(world, pair, threshold)}: {result.note}"
                    result = replace(result, note=note)
                return result, Verdict(Reason.OK, Stage.ROUTE)
            refused = f"the arms cannot work at once: {result}"
    for chosen, assigned in islice(_assignments(world, picks, strategy, cost), ATTEMPTS):
        if cancelled():
            raise JobCancelled("planning was cancelled")
        note = _note(world, assigned, threshold) if is_auto else refused
        result = route(world, assigned, chosen, scan_digest=scan_digest, seed=seed, note=note)
        if isinstance(result, Plan):
            return result, Verdict(Reason.OK, Stage.ROUTE)
        verdict = result
        if verdict.reason is Reason.OUT_OF_TIME:
            break
    return None, verdict


def _nobody_for(picks: Sequence[Pick], strategy: str) -> str:
    """Why a strategy has nothing to do, though there are picks."""
    arms: dict[int, set[str]] = {}
    for pick in picks:
        arms.setdefault(pick.candidate.detection, set()).add(pick.candidate.arm)
    can = "; ".join(f"part-{k + 1} by the {' or '.join(sorted(arms[k]))} arm" for k in sorted(arms))
    needs = "a part for that arm"
    if strategy in BOTH:
        needs = "a part for each of two arms; one arm alone would do"
    return f"strategy {strategy} needs {needs}: what can be taken is {can}"


def _side_by_side_or_behind(
    world: World, picks: list[Pick], cost: Cost
) -> Iterator[tuple[Sequence[int], tuple[Pick, ...]]]:
    """Pairs for coordinated plans, with the offsets to try: side by side first."""
    apart = filter(_of_several_heaps(world), side_by_side(world, picks, cost))
    for pair in islice(apart, SIDE_BY_SIDE):
        yield (0,), pair
    for _, pair in islice(_assignments(world, picks, Strategy.COORDINATED, cost), ATTEMPTS):
        yield OFFSETS[1:], pair


def _of_several_heaps(world: World) -> Callable[[Sequence[Pick]], bool]:
    """Whether parts lie apart, so that none moves as another is lifted: else the scan is not true.

    Parts nearer to each other than the policy's `pair_gap` are of one heap.
    """
    if world.policy.pair_gap <= 0:
        return lambda picks: True
    heap = heaps(world, world.policy.pair_gap)
    return lambda picks: len({heap[p.candidate.detection] for p in picks}) == len(picks)


def _apart(world: World, picks: Sequence[Pick]) -> float:
    """How far two parts lie from each other [m]."""
    first, second = (
        world.detections[pick.candidate.detection].T_world_part.translation for pick in picks
    )
    return float(np.linalg.norm(first - second))


def _note(world: World, picks: Sequence[Pick], threshold: float) -> str:
    """Why this strategy was taken, for people."""
    if len(world.cell.arms) < 2:
        return ""
    if len(picks) < 2:
        other = "the other" if len(world.cell.arms) == 2 else "another"
        return f"one arm: no second part can be taken by {other} arm"
    distance = _apart(world, picks)
    relation = "nearer than" if distance < threshold else "at least"
    return (
        f"the parts lie {distance * 1000:.0f} mm apart, {relation} the threshold of "
        f"{threshold * 1000:.0f} mm"
    )
