"""What a change of the cell does to the state: what was made for the cell before is gone."""

from dataclasses import replace

from workbench.app.core.commands import CellRead, EditPart, JobEnded
from workbench.app.core.effects import KeepDrafts, UseCell
from workbench.app.core.part_rules import edited_part
from workbench.app.core.release import without_approval
from workbench.app.core.state import Phase, PlanState, ScanState, State, begun, stale_by
from workbench.formats.cells.differences import difference
from workbench.model.cell import Arm, Cell, Tool
from workbench.model.digest import digest_of
from workbench.model.part import Part
from workbench.model.part_edits import differ_in_grasps_only, with_part

Changed = tuple[State, tuple[UseCell | KeepDrafts, ...]]

MOST_UNDO = 50
"""Changes of the cell that can be undone."""


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

    def changed(one: Arm) -> Arm:
        return replace(one, tool=tool, tools=(*(one.tools or (one.tool,)), tool))

    return replace(cell, arms=tuple(changed(one) if one.name == arm else one for one in cell.arms))


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
        message = f"the cell file cannot be used, the cell stays as it was: {problem}"
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
    state = replace(state, cell=cell)
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
    after = replace(state, cell=cell)
    if state.phase is Phase.DONE:
        return begun(after, ScanState, stale=stale, message=message), effects
    if state.detections is None:
        return replace(after, message=message), effects
    phase = Phase.LOCALIZED if state.detections else Phase.SCANNED
    return begun(after, PlanState, phase=phase, stale=stale, message=message), effects
