"""The map: what each holding register says, and where it is."""

from collections.abc import Iterable, Sequence
from enum import IntEnum
from functools import lru_cache

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.rows import plans_sent
from workbench.app.core.rights import obstacle
from workbench.app.core.state import Phase, State
from workbench.app.runtime.live import Live
from workbench.model.cell import Cell
from workbench.model.derived.by_view import view_name, views_of
from workbench.model.derived.place_of_plan import place_number
from workbench.model.derived.row_parts import count_taken, parts_taken

MAP_VERSION = 1
WRITTEN = 5
"""Registers from 0 on that the PLC writes."""

SIZE = 42
HIGHEST_VALUE = 65535
ACTOR = "modbus"
"""Who acts, as an operator; on record by this name."""


class Register(IntEnum):
    """Addresses; those from 0 to 4 are the PLC's own, and are read back as it wrote them."""

    SESSION_MEANT = 0
    COMMAND = 1
    ARGUMENT_1 = 2
    ARGUMENT_2 = 3
    COUNTER = 4
    VERSION = 10
    SESSION = 11
    LIFE = 12
    COUNTER_ANSWERED = 13
    COMMAND_ANSWERED = 14
    ANSWER = 15
    ERROR = 16
    PHASE = 17
    TASK = 18
    TASK_PERCENT = 19
    CONTROL = 20
    RECIPE = 21
    PARTS_FOUND = 22
    PARTS_LEFT = 23
    PARTS_PICKED = 24
    PICKS_FAILED = 25
    PARTS_PLACED = 26
    PLANS = 27
    PLANS_SENT = 28
    PROOF_HOLDS = 29
    APPROVED = 30
    MAY_GO_ON = 31
    PLAN_HIGH = 32
    PLAN_LOW = 33
    NEXT_PART = 34
    NEXT_KIND = 35
    NEXT_PLACE = 36
    ENTRY_HIGH = 37
    ENTRY_LOW = 38
    BIN = 39
    EMPTY_BINS = 40
    VIEW = 41


PHASES = tuple(Phase)
"""`PHASE` is the place in this order, from 0."""

TASKS = ("scan", "localize", "plan")
"""`TASK` is the place in this order, from 1; 4 is another task, 0 none."""


def plan_words(state: State) -> tuple[int, int]:
    """The first 32 bits of the plan's digest as two registers; 0, 0 without a plan."""
    number = 0 if state.plan is None else int(state.plan.digest[:8], 16)
    return number >> 16, number & HIGHEST_VALUE


def values_of(state: State, live: Live) -> dict[int, int]:
    """What the registers say of a state; what does not fit stays at the highest value."""
    job, begun = state.job, state.plans[: plans_sent(state)]
    said = {outcome.detection: outcome.is_picked for outcome in state.outcomes}
    control = 0 if not state.control else 1 if state.control == ACTOR else 2
    found = len(state.detections or ())
    high, low = plan_words(state)
    # A recipe leaves parts and places out; their numbers stay.
    cell = state.whole or state.cell
    bins = [box.name for box in cell.bins]
    values: dict[int, int] = {
        Register.PHASE: PHASES.index(state.phase),
        Register.TASK: 0 if job is None else _place(TASKS, job.name),
        Register.TASK_PERCENT: 0 if job is None else int(100 * live.progress_of(job.number)[0]),
        Register.CONTROL: control,
        Register.RECIPE: state.cell.recipe,
        Register.PARTS_FOUND: found,
        Register.PARTS_LEFT: max(0, found - (count_taken(begun) if begun else 0)),
        Register.PARTS_PICKED: sum(said.values()),
        Register.PICKS_FAILED: len(said) - sum(said.values()),
        Register.PARTS_PLACED: state.parts_placed,
        Register.PLANS: len(state.plans),
        Register.PLANS_SENT: plans_sent(state),
        Register.PROOF_HOLDS: state.proof is not None and state.proof.holds,
        Register.APPROVED: state.phase in (Phase.APPROVED, Phase.SENDING),
        Register.MAY_GO_ON: not obstacle(state, GoOn),
        Register.PLAN_HIGH: high,
        Register.PLAN_LOW: low,
        Register.ENTRY_HIGH: state.number >> 16,
        Register.ENTRY_LOW: state.number & HIGHEST_VALUE,
        Register.BIN: _place(bins, state.cell.bin.name),
        Register.EMPTY_BINS: _bits(name in state.empty_bins for name in bins),
        Register.VIEW: _view_number(state.cell),
    }
    if state.plan is not None and state.plan.arms:
        first = state.plan.arms[0]
        kinds = [part.name for part in cell.parts]
        values[Register.NEXT_PART] = parts_taken(state.plans[0], state.plan)[0] + 1
        values[Register.NEXT_KIND] = _place(kinds, state.plan.detections[first.detection].part)
        values[Register.NEXT_PLACE] = _place_number(cell, first)
    return {register: min(int(value), HIGHEST_VALUE) for register, value in values.items()}


def _view_number(cell: Cell) -> int:
    """The place of the chosen view among those of the bin, from 1; 0 where the scanner stands."""
    names = [view.name for view in views_of(cell)]
    return _place(names, view_name(cell)) if names else 0


def _bits(flags: Iterable[bool]) -> int:
    """The first flag as the lowest bit, the next one above it."""
    return sum(flag << place for place, flag in enumerate(flags))


def _place(names: Sequence[str], name: str) -> int:
    """The place in a list, from 1; one more than the last for others."""
    return names.index(name) + 1 if name in names else len(names) + 1


_place_number = lru_cache(maxsize=1)(place_number)
"""A plan and its cell are asked for with every reading; each is equal to itself alone."""
