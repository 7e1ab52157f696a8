"""From picks to a plan: which part goes to which arm, tried in order until a plan comes out."""

from collections.abc import Callable, Container, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, islice, product

import numpy as np

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.errors import JobCancelled
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.plans import PlanNote, strategy_message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.messages.work import CancelText
from workbench.model.plan import Plan, Strategy
from workbench.model.recipes.kit import Wanted
from workbench.planning.collision.world import World
from workbench.planning.picking.dual_arm import CARRYING, coordinate, ends_are_clear, pairs_of
from workbench.planning.picking.order import Cost, cost_of
from workbench.planning.picking.route import route
from workbench.planning.picking.weave import interleave

BOTH = (Strategy.ALTERNATED, Strategy.COORDINATED)

GRASPS_PER_ARM = 3
"""Grasps of a part that are checked for an arm, where both arms may work at once."""

WOVEN = 2
"""Pairs of them that are planned, of which the quicker is taken."""

PICKS_TRIED = 4
"""Of picks of the same parts by the same arms this many are tried until enough can be planned."""

GOOD_ENOUGH_RATIO = 1.15
"""Times as long as its busier arm works: a plan that takes no longer is good enough."""

WAITING = 0.5
"""About the share of an arm's work in which it waits where both cannot be in the bin."""

ATTEMPTS = 6
"""Assignments of parts to arms that are planned before giving up."""


def has_enough_picks(
    world: World,
    picks: Sequence[Pick],
    strategy: str,
    threshold: float,
    avoided: Container[int] = (),
    wanted: Wanted | None = None,
) -> bool:
    """Whether resolving more candidates cannot give a better kind of plan.

    Two arms need two parts from different heaps; with `auto` also `threshold` apart, if any are.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: found until now.
        strategy: as that of `plan_first_feasible`.
        threshold: [m] as that of `plan_first_feasible`.
        avoided: indices of parts that nobody takes for now.
        wanted: how many parts of each kind may be taken; None: any.
    """
    if strategy not in ("auto", "both", *BOTH):
        return any(strategy == Strategy.single(pick.candidate.arm) for pick in picks)
    if len(world.cell.arms) < 2 or not picks:
        return bool(picks)
    heap, at = (
        world.part_ways.heaps(world.policy.pair_gap),
        [detection.T_world_part.translation for detection in world.detections],
    )
    apart = [
        (a, b, float(np.linalg.norm(at[a] - at[b])))
        for a, b in combinations(range(len(at)), 2)
        if heap[a] != heap[b]
        and a not in avoided
        and b not in avoided
        and (wanted is None or wanted.allows([world.detections[k].part for k in (a, b)]))
    ]
    far = threshold if strategy == "auto" and world.cell.moves_both_arms else 0.0
    pairs = [(a, b) for a, b, distance in apart if distance >= far] or [(a, b) for a, b, _ in apart]
    arms: dict[int, set[str]] = {}
    for pick in picks:
        arms.setdefault(pick.candidate.detection, set()).add(pick.candidate.arm)
    able = [(arms.get(a, set[str]()), arms.get(b, set[str]())) for a, b in pairs]
    return not pairs or any(first and second and len(first | second) > 1 for first, second in able)


