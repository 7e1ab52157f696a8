"""Every detection with every grasp and every arm, and the cheap tests that refuse most of them."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.cell import Arm, Cell, Tool
from workbench.model.derived.by_tcp import is_for, is_for_another
from workbench.model.derived.upright import leans_too_far
from workbench.model.geometry import Floats, Solid
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import Grasp, Part
from workbench.model.tools.slots import stands_in_slot
from workbench.planning.collision.tool_check import Fit, ToolCheck
from workbench.planning.collision.world import World
from workbench.planning.grasps.grip_raster import clear_grips, grips_of
from workbench.planning.grasps.rolls import at_every_turn
from workbench.planning.kinematics.quickness import tool_acceleration

TURN_WEIGHT = 0.1
"""[m/rad] What a turn of the hand counts against its way in the SE(3) index."""

_FITS = Verdict(Reason.OK, Stage.PROPOSE)
_OUTSIDE = Verdict(Reason.OUTSIDE_REGIONS, Stage.PROPOSE)


HandsLooked = Callable[[int, int], object]
"""Callback after each hand that was tried, with their number and the total."""

GRASPS_BEFORE_SPARE = 2
"""Grasps of a priority below 0 that work for an arm and a part, before the others are left out."""

SEARCH_ROUNDS = ((0, 3), (3, 10), (10, 40))
"""How many grips of a part were proposed before each round of a search, and are then: most parts
that come out do so by one of a few."""


def propose(
    world: World,
    *,
    priorities: Collection[int] | None = None,
    looked: HandsLooked = lambda count, of: None,
) -> tuple[Candidate, ...]:
    """All candidates, refused ones included, in the order in which they shall be tried.

    The order: admitted ones first, then priority, then the SE(3) index: the way of
    the TCP from home to the grasp plus `TURN_WEIGHT` times its turn.

    Args:
        world: of the cell with the parts found.
        priorities: of the grasps that are checked; None for all of them.
        looked: is called with the progress, and may end it by raising.
    """
    detections = world.detections
    grasps = grasps_of(world, priorities)
    found: dict[tuple[int, str], Iterator[Candidate]] = {}
    for numbers, arm in groups(world, grasps):
        part = detections[numbers[0]].part
        candidates = _candidates(world, numbers, grasps[part], arm)
        # All take from the same, one part after the other.
        found.update({(number, arm.name): candidates for number in numbers})
    total = sum(len(grasps[detection.part]) for detection in detections) * len(world.cell.arms)
    every: list[Candidate] = []
    for number, detection in enumerate(detections):
        for _, arm in product(grasps[detection.part], world.cell.arms):
            every.append(next(found[number, arm.name]))
            looked(len(every), total)
    every = [c for c in every if not is_for_another(c.grasp, world.arm(c.arm).tool)]
    return tuple(sorted(every, key=lambda c: (not c.verdict.is_ok, -c.grasp.priority, c.rank)))


def grasps_of(world: World, priorities: Collection[int] | None) -> dict[str, tuple[Grasp, ...]]:
    """The grasps that are checked, by part; see `propose`."""
    return {
        part.name: tuple(
            grasp for grasp in part.grasps if priorities is None or grasp.priority in priorities
        )
        for part in world.cell.parts
    }


def groups(world: World, grasps: Mapping[str, Sequence[Grasp]]) -> Iterator[tuple[list[int], Arm]]:
    """The detections that are judged together, by their numbers, with each arm."""
    for part in world.cell.parts:
        # Parts whose roll is unknown have pieces of their own.
        alike: dict[tuple[Solid, ...], list[int]] = {}
        for number, detection in enumerate(world.detections):
            if detection.part == part.name and grasps[part.name]:
                alike.setdefault(world.surroundings.pieces[number], []).append(number)
        yield from product(alike.values(), world.cell.arms)


def candidate_of(world: World, number: int, grasp: Grasp, arm: Arm) -> Candidate:
    """One candidate with its first verdict, whether or not the part's library has that grasp."""
    return next(_candidates(world, [number], (grasp,), arm))


