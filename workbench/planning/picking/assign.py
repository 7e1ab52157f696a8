"""From picks to a plan: which part goes to which arm, tried in order until a plan comes out."""

from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, islice

import numpy as np

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.errors import JobCancelled
from workbench.model.plan import Plan, Strategy
from workbench.planning.collision.world import World
from workbench.planning.picking.dual_arm import (
    OFFSETS,
    coordinate,
    overlapped,
    pairs_of,
    side_by_side,
)
from workbench.planning.picking.order import Cost, cost_of
from workbench.planning.picking.route import route

BOTH = (Strategy.ALTERNATED, Strategy.COORDINATED)

SIDE_BY_SIDE = 3
"""Pairs of picks that are planned side by side before one arm follows the other."""

ATTEMPTS = 6
"""Assignments of parts to arms that are planned before giving up."""


def is_enough(
    world: World,
    picks: Sequence[Pick],
    strategy: str,
    threshold: float,
    avoided: Container[int] = (),
) -> bool:
    """Whether there are picks for as many arms as a strategy lets work, and as quickly as it can.

    Where all parts are of one heap a plan takes but one of them.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: found so far.
        strategy: as that of `planned`.
        threshold: [m] see there.
        avoided: indices of parts that nobody takes for now.
    """
    if strategy not in ("auto", "both", *BOTH):
        return any(strategy == Strategy.single(pick.candidate.arm) for pick in picks)
    if len(world.cell.arms) < 2 or not picks:
        return bool(picks)
    heap, at = world.part_ways.heaps, [one.T_world_part.translation for one in world.detections]
    apart = [
        (a, b, float(np.linalg.norm(at[a] - at[b])))
        for a, b in combinations(range(len(at)), 2)
        if heap[a] != heap[b] and a not in avoided and b not in avoided
    ]
    far = threshold if strategy == "auto" and world.cell.moves_both_arms else 0.0
    pairs = [(a, b) for a, b, distance in apart if distance >= far] or [(a, b) for a, b, _ in apart]
    arms: dict[int, set[str]] = {}
    for pick in picks:
        arms.setdefault(pick.candidate.detection, set()).add(pick.candidate.arm)
    able = [(arms.get(a, set[str]()), arms.get(b, set[str]())) for a, b in pairs]
    return not pairs or any(one and other and len(one | other) > 1 for one, other in able)


def planned(
    world: World,
    picks: list[Pick],
    strategy: str,
    threshold: float,
    scan_digest: str,
    seed: int,
    cancelled: Callable[[], bool],
) -> tuple[tuple[Plan, ...], Verdict]:
    """The first assignment for which a plan comes out; coordinated ones fall back to alternated.

    Where `auto` may let both arms work at once, an alternated plan is made as well, and the quicker
    one is taken.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: all that work.
        strategy: with `auto` both arms may work at once on parts that lie far enough apart, where
            the controller can move them so.
        threshold: [m] so far.
        scan_digest: what the detections were found in.
        seed: of everything random.
        cancelled: asked between assignments; True ends the work.

    Returns:
        The plan, followed by those to fall back on where its proof is refused: in which the arms
        take turns, or work at once after all.  Empty when there is none.  And the verdict of the
        last assignment.

    Raises:
        JobCancelled: `cancelled` said so.
    """
    verdict = Verdict(Reason.NO_PATH, Stage.ROUTE, note=_nobody_for(picks, strategy))
    refused, cost = "", cost_of(world, world.policy.order)
    is_auto = strategy == "auto"
    at_once: Plan | None = None
    if strategy == Strategy.COORDINATED or (is_auto and world.cell.moves_both_arms):
        for offsets, pair in _side_by_side_or_behind(world, picks, cost):
            if cancelled():
                raise JobCancelled("planning was cancelled")
            if is_auto and _apart(world, pair) < threshold:
                continue
            result = coordinate(world, pair, scan_digest=scan_digest, seed=seed, offsets=offsets)
            if isinstance(result, Plan):
                if not is_auto:
                    return (result,), Verdict(Reason.OK, Stage.ROUTE)
                at_once = replace(result, note=f"{_note(world, pair, threshold)}: {result.note}")
                break
            refused = f"the arms cannot work at once: {result}"
    # One alternated plan is enough to be compared with.
    tries, among = (ATTEMPTS, strategy) if at_once is None else (1, Strategy.ALTERNATED)
    for chosen, assigned in islice(_assignments(world, picks, among, cost), tries):
        if cancelled():
            raise JobCancelled("planning was cancelled")
        note = _note(world, assigned, threshold) if is_auto else refused
        if at_once is not None:
            note += f"; both arms at once would take {at_once.cycle_seconds:.1f} s"
        result = route(world, assigned, chosen, scan_digest=scan_digest, seed=seed, note=note)
        if isinstance(result, Plan):
            plans = (result,)
            if chosen == Strategy.ALTERNATED and world.cell.moves_both_arms:
                shorter = overlapped(world, result)
                plans = plans if shorter is result else (shorter, result)
            if at_once is not None:
                plans = tuple(sorted((at_once, *plans), key=lambda plan: plan.cycle_seconds))
            return plans, Verdict(Reason.OK, Stage.ROUTE)
        verdict = result
        if verdict.reason is Reason.OUT_OF_TIME:
            break
    if at_once is not None:
        return (at_once,), Verdict(Reason.OK, Stage.ROUTE)
    return (), verdict


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
    heap = world.part_ways.heaps
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
