"""Changes of the cell and its parts: whether they can be made, and what they do to the state.

What was made for the cell before is gone.
"""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import PurePosixPath
from typing import get_args

from workbench.app.core.commands import (
    AddTool,
    CellRead,
    EditPart,
    ImportPart,
    JobEnded,
    TryEmptying,
)
from workbench.app.core.effects import KeepDrafts, UseCell
from workbench.app.core.outcomes import before_a_scan
from workbench.app.core.release import without_approval
from workbench.app.core.state import Phase, PlanState, ScanState, State, begun, stale_by
from workbench.app.core.value_checks import (
    MOST_PARTS,
    MOST_PILES,
    SEED_LIMIT,
    check_among,
    check_integer,
    check_number,
    check_text,
)
from workbench.formats.cells.differences import difference
from workbench.formats.cells.drawn_tools import check_drawn
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import MB
from workbench.formats.meshes.cad_files import KINDS, LARGEST_CAD
from workbench.formats.parts.grasp_files import as_written
from workbench.formats.parts.new_part import check_name
from workbench.model.cell import Arm, Cell, Tool
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.message import plain
from workbench.model.messages.states import StateText
from workbench.model.part import Entry, GraspLibrary, GraspPattern, Part
from workbench.model.part_edits import differ_in_grasps_only, edited, with_part
from workbench.model.prediction import CHANGE_KINDS, Seen
from workbench.model.symmetry import Symmetry

Changed = tuple[State, tuple[UseCell | KeepDrafts, ...]]

MOST_UNDO = 50
"""Changes of the cell that can be undone."""

DENSITIES = (10.0, 25_000.0)
"""[kg/m3] From foam to more than gold."""

MOST_KINDS = 20
"""Parts of one cell: each is searched for in every scan."""

MOST_TOOLS = 20
"""That one arm can carry."""

MOST_GRASPS = 10_000
"""Of one part, with patterns and symmetry written out."""

LONGEST_SOLID = 300
"""Letters of the name of a solid in a CAD file."""


def changed_cell(state: State, cell: Cell, says: str) -> Changed:
    """The state with another cell, which an undo can take back; `says` tells what was changed."""
    after, effects = _with_cell(state, cell, says)
    return replace(after, before=(state.cell, *state.before)[:MOST_UNDO], undone=()), effects


def edited_cell(state: State, edit: EditPart) -> Changed:
    """The state with other grasps or another symmetry of a part."""
    part = edited_part(state.cell.part(edit.part), edit)
    cell = with_part(state.cell, part.name, library=part.library, symmetry=part.symmetry)
    return changed_cell(state, cell, edit.says or f"the grasps of {part.name} are changed")


def with_made(state: State, ended: JobEnded, made: Part | Tool) -> Changed:
    """The state with a part or a tool that a task has made, as long as it was still wanted."""
    job = state.job
    wanted = "import" if isinstance(made, Part) else "tool"
    if job is None or job.number != ended.number or job.name != wanted:
        return state, ()
    state = replace(state, job=None)
    if isinstance(made, Part):
        cell = replace(state.cell, parts=(*state.cell.parts, made))
        size = made.facts["mm"]
        says = f"the part {made.name} is in the cell, {size} mm; it has no grasps yet"
    else:
        cell = carrying(state.cell, job.arm, made)
        says = f"the {job.arm} arm carries the tool {made.name}; look at its TCP"
    return changed_cell(state, cell, says)


def carrying(cell: Cell, arm: str, tool: Tool) -> Cell:
    """The cell with one more tool for an arm, which carries it now."""

    def changed(changed_arm: Arm) -> Arm:
        return replace(
            changed_arm, tool=tool, tools=(*(changed_arm.tools or (changed_arm.tool,)), tool)
        )

    return replace(
        cell,
        arms=tuple(
            changed(arm_plan) if arm_plan.name == arm else arm_plan for arm_plan in cell.arms
        ),
    )


def undone(state: State) -> Changed:
    """The state with the cell before the last change."""
    cell, *before = state.before
    after, effects = _with_cell(state, cell, "the last change of the cell is undone")
    undone = (state.cell, *state.undone)[:MOST_UNDO]
    return replace(after, before=tuple(before), undone=undone), effects