def search_candidates(
    world: World, number: int, round: int, *, looked: HandsLooked = lambda count, of: None
) -> tuple[Candidate, ...]:
    """Candidates of one part by grips that are in no library, ordered as those of `propose`.

    They are among all grips of the tools: some that fit among the neighbours and hold the part.

    Args:
        world: of the cell with the parts found.
        number: of the part among them.
        round: which of the `SEARCH_ROUNDS`.
        looked: is called with the progress, and may end it by raising.
    """
    part, check = world.cell.part(world.detections[number].part), world.tool_check
    before, most = SEARCH_ROUNDS[round]
    if before and refuse_where_it_lies(world, number):
        return ()
    new: dict[str, tuple[Grasp, ...]] = {}
    found: list[Candidate] = []
    for count, arm in enumerate(world.cell.arms):
        looked(count, len(world.cell.arms))
        tool = arm.tool.name
        if tool not in new:
            known = check.grips.get((number, tool), ())
            # Where there were fewer than wanted there are no more.
            every = known
            if len(known) == before:
                grips = grips_of(part, arm.tool, _acceleration(world.cell, part, arm.tool))
                fit = partial(check.free, arm, number)
                every = grips.search(fit, clear_grips(world.cell, part, arm), most)
            new[tool] = tuple(grip for grip in every if grip not in known)
            check.grips[number, tool] = every
        if new[tool]:
            found += _candidates(world, [number], new[tool], arm)
    return tuple(sorted(found, key=lambda c: (not c.verdict.is_ok, c.rank)))


def _acceleration(cell: Cell, part: Part, tool: Tool) -> float | None:
    """What a grip has to hold against [m/s2]; None where nothing is stated to weigh it by."""
    is_weighed = part.friction is not None and tool.force is not None
    return tool_acceleration(cell, tool) if is_weighed else None


@dataclass(frozen=True, slots=True, eq=False)
class Tried:
    """How an arm's hand does at parts of one kind.

    `refusals` (k,) say by grasp why the arm cannot use it, None where it can; `fits` are by number
    of the detection and of such a grasp.  `R` (n, k, 3, 3) and `p` (n, k, 3) [m] are where the TCP
    would be in the world, by detection and grasp.
    """

    refusals: Sequence[Verdict | None]
    fits: Mapping[tuple[int, int], Fit]
    R: Floats
    p: Floats


def try_grasps(world: World, numbers: Sequence[int], grasps: tuple[Grasp, ...], arm: Arm) -> Tried:
    """The hand at each of some parts of one kind, by each grasp."""
    detections = world.detections
    part = world.cell.part(detections[numbers[0]].part)
    refusals = [_unfit(grasp, arm, part) for grasp in grasps]
    usable = [k for k, refusal in enumerate(refusals) if refusal is None]
    rows = [(number, k) for number in numbers for k in usable]
    fits = dict(zip(rows, world.tool_check.fits(arm, grasps, rows), strict=True))
    R_part = np.array([detections[number].T_world_part.rotation for number in numbers])
    p_part = np.array([detections[number].T_world_part.translation for number in numbers])
    R_grasp = np.array([grasp.T_part_tcp.rotation for grasp in grasps]).reshape(-1, 3, 3)
    p_grasp = np.array([grasp.T_part_tcp.translation for grasp in grasps]).reshape(-1, 3)
    R = np.einsum("nij,kjl->nkil", R_part, R_grasp)
    p = np.einsum("nij,kj->nki", R_part, p_grasp) + p_part[:, None]
    return Tried(refusals, fits, R, p)


def _candidates(
    world: World, numbers: Sequence[int], grasps: tuple[Grasp, ...], arm: Arm
) -> Iterator[Candidate]:
    """The candidates of parts of one kind with one arm, by part and grasp, with first verdicts.

    A grasp whose fingers have to be less open than it says becomes one that says so.
    """
    check, detections = world.tool_check, world.detections
    part = world.cell.part(detections[numbers[0]].part)
    hands = try_grasps(world, numbers, grasps, arm)
    R, p = hands.R, hands.p
    T_home = world.chains[arm.name].pose(np.asarray(arm.home))
    cosine = (np.einsum("ij,nkij->nk", T_home.rotation, R) - 1.0) / 2.0
    turn = np.arccos(np.clip(cosine, -1.0, 1.0))
    ranks = (np.linalg.norm(p - T_home.translation, axis=2) + TURN_WEIGHT * turn).tolist()
    for n, number in enumerate(numbers):
        refusal = refuse_where_it_lies(world, number)
        for k, grasp in enumerate(grasps):
            T_world_tcp, taken = pin.SE3(R[n, k], p[n, k]), grasp
            verdict = refusal or hands.refusals[k]
            if verdict is None:
                fit = hands.fits[number, k]
                verdict = _judge_fit(check, arm, grasp, T_world_tcp, fit)
                verdict = at_every_turn(
                    check, part, detections, number, arm=arm, grasp=grasp, fit=fit, verdict=verdict
                )
                if verdict.is_ok:
                    taken = as_it_fits(arm, grasp, fit)
            tried = number, taken, arm.name, T_world_tcp, ranks[n][k], verdict
            yield Candidate(*tried, arm.tool.tcp)


