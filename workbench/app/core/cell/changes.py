"""Changes of the cell and its parts: whether they can be made, and what they do to the state.

What was made for the cell before is gone.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import takewhile
from typing import ClassVar

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse_input
from workbench.app.core.effects import KeepDrafts, UseCell, WriteCell
from workbench.app.core.people import Role
from workbench.app.core.state import (
    EditedCell,
    Phase,
    PlanState,
    ScanState,
    State,
    before_a_scan,
    begin_stage,
    stale_by,
    without_approval,
)
from workbench.app.core.value_checks import check_cell, check_says, check_text
from workbench.formats.cells.differences import difference
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import chosen_as_in
from workbench.model.derived.by_recipe import as_chosen
from workbench.model.derived.by_view import view_name
from workbench.model.digest import LATER, digest_of
from workbench.model.errors import CommandRefused, InputError
from workbench.model.geometry import put
from workbench.model.messages.cells import RecipeText, SlotText
from workbench.model.messages.commands import CommandText, EditText
from workbench.model.messages.message import Message, as_message, plain
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.states import StateText
from workbench.model.part_edits import differ_in_grasps_only
from workbench.model.tools.slots import tool_of_arm, with_mounted

Changed = tuple[State, tuple[UseCell | KeepDrafts, ...]]


MOST_UNDO = 50
"""Changes of the cell that can be undone."""


@dataclass(frozen=True, slots=True, eq=False)
class ChangeCell(Command):
    """Go on with another cell; `says` names the change for people.

    `was` is the digest of the cell that the other one was made from: a cell that somebody has
    changed meanwhile is not replaced.  Empty in older sessions, and where nobody reads first.
    """

    right: ClassVar[Right] = Right(
        CommandText.CHANGE_CELL, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    cell: Cell
    says: Message | str
    was: str = field(default_factory=str, metadata=LATER)

    def check(self, state: State, asked: Asked) -> None:
        check_says("says", self.says)
        check_cell(self.cell)
        check_text("was", self.was)
        if self.was not in ("", state.cell.digest):
            raise CommandRefused(ChangeRefusal.CELL_CHANGED())
        if self.cell.digest == state.cell.digest:
            raise CommandRefused(ChangeRefusal.CELL_AS_IT_WAS())
        with refuse_input():
            for known in (state.cell, state.whole or state.cell):
                chosen_as_in(self.cell, known)

    def apply(self, state: State, entry: Entry) -> Decision:
        # By the bin and view of the state, which are the first ones while the file is changed.
        return changed_cell(state, chosen_as_in(self.cell, state.cell), self.says)


@dataclass(frozen=True, slots=True, eq=False)
class StateTool(Command):
    """State which tool an arm carries, after a change by hand, or one that has failed."""

    right: ClassVar[Right] = Right(CommandText.STATE_TOOL, SAFE, role=Role.ENGINEER)

    arm: str
    tool: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("arm", self.arm)
        check_text("tool", self.tool)
        with refuse_input():
            arm = state.cell.arm(self.arm)
            tool_of_arm(arm, self.tool)
        if arm.tool.name == self.tool and self.arm not in state.tools_unknown:
            raise CommandRefused(SlotText.CARRIED(arm=self.arm, tool=self.tool))

    def apply(self, state: State, entry: Entry) -> Decision:
        says = StateText.TOOL_STATED(person=entry.actor, arm=self.arm, tool=self.tool)
        return with_carried(state, self.arm, self.tool, says)


@dataclass(frozen=True, slots=True, eq=False)
class UndoCell(Command):
    """Go back to the cell before the last change."""

    right: ClassVar[Right] = Right(
        CommandText.UNDO_CELL, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    def check(self, state: State, asked: Asked) -> None:
        if not state.before:
            raise CommandRefused(ChangeRefusal.NO_UNDO())

    def apply(self, state: State, entry: Entry) -> Decision:
        return undone(state)


@dataclass(frozen=True, slots=True, eq=False)
class RedoCell(Command):
    """Take back the last undo."""

    right: ClassVar[Right] = Right(
        CommandText.REDO_CELL, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    def check(self, state: State, asked: Asked) -> None:
        if not state.undone:
            raise CommandRefused(ChangeRefusal.NO_REDO())

    def apply(self, state: State, entry: Entry) -> Decision:
        return redone(state)


@dataclass(frozen=True, slots=True, eq=False)
class SaveCell(Command):
    """Write the changes of the cell and its parts to their files, with a remark of who saves."""

    right: ClassVar[Right] = Right(
        CommandText.SAVE_CELL, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    remark: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("remark", self.remark)
        if state.is_saved:
            raise CommandRefused(ChangeRefusal.SAVED_ALREADY())

    def apply(self, state: State, entry: Entry) -> Decision:
        write = WriteCell(state.cell, self.remark, entry.actor, entry.at, state.saved)
        return replace(state, message=StateText.SAVES_CELL(person=entry.actor)), (write,)


@dataclass(frozen=True, slots=True, eq=False)
class CellRead(Command):
    """The cell file was read: what it holds now, or why that cannot be used.

    `is_saved`: this session had written it before, from the cell with the digest `written`, and
    `says` states for people what was written.  Older sessions did not record it: both are empty.
    """

    right: ClassVar[Right] = Right(CommandText.CELL_READ, SAFE, by_machine=True)

    cell: Cell | None = None
    problem: str = ""
    is_saved: bool = False
    written: str = ""
    says: Message | str = field(default_factory=str, metadata=LATER)

    def __post_init__(self) -> None:
        # It may name a file whose name is no text.
        put(self, problem=self.problem.encode(errors="replace").decode())

    def apply(self, state: State, entry: Entry) -> Decision:
        return cell_read(state, self)


@dataclass(frozen=True, slots=True, eq=False)
class EmptyPallets(Command):
    """What was put down has been taken away."""

    right: ClassVar[Right] = Right(CommandText.EMPTY_PALLETS, SAFE)

    def check(self, state: State, asked: Asked) -> None:
        if not state.placed:
            raise CommandRefused(ChangeRefusal.PALLETS_EMPTY())

    def apply(self, state: State, entry: Entry) -> Decision:
        return replace(state, placed=(), message=StateText.PALLETS_EMPTY()), ()


def change_whole(state: State, change: Callable[[State], Decision]) -> Decision:
    """A change made to the cell as its file has it; the bin and view that are chosen stay so."""
    if state.whole is None:
        return change(state)
    after, effects = change(replace(state, cell=state.whole, whole=None))
    whole = after.cell
    try:
        cell = chosen_as_in(whole, state.cell)
    except InputError:
        # A cell of before that bin; the scan was of it.
        message = after.message
        return begin_stage(after, ScanState, stale=after.stale, message=message), effects
    after = replace(after, cell=cell, whole=whole if whole.digest != cell.digest else None)
    return after, tuple(UseCell(cell) if isinstance(e, UseCell) else e for e in effects)


def changed_cell(state: State, cell: Cell, says: Message | str) -> Changed:
    """The state with another cell, which an undo can take back; `says` names the change."""
    after, effects = with_cell(state, cell, says)
    before = (EditedCell(state.cell, as_message(says)), *state.before)[:MOST_UNDO]
    return replace(after, before=before, undone=()), effects


def _as_carried(known: Cell, read: Cell) -> tuple[Cell, tuple[str, ...]]:
    """A cell as its file has it, with the tools that arms with slots carry.

    What is on an arm is no matter of the file: it was changed by a plan, or stated by a person.
    With the cell come the arms whose tool the file no longer knows.
    """
    lost: list[str] = []
    carried = {arm.name: arm.tool.name for arm in known.arms if arm.tool_slots}
    for arm in read.arms:
        tool = carried.get(arm.name, arm.tool.name)
        if tool in {other.name for other in arm.tools}:
            read = with_mounted(read, arm.name, tool)
        elif tool != arm.tool.name:
            lost.append(arm.name)
    return read, tuple(lost)


def with_carried(state: State, arm: str, tool: str, says: Message) -> Changed:
    """The state in which an arm carries a tool, by any recipe and bin.

    What is on an arm is no matter of undo and redo: cells that these go back to have it there, too.
    """
    unknown = tuple(name for name in state.tools_unknown if name != arm)
    if state.cell.arm(arm).tool.name == tool:
        return replace(state, tools_unknown=unknown, message=says), ()
    after, effects = with_cell(state, with_mounted(state.cell, arm, tool), says)
    whole = None if state.whole is None else with_mounted(state.whole, arm, tool)
    before, undone = (
        tuple(EditedCell(with_mounted(entry.cell, arm, tool), entry.change) for entry in entries)
        for entries in (_having(state.before, arm, tool), _having(state.undone, arm, tool))
    )
    after = replace(after, whole=whole, before=before, undone=undone, tools_unknown=unknown)
    return after, effects


def _having(entries: tuple[EditedCell, ...], arm: str, tool: str) -> tuple[EditedCell, ...]:
    """Those that come before the first cell whose arm cannot carry that tool."""

    def can_carry(entry: EditedCell) -> bool:
        tools = (known for each in entry.cell.arms if each.name == arm for known in each.tools)
        return any(known.name == tool for known in tools)

    return tuple(takewhile(can_carry, entries))


def undone(state: State) -> Changed:
    """The state with the cell before the last change."""
    (cell, change), *before = state.before
    after, effects = with_cell(state, cell, EditText.CELL_UNDONE(change=change))
    undone = (EditedCell(state.cell, change), *state.undone)[:MOST_UNDO]
    return replace(after, before=tuple(before), undone=undone), effects


def redone(state: State) -> Changed:
    """The state with the cell before the last undo."""
    (cell, change), *undone = state.undone
    after, effects = with_cell(state, cell, EditText.CELL_REDONE(change=change))
    before = (EditedCell(state.cell, change), *state.before)[:MOST_UNDO]
    return replace(after, before=before, undone=tuple(undone)), effects


def cell_read(state: State, command: CellRead) -> Changed:
    """The state after the cell file was read; recipe, bin and view stay chosen if it has them."""
    if state.whole is None or command.cell is None:
        return _read(state, command)
    in_force, number = state.cell, state.cell.recipe
    after, effects = _read(replace(state, cell=state.whole, whole=None), command)
    whole = after.cell
    if whole.digest == state.whole.digest:
        cell = replace(in_force, approvers=whole.approvers)
    else:
        try:
            cell = as_chosen(whole, number, in_force.bin.name, view_name(in_force))
        except InputError as error:
            if (in_force.bin.name, view_name(in_force)) != (whole.bin.name, view_name(whole)):
                # The scan was of a bin that nobody takes parts from any more, or of another view.
                after = begin_stage(after, ScanState, stale=after.stale)
            return replace(after, message=RecipeText.UNFIT(problem=error.message)), effects
    after = replace(after, cell=cell, whole=None if cell.digest == whole.digest else whole)
    return after, tuple(UseCell(cell) if isinstance(e, UseCell) else e for e in effects)


def _read(state: State, command: CellRead) -> Changed:
    """The state after the cell file was read, while no recipe is chosen."""
    cell, problem = command.cell, command.problem
    if cell is None:
        message = StateText.CELL_REFUSED(problem=plain(problem))
        return replace(state, cell_problem=problem, message=message), ()
    state = replace(state, cell_problem="", saved=cell.digest)
    cell, lost = _as_carried(state.cell, cell)
    state = replace(state, tools_unknown=tuple(dict.fromkeys((*state.tools_unknown, *lost))))
    if cell.approvers != state.cell.approvers:
        # Words that were given for another number of people do not count.
        kept = replace(state.cell, approvers=cell.approvers)
        state = replace(without_approval(state), cell=kept)
        if cell.digest == kept.digest:
            says = StateText.APPROVERS(count=cell.approvers)
            return replace(state, message=says), (UseCell(kept),)
    if cell.digest == state.cell.digest:
        return replace(state, message=command.says or EditText.CELL_AS_FILE()), ()
    if command.is_saved and command.written not in ("", state.cell.digest):
        message = StateText.SAVE_AGAIN()
        return replace(state, message=message), ()
    if command.is_saved:
        # Files hold fewer digits: what is read differs from what was saved by rounding only.
        return with_cell(state, cell, command.says or EditText.CELL_SAVED())
    return changed_cell(state, cell, EditText.CELL_FILE_CHANGED())


def with_cell(state: State, cell: Cell, message: Message | str) -> Changed:
    """The state with another cell: a scan stays as long as scanner and bin do, all else does not.

    With other grasps the parts found stay where they are.
    """
    # Where the controller is found is not a matter of the cell file that people write; how many
    # people approve is a matter of that file alone.
    cell = replace(cell, controller=state.cell.controller, approvers=state.cell.approvers)
    if differ_in_grasps_only(cell, state.cell):
        return _with_grasps(state, cell, message)
    same_view = digest_of(cell.scanner) == digest_of(state.cell.scanner)
    # What another bin holds may have been changed since the scan.
    same_view &= cell.bin.name == state.cell.bin.name
    same_view &= not state.disturbed
    scan = state.scan if same_view and state.phase is not Phase.DONE else None
    stale = stale_by(state, difference(state.cell, cell))
    state = replace(before_a_scan(state), cell=cell, earlier=None)
    if scan is None:
        return begin_stage(state, ScanState, stale=stale, message=message), (UseCell(cell),)
    after = begin_stage(
        state,
        ScanState,
        phase=Phase.SCANNED,
        scan=scan,
        scene_digest=scan.digest,
        stale=stale,
        message=message,
    )
    return after, (UseCell(cell),)


def _with_grasps(state: State, cell: Cell, message: Message | str) -> Changed:
    """Other grasps: the scan and the parts found stay, candidates and plan do not."""
    changed = tuple(p for p in cell.parts if p.digest != state.cell.part(p.name).digest)
    effects = (UseCell(cell), KeepDrafts(changed)) if changed else (UseCell(cell),)
    stale = stale_by(state, difference(state.cell, cell))
    after = replace(before_a_scan(state), cell=cell)
    if state.phase is Phase.DONE:
        return begin_stage(after, ScanState, stale=stale, message=message), effects
    if state.detections is None:
        return replace(after, message=message), effects
    phase = Phase.LOCALIZED if state.detections else Phase.SCANNED
    return begin_stage(after, PlanState, phase=phase, stale=stale, message=message), effects
