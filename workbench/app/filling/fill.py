"""The library of grasps with which a cell's bin is emptied of a part, chosen by what each adds.

All grips of a tool on a fine raster are tried at the parts of simulated piles: at walls, beside
neighbours, over all ways to lie.  The grip that adds most becomes a family of grasps, then the one
that adds most to that, and so on.  Then piles are emptied, quickly and without paths, and what no
family takes while some grip does adds its own.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from workbench.app.filling.advice import advice
from workbench.app.filling.choosing import choose
from workbench.app.filling.clearing import Stays, clear_collisions
from workbench.app.filling.hand import hands_for
from workbench.app.filling.keeping import Kept, select_families
from workbench.app.filling.naming import make_name
from workbench.app.filling.work import FALL, WORK, Work
from workbench.formats.meshes.repair import examine_surface
from workbench.model.cell import Cell
from workbench.model.derived.policies import widened
from workbench.model.errors import InputError
from workbench.model.messages.message import Message
from workbench.model.messages.parts import PileText
from workbench.model.messages.verdicts import ReasonText
from workbench.model.messages.work import ProgressText
from workbench.model.part import Entry, Part
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.room import check_room
from workbench.planning.planners.clock import processor_time
from workbench.plugins.progress import Cancelled, Report, silent
from workbench.plugins.progress import never as nobody

FALLEN = (15, 8, 4)
"""Parts in the piles that are tried, one after the other; fewer where they do not fit."""

FIRST_PILES = 3
"""Piles of which the first families are chosen, as they fell."""

CHOOSING, CLEARING = 0.35, 0.88
"""Shares of the work after which no more families are chosen, and no more piles emptied."""

SEEDS = 40_000_000
"""Piles of a filling have seeds from here on: people look at others."""

FIRST_PRIORITY = -1
"""Of the families that take most.  Of spares a plan looks only at as many as it needs."""

USUAL_SHARE = 0.8
"""Share of what is taken that the families take which are checked first in each plan."""


@dataclass(frozen=True, slots=True, eq=False)
class Filled:
    """What came of a filling.

    `entries` are new, those that take most first, and `adds` the share of all parts that each takes
    beyond those before it.  Of `parts` that lay in piles `taken` came out.  `stays` says by reason
    how many no grip of the tools takes as they lie, and `lifts` how many kinds of lifts there were.
    `looked` of those at which no hand fits were checked, and `helps` are changes of tool or bin
    by which a hand would hold some.  `seconds` [s] of processor time.
    """

    entries: tuple[Entry, ...]
    adds: tuple[float, ...]
    parts: int
    taken: int
    stays: tuple[tuple[Message, int], ...]
    lifts: int
    looked: int
    helps: tuple[tuple[Message, int], ...]
    seconds: float


def filled(
    cell: Cell,
    part: Part,
    *,
    most: float = WORK,
    seed: int = 0,
    report: Report = silent,
    cancelled: Cancelled = nobody,
) -> Filled:
    """Families of grasps for a part in a cell, the most useful first.

    Args:
        cell: whose bin, arms and tools are used; the part need not be one of its parts.
        part: with its library, which counts and stays as it is.
        most: points of work after which it ends, the same on every machine.
        seed: of the piles and the samples.
        report: takes the share done and what is being done.
        cancelled: asked now and then; True ends it.

    Raises:
        InputError: the part does not fit into the bin, its mesh is inside out, or no tool of the
            cell can hold anything.
        JobCancelled: `cancelled` said so.
    """
    began = processor_time()
    policy = widened(cell.policy) if cell.policy.as_needed else cell.policy
    cell = replace(cell, parts=(part,), policy=policy)
    check_room((part,), cell.bin)
    check_mesh(part)
    work = Work(most, report, cancelled)
    hands = hands_for(cell, part, seed, work)
    if not hands:
        raise InputError(_no_hand(cell, part))
    known = {id(family) for hand in hands for family in hand.families}
    piles = _piles(cell, part, seed, work)
    taken = parts = 0
    first = [next(piles) for _ in range(FIRST_PILES)]
    for number, hand in enumerate(hands, start=1):
        choose(cell, hand, first, seed, lambda n=number: work.is_over(CHOOSING * n / len(hands)))
    stays: Counter[Message] = Counter()
    stuck: list[Stays] = []
    for pile in chain(first[::-1], piles):
        if work.is_over(CLEARING):
            break
        out, why = clear_collisions(cell, hands, pile, seed, lambda: work.is_over(CLEARING))
        taken, parts = taken + out, parts + out + len(why)
        work.note = ProgressText.FILLED(taken=taken, parts=parts)
        stays.update(left_part.reason for left_part in why)
        stuck += [
            left_part for left_part in why if left_part.reason.text is ReasonText.TOOL_COLLISION
        ]
    helps, looked = advice(cell, stuck, seed, work)
    worth = select_families(cell, hands, known, seed)
    return Filled(
        tuple(rank_entries(part, worth)),
        tuple(family.adds for family in worth),
        parts,
        taken,
        tuple(stays.most_common()),
        len(cell.policy.lifts),
        looked,
        helps,
        processor_time() - began,
    )


def check_mesh(part: Part) -> None:
    """The surface has its outside outside.

    Raises:
        InputError: it has not.
    """
    if examine_surface(part.mesh).is_inside_out:
        raise InputError(PileText.INSIDE_OUT(part=part.name))


def _no_hand(cell: Cell, part: Part) -> Message:
    """Why no tool of a cell can hold a part in any way."""
    tools = {arm.tool.name: arm.tool for arm in cell.arms}.values()
    strokes = [
        PileText.STROKE(tool=tool.name, low=tool.stroke[0], high=tool.stroke[1])
        for tool in tools
        if tool.fingers
    ]
    if not strokes:
        return PileText.NO_FINGERS(cell=cell.name)
    return PileText.NO_FACES(part=part.name, strokes=strokes)


def _piles(cell: Cell, part: Part, seed: int, work: Work) -> Iterator[tuple[Detection, ...]]:
    """Piles of the part in the cell's bin, never ending."""
    number = 0
    problem: InputError | None = None
    counts: list[int] = list(FALLEN)
    while counts:
        count = counts[number % len(counts)]
        try:
            check_room((part,) * count, cell.bin)
            pile = drop_parts((part,) * count, cell.bin, seed=SEEDS + 1000 * seed + number)
        except InputError as error:
            problem = error
            counts.remove(count)
            if not counts and count > 1:
                counts = [max(1, count // 2)]
            continue
        work.add(FALL * count**2)
        number += 1
        yield pile
    assert problem is not None
    raise problem


def rank_entries(part: Part, families: Sequence[Kept]) -> list[Entry]:
    """The entries of families with priorities and new names, in their order."""
    whole, so_far = sum(family.adds for family in families), 0.0
    taken = {entry.name for entry in part.library.entries}
    found: list[Entry] = []
    for family in families:
        priority = FIRST_PRIORITY if so_far <= USUAL_SHARE * whole else FIRST_PRIORITY - 1
        so_far += family.adds
        name = make_name(part, family.family.entry, taken)
        taken.add(name)
        entry = family.family.entry
        found.append(with_grasp(entry, replace(grasp_of(entry), name=name, priority=priority)))
    return found