def plan_first_feasible(
    world: World,
    picks: list[Pick],
    strategy: str,
    threshold: float,
    scan_digest: str,
    *,
    wanted: Wanted | None = None,
    seed: int,
    cancelled: Callable[[], bool],
) -> tuple[tuple[Plan, ...], Verdict]:
    """Plans for the first assignment of parts to arms for which there is one.

    The arms are planned in turn; then their legs overlap where that is faster.  With
    `coordinated` both arms are also planned leg by leg.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: all that work.
        strategy: with `auto` both arms may work at once on parts that lie far enough apart, where
            the controller can move them so.
        threshold: [m] with `auto`, two arms work at once only on parts at least this far apart.
        scan_digest: what the detections were found in.
        wanted: how many parts of each kind may be taken; None: any.
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
    request = _Request(world, picks, strategy, threshold, scan_digest, wanted, seed)
    for chosen, assigned in islice(_assignments(request), ATTEMPTS):
        if cancelled():
            raise JobCancelled(CancelText.PLANNING())
        result = _plan_picks(request, chosen, assigned, cancelled)
        if not isinstance(result, Verdict):
            return result, Verdict(Reason.OK, Stage.ROUTE)
        verdict = result
        if verdict.reason is Reason.OUT_OF_TIME:
            break
    return (), verdict


@dataclass(frozen=True, slots=True, eq=False)
class _Request:
    """What plans are made of: see `plan_first_feasible`."""

    world: World
    picks: Sequence[Pick]
    strategy: str
    threshold: float
    scan_digest: str
    wanted: Wanted | None
    seed: int

    @property
    def cost(self) -> Cost:
        """What it costs to take a part first."""
        return cost_of(self.world, self.world.policy.order)

    def may_work_at_once(self, assigned: Sequence[Pick]) -> bool:
        """Whether any legs of two arms may run at once, by strategy, controller and distance."""
        if len(assigned) < 2 or self.strategy == Strategy.ALTERNATED:
            return False
        is_auto = self.strategy != Strategy.COORDINATED
        is_far = _distance_between(self.world, assigned) >= self.threshold
        return self.world.cell.moves_both_arms and is_far if is_auto else True


def _plan_picks(
    request: _Request, chosen: Strategy, assigned: Sequence[Pick], cancelled: Callable[[], bool]
) -> tuple[Plan, ...] | Verdict:
    """Plans for some picks, the quickest first, or why there is none."""
    world, is_free = request.world, request.may_work_at_once(assigned)
    best: tuple[Plan, ...] = ()
    refusal: Verdict | None = None
    tried = 0
    for pair in islice(_similar_picks(request, assigned, is_free=is_free), PICKS_TRIED):
        if cancelled():
            raise JobCancelled(CancelText.PLANNING())
        found = _route(request, chosen, pair, is_free=is_free)
        if isinstance(found, Verdict):
            if found.reason is Reason.OUT_OF_TIME:
                refusal = found
                break
            refusal = refusal or found
            continue
        if not best or found[0].cycle_seconds < best[0].cycle_seconds:
            best = found
        tried += 1
        if not is_free or tried == WOVEN:
            break
        if best[0].cycle_seconds < GOOD_ENOUGH_RATIO * max(arm.seconds for arm in best[0].arms):
            break
    if request.strategy == Strategy.COORDINATED and len(best) > 1:
        # Whatever runs at once in it.
        return (replace(best[0], strategy=Strategy.COORDINATED), *best[1:])
    if request.strategy == Strategy.COORDINATED:
        at_once = coordinate(world, assigned, scan_digest=request.scan_digest, seed=request.seed)
        if isinstance(at_once, Plan):
            return (at_once, *best)
        notes = (PlanNote.NOT_AT_ONCE(verdict=at_once.message),)
        best = tuple(replace(plan, notes=notes) for plan in best)
    return best or refusal or Verdict(Reason.NO_PATH, Stage.ROUTE)


def _route(
    request: _Request, chosen: Strategy, assigned: Sequence[Pick], *, is_free: bool
) -> tuple[Plan, ...] | Verdict:
    """Plans for just these picks, the quickest first."""
    world = request.world
    is_auto = request.strategy == "auto"
    plan = route(
        world,
        assigned,
        chosen,
        scan_digest=request.scan_digest,
        seed=request.seed,
        notes=tuple(_notes(world, assigned, request.threshold)) if is_auto else (),
        since=CARRYING if is_free else 0,
    )
    if isinstance(plan, Verdict):
        return plan
    if len(assigned) < 2 or not (is_free or world.cell.moves_both_arms):
        return (plan,)
    found = interleave(world, plan, freely=is_free)
    # The second arm's first legs may meet what the first has placed: then they are planned anew.
    return found or _route(request, chosen, assigned, is_free=False)


def _similar_picks(
    request: _Request, assigned: Sequence[Pick], *, is_free: bool
) -> list[Sequence[Pick]]:
    """Picks of the same parts by the same arms, those first that promise most.

    In turns these are the given ones.  Where both arms may be in the bin they can work at once;
    mostly, when they can stand side by side at the ends of their legs; if not, one has to wait.
    """
    world = request.world
    if any(part.library.pairs for part in world.cell.parts):
        return [assigned]
    choices = [
        sorted(
            (other for other in request.picks if _is_alike(assigned_pick, other)),
            key=lambda pick: pick.seconds,
        )[:GRASPS_PER_ARM]
        for assigned_pick in assigned
    ]

    def promise(picks: Sequence[Pick]) -> float:
        if not is_free:
            return sum(pick.seconds for pick in picks)
        less, more = sorted(pick.seconds for pick in picks)
        return more + (0.0 if ends_are_clear(world, picks) else WAITING * less)

    others: list[Sequence[Pick]] = sorted(product(*choices), key=promise)
    return (
        others
        if is_free
        else [assigned, *(choice for choice in others if choice != tuple(assigned))]
    )


def _is_alike(pick: Pick, other: Pick) -> bool:
    """Whether two picks are of one part by one arm, preferred alike, and come off alike."""
    a, b = pick.candidate, other.candidate
    same = (a.arm, a.detection, a.grasp.priority) == (b.arm, b.detection, b.grasp.priority)
    return same and pick.rubs == other.rubs


def _assignments(request: _Request) -> Iterator[tuple[Strategy, tuple[Pick, ...]]]:
    """Ways to give parts to arms, best first: two arms where possible, then one.

    Parts that only rub off along what they lie against wait until nothing else can be taken: what
    they would drag may be gone by then.

    Of more arms any two may work, while the others stand at home.  For each arm and part the pick
    that takes the least time stands; or all of them where the grasps of a part go by pairs;
    pairs are ordered by the sum of their costs, and the arm with the less goes first.
    """
    best: dict[tuple[str, int], Pick] = {}
    cost = request.cost
    for pick in request.picks:
        key = (pick.candidate.arm, pick.candidate.detection)
        if key not in best or _preference(pick) < _preference(best[key]):
            best[key] = pick
    ordered = sorted(best.values(), key=lambda pick: (cost(pick), pick.seconds))
    for do_rub in (False, True):
        for chosen, assigned in _by_cost(request, ordered, cost):
            if any(pick.rubs for pick in assigned) == do_rub:
                yield chosen, assigned


def _preference(pick: Pick) -> tuple[int, bool, float]:
    """What is least for the pick of a part by an arm that stands for the others."""
    return -pick.candidate.grasp.priority, pick.rubs, pick.seconds


def _by_cost(
    request: _Request, ordered: Sequence[Pick], cost: Cost
) -> Iterator[tuple[Strategy, tuple[Pick, ...]]]:
    """All ways to give parts to arms, least cost first; `ordered` has a pick for each of them."""
    world, strategy = request.world, request.strategy
    if strategy in ("auto", *BOTH):
        has_pairs = any(part.library.pairs for part in world.cell.parts)
        pairs = pairs_of(world, request.picks if has_pairs else ordered, cost)
        for pair in filter(_of_several_heaps(world), pairs):
            kinds = [world.detections[pick.candidate.detection].part for pick in pair]
            if request.wanted is None or request.wanted.allows(kinds):
                yield Strategy.ALTERNATED, pair
    for pick in ordered:
        alone = Strategy.single(pick.candidate.arm)
        if strategy in ("auto", alone):
            yield alone, (pick,)


def _nobody_for(picks: Sequence[Pick], strategy: str) -> Message:
    """Why a strategy has nothing to do, though there are picks."""
    arms: dict[int, set[str]] = {}
    for pick in picks:
        arms.setdefault(pick.candidate.detection, set()).add(pick.candidate.arm)
    text = VerdictNote.NEEDS_TWO_ARMS if strategy in BOTH else VerdictNote.NEEDS_ARM
    possible = (
        VerdictNote.BY_ARMS(part=FoundPart(k), arms=sorted(names))
        for k, names in sorted(arms.items())
    )
    return text(strategy=strategy_message(strategy), possible=possible)


def _of_several_heaps(world: World) -> Callable[[Sequence[Pick]], bool]:
    """Whether parts lie apart, so that none moves as another is lifted: else the scan is not true.

    Parts nearer to each other than the policy's `pair_gap` are of one heap.
    """
    heap = world.part_ways.heaps(world.policy.pair_gap)
    return lambda picks: len({heap[p.candidate.detection] for p in picks}) == len(picks)


def _distance_between(world: World, picks: Sequence[Pick]) -> float:
    """How far two parts lie from each other [m]."""
    first, second = (
        world.detections[pick.candidate.detection].T_world_part.translation for pick in picks
    )
    return float(np.linalg.norm(first - second))


def _notes(world: World, picks: Sequence[Pick], threshold: float) -> Iterator[Message]:
    """Why this strategy was taken, for people."""
    if len(world.cell.arms) < 2:
        return
    if len(picks) < 2:
        yield PlanNote.NO_OTHER_ARM()
        return
    distance = _distance_between(world, picks)
    text = PlanNote.NEARER if distance < threshold else PlanNote.FARTHER
    yield text(distance=distance, threshold=threshold)