def refuse_where_it_lies(world: World, number: int) -> Verdict | None:
    """Why a part may not be taken where it lies: outside the regions, or tilted too far.

    One that a plan has put on a station may be taken wherever that is.
    """
    detection = world.detections[number]
    part, T = world.cell.part(detection.part), detection.T_world_part
    if detection.T_world_found is None and not world.cell.bin.gives(part, T):
        return _OUTSIDE
    tilt = leans_too_far(part, detection, T.rotation)
    if tilt is None:
        return None
    note = VerdictNote.LIES_TILTED(tilt=tilt, most=part.tilt)
    return Verdict(Reason.TILTED, Stage.PROPOSE, note=note)


def as_it_fits(arm: Arm, grasp: Grasp, fit: Fit) -> Grasp:
    """The grasp with the opening of the fingers on arrival at which the hand fits."""
    is_other = bool(arm.tool.fingers) and fit.opening != grasp.opening
    return open_grasp(grasp, fit.opening) if is_other else grasp


@lru_cache(maxsize=4096)
def open_grasp(grasp: Grasp, opening: float) -> Grasp:
    """The grasp with this opening [m] on arrival, the same object each time."""
    return replace(grasp, opening=opening)


def _judge_fit(check: ToolCheck, arm: Arm, grasp: Grasp, T_world_tcp: pin.SE3, fit: Fit) -> Verdict:
    """That a hand fits; or else what refuses its first way."""
    if fit.pair is None:
        return _FITS
    opening, note = 0.0, None
    if arm.tool.fingers:
        opening = grasp.grip if fit.is_closed else fit.opening
        note = VerdictNote.FINGERS(opening=opening)
    labels, distance = check.measure_pair(arm, T_world_tcp, opening, fit.pair)
    return Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, labels, distance, note=note)


def _unfit(grasp: Grasp, arm: Arm, part: Part) -> Verdict | None:
    """Why an arm cannot use a grasp, whatever is around; None when it can."""
    if not grasp.is_enabled:
        return Verdict(Reason.DISABLED, Stage.PROPOSE)
    if grasp.arms and arm.name not in grasp.arms:
        note = VerdictNote.ONLY_ARMS(arms=grasp.arms)
        return Verdict(Reason.ARM_NOT_ALLOWED, Stage.PROPOSE, note=note)
    if grasp.tool and grasp.tool != arm.tool.name:
        may_change = grasp.tool in {tool.name for tool in arm.tools}
        text = VerdictNote.CHANGE_TOOL if may_change else VerdictNote.OTHER_TOOL
        if stands_in_slot(arm, grasp.tool):
            text = VerdictNote.TOOL_IN_SLOT
        note = text(tool=grasp.tool, carried=arm.tool.name)
        return Verdict(Reason.ARM_NOT_ALLOWED, Stage.PROPOSE, note=note)
    if not is_for(grasp, arm.tool):
        note = VerdictNote.OTHER_TCP(tcp=grasp.tcp, tool=arm.tool.name)
        return Verdict(Reason.ARM_NOT_ALLOWED, Stage.PROPOSE, note=note)
    low, high = arm.tool.stroke
    if arm.tool.fingers and not low <= grasp.opening <= high:
        note = VerdictNote.STROKE(opening=grasp.opening, low=low, high=high)
        if part.tolerance:
            note = VerdictNote.STROKE_AND_TOLERANCE(stroke=note, room=2 * part.tolerance)
        return Verdict(Reason.OUT_OF_STROKE, Stage.PROPOSE, note=note)
    return None


def levels_of(cell: Cell) -> list[frozenset[int]]:
    """Priorities of grasps that are checked together: spares only when nothing before them does.

    Those below 0 are spares, each priority by itself.
    """
    every = {grasp.priority for part in cell.parts for grasp in part.grasps}
    usual = frozenset(priority for priority in every if priority >= 0)
    spares = [frozenset({priority}) for priority in sorted(every, reverse=True) if priority < 0]
    return [usual, *spares] if usual or not spares else spares


def is_spare(candidate: Candidate, working: Sequence[Candidate]) -> bool:
    """Whether nobody needs a grasp any more, since others of the same arm and part work.

    Grasps of a priority below 0 are for parts that nothing else takes: they are checked only
    then, and `GRASPS_BEFORE_SPARE` of them that work will do.
    """
    if candidate.grasp.priority >= 0 or not working:
        return False
    before = working[0].grasp.priority > candidate.grasp.priority
    return before or len(working) >= GRASPS_BEFORE_SPARE