def redone(state: State) -> Changed:
    """The state with the cell before the last undo."""
    cell, *undone = state.undone
    after, effects = _with_cell(state, cell, "the change of the cell is made again")
    before = (state.cell, *state.before)[:MOST_UNDO]
    return replace(after, before=before, undone=tuple(undone)), effects


def cell_read(state: State, command: CellRead) -> Changed:
    """The state after the cell file was read."""
    cell, problem = command.cell, command.problem
    if cell is None:
        message = StateText.CELL_REFUSED(problem=plain(problem))
        return replace(state, cell_problem=problem, message=message), ()
    state = replace(state, cell_problem="", saved=cell.digest)
    if cell.approvers != state.cell.approvers:
        # Words that were given for another number of people do not count.
        kept = replace(state.cell, approvers=cell.approvers)
        state = replace(without_approval(state), cell=kept)
        if cell.digest == kept.digest:
            says = f"{cell.approvers} different people have to approve a plan now"
            return replace(state, message=says), (UseCell(kept),)
    if cell.digest == state.cell.digest:
        return replace(state, message=command.says or "the cell is as in its file"), ()
    if command.is_saved and command.written not in ("", state.cell.digest):
        message = "the cell is saved, without what was changed meanwhile: save it again"
        return replace(state, message=message), ()
    if command.is_saved:
        # Files hold fewer digits: what is read differs from what was saved by rounding only.
        return _with_cell(state, cell, command.says or "the cell is saved")
    return changed_cell(state, cell, "the cell file was changed, and is read again")


def _with_cell(state: State, cell: Cell, message: str) -> Changed:
    """Another cell: a scan stays as long as the scanner does, what was made of it does not.

    With other grasps the parts found stay where they are.
    """
    # Where the controller is found is not a matter of the cell file that people write; how many
    # people approve is a matter of that file alone.
    cell = replace(cell, controller=state.cell.controller, approvers=state.cell.approvers)
    if differ_in_grasps_only(cell, state.cell):
        return _with_grasps(state, cell, message)
    same_view = digest_of(cell.scanner) == digest_of(state.cell.scanner)
    scan = state.scan if same_view and state.phase is not Phase.DONE else None
    stale = stale_by(state, difference(state.cell, cell))
    state = replace(before_a_scan(state), cell=cell)
    if scan is None:
        return begun(state, ScanState, stale=stale, message=message), (UseCell(cell),)
    after = begun(
        state,
        ScanState,
        phase=Phase.SCANNED,
        scan=scan,
        scene_digest=scan.digest,
        stale=stale,
        message=message,
    )
    return after, (UseCell(cell),)


def _with_grasps(state: State, cell: Cell, message: str) -> Changed:
    """Other grasps: the scan and the parts found stay, candidates and plan do not."""
    changed = tuple(p for p in cell.parts if p.digest != state.cell.part(p.name).digest)
    effects = (UseCell(cell), KeepDrafts(changed)) if changed else (UseCell(cell),)
    stale = stale_by(state, difference(state.cell, cell))
    after = replace(before_a_scan(state), cell=cell)
    if state.phase is Phase.DONE:
        return begun(after, ScanState, stale=stale, message=message), effects
    if state.detections is None:
        return replace(after, message=message), effects
    phase = Phase.LOCALIZED if state.detections else Phase.SCANNED
    return begun(after, PlanState, phase=phase, stale=stale, message=message), effects


def part_of(cell: Cell, name: str) -> Part:
    """The part of that name.

    Raises:
        CommandRefused: there is none.
    """
    try:
        return cell.part(name)
    except InputError as error:
        raise CommandRefused(str(error)) from error


def check_edit(cell: Cell, edit: EditPart) -> None:
    """What is edited is there, and what comes of it can be kept in files.

    Raises:
        CommandRefused: it is not, or cannot.
    """
    part = part_of(cell, edit.part)
    try:
        after = edited_part(part, edit)
    except InputError as error:
        raise CommandRefused(str(error)) from error
    if after.digest == part.digest:
        raise CommandRefused(f"nothing of part {part.name} was changed")


def check_emptying(cell: Cell, command: TryEmptying) -> None:
    """Piles of parts that the cell picks, no more of them than can be emptied in one task.

    Raises:
        CommandRefused: other parts, too many or too few, or changes of a kind that there is not.
    """
    known = tuple(part.name for part in cell.parts)
    for kind in command.kinds:
        check_among("part", kind, known)
    if len(set(command.kinds)) < len(command.kinds):
        raise CommandRefused(f"each part is named once, not {', '.join(command.kinds)}")
    check_integer("parts", command.count, 1, MOST_PARTS)
    check_integer("piles", command.piles, 1, MOST_PILES)
    check_integer("seed", command.seed, 0, SEED_LIMIT - MOST_PILES)
    check_among("seen", command.seen, get_args(Seen))
    for kind in command.changes:
        check_among("kind of change", kind, CHANGE_KINDS)


def check_import(cell: Cell, command: ImportPart) -> None:
    """A part of this name can be made of such a file.

    Raises:
        CommandRefused: it cannot.
    """
    check_text("file", command.file)
    try:
        check_name(command.name)
    except InputError as error:
        raise CommandRefused(str(error)) from error
    if command.name in (part.name for part in cell.parts):
        raise CommandRefused(f"the cell has a part {command.name} already; choose another name")
    if len(cell.parts) >= MOST_KINDS:
        raise CommandRefused(f"a cell has up to {MOST_KINDS} parts")
    kind = PurePosixPath(command.file).suffix.lower()
    if kind not in KINDS:
        raise CommandRefused(f"{command.file} is no CAD file: one of {', '.join(KINDS)} is")
    if not 0 < command.content.size <= LARGEST_CAD:
        raise CommandRefused(
            f"{command.file} has {command.content.size:,} bytes; up to {LARGEST_CAD / MB:g} MB "
            "are taken"
        )
    if len(command.solid) > LONGEST_SOLID:
        raise CommandRefused(f"the name of a solid has up to {LONGEST_SOLID} letters")
    check_among("unit", command.unit, ("", *UNITS))
    check_number("density", command.density, *DENSITIES, "kg/m3")


def check_tool(cell: Cell, command: AddTool) -> None:
    """A tool can be meant so, and the arm that shall carry it has room for it.

    Raises:
        CommandRefused: it cannot, or has none.
    """
    name = command.drawn.name
    check_among("arm", command.arm, tuple(arm.name for arm in cell.arms))
    try:
        check_drawn(command.drawn)
    except InputError as error:
        raise CommandRefused(str(error)) from error
    known = {tool.name for arm in cell.arms for tool in (arm.tool, *arm.tools)}
    if name in known:
        raise CommandRefused(f"the cell has a tool {name} already; choose another name")
    if len(cell.arm(command.arm).tools) >= MOST_TOOLS:
        raise CommandRefused(f"an arm has up to {MOST_TOOLS} tools")


def edited_part(part: Part, edit: EditPart) -> Part:
    """The part after an edit, its numbers as files hold them.

    Raises:
        InputError: what was edited is not there any more, or cannot be kept in a file.
    """
    symmetry = edit.symmetry or part.symmetry
    symmetry.check()
    # Counted before anything is written out.
    _check_count(edit.now, symmetry)
    library = part.library
    if edit.was or edit.now:
        library = edited(library, edit.was, as_written(GraspLibrary(edit.now)).entries)
    if edit.pairs is not None:
        library = as_written(replace(library, pairs=edit.pairs))
    _check_count(library.entries, symmetry)
    return replace(part, library=library, symmetry=symmetry)


def _check_count(entries: Sequence[Entry], symmetry: Symmetry) -> None:
    count = sum(entry.count if isinstance(entry, GraspPattern) else 1 for entry in entries)
    count *= 1 + len(symmetry.turns)
    if count > MOST_GRASPS:
        raise InputError(
            f"with patterns and symmetry written out there would be {count:,} grasps; "
            f"{MOST_GRASPS:,} are allowed"
        )
