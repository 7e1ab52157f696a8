"""A part is corrected to the size that the scan shows: what that makes void, and who may do it."""

from dataclasses import replace

import pytest

from workbench.app.core.cell.changes import RedoCell, UndoCell
from workbench.app.core.command import Entry
from workbench.app.core.cycle.correcting import CorrectPart
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.effects import StartJob, UseCell, WriteCell
from workbench.app.core.people import WORKER, Role
from workbench.app.core.state import Phase
from workbench.model.errors import CommandRefused, NotAllowed
from workbench.model.geometry import Mesh
from workbench.model.scan import SearchOverrides, SearchRecord

OVERRIDES = SearchOverrides(detail=0.7)


@pytest.fixture
def approved(samples, cell):
    """A plan that may be sent, for parts that a search has found."""
    search = SearchRecord(3, 5, OVERRIDES, samples.detections(), 0.1)
    return replace(samples.approved(cell), number=9, searches=(search,))


@pytest.fixture
def smaller(cell):
    """The part as the worker reads it, with grasps of its file."""
    peg = cell.parts[0]
    library = replace(peg.library, searches=True)
    mesh = Mesh(0.9 * peg.mesh.points, peg.mesh.triangles)
    return replace(peg, mesh=mesh, library=library, scale=0.9, offset=-0.0005)


def give(state, command, actor="ada"):
    check_allowed(state, command, actor, 1.0)
    return decide(state, Entry(state.number + 1, 1.0, actor, command))


def corrected(state, part):
    state, _ = give(state, CorrectPart("peg"))
    return give(state, JobEnded(state.job.number, part), WORKER)


def test_the_scan_is_measured_by_a_task_with_the_values_of_the_last_search(approved):
    state, (task,) = give(approved, CorrectPart("peg"))
    assert isinstance(task, StartJob) and (task.number, task.name) == (10, "correct")
    assert task.arguments == {
        "part": "peg",
        "scan": approved.scan,
        "seed": 5,
        "overrides": OVERRIDES,
    }
    assert state.job.name == "correct" and str(state.message) == "measuring peg in the scan"
    # Whoever asks for something newer takes back the approval, as with each task.
    assert state.approval is None and state.phase is Phase.PLANNED


def test_what_was_made_with_the_wrong_part_is_void_and_the_scan_is_searched_again(
    approved, smaller
):
    state, effects = corrected(approved, smaller)
    part = state.cell.parts[0]
    assert (part.scale, part.offset) == (0.9, -0.0005)
    # Grasps are those of the session, saved or not.
    assert part.library is approved.cell.parts[0].library
    assert state.scan is approved.scan and state.phase is Phase.SCANNED
    assert (state.detections, state.candidates, state.plan, state.approval) == (None,) * 4
    assert approved.plan.digest[:12] in str(state.stale)
    assert state.job.name == "localize" and state.job.overrides is OVERRIDES
    use, write, search = effects
    assert isinstance(use, UseCell) and use.cell.digest == state.cell.digest
    assert isinstance(write, WriteCell) and write.cell.digest == state.cell.digest
    assert write.actor == "ada" and "peg is 0.9 times as large as its CAD file" in write.remark
    assert (search.name, search.arguments["seed"]) == ("localize", 5)
    assert "-0.50 mm outside" in str(state.message)


def test_nothing_is_written_beside_changes_that_nobody_has_saved(approved, smaller):
    unsaved = replace(approved, saved="another")
    state, effects = corrected(unsaved, smaller)
    assert not any(isinstance(effect, WriteCell) for effect in effects)
    assert state.cell.parts[0].scale == 0.9 and not state.is_saved


def test_a_correction_is_undone_and_redone_like_each_change_of_the_cell(approved, smaller):
    state, _ = corrected(approved, smaller)
    state, _ = give(state, CancelJob())
    after = state.cell.digest
    state, _ = give(state, UndoCell())
    assert state.cell.digest == approved.cell.digest and state.cell.parts[0].scale == 1.0
    assert "undone: peg is 0.9 times" in str(state.message) and state.detections is None
    state, _ = give(state, RedoCell())
    assert state.cell.digest == after


def test_a_correction_that_was_cancelled_changes_nothing(approved, smaller):
    state, _ = give(approved, CorrectPart("peg"))
    number = state.job.number
    state, _ = give(state, CancelJob())
    after, effects = give(state, JobEnded(number, smaller), WORKER)
    assert after.cell is approved.cell and effects == () and after.plan is approved.plan


def test_a_correction_needs_an_engineer_a_known_part_and_parts_found_in_a_scan(approved):
    with pytest.raises(NotAllowed, match="the correction of a part is for engineers"):
        check_allowed(approved, CorrectPart("peg"), "bob", 1.0, role=Role.OPERATOR)
    with pytest.raises(CommandRefused, match="nut"):
        check_allowed(approved, CorrectPart("nut"), "ada", 1.0)
    for state in (
        replace(approved, scan=None),
        replace(approved, detections=()),
        replace(approved, detections=None),
        replace(approved, searches=()),
    ):
        with pytest.raises(CommandRefused, match="find parts in a scan first"):
            check_allowed(state, CorrectPart("peg"), "ada", 1.0)
    for phase in (Phase.IDLE, Phase.SENDING, Phase.DONE, Phase.FAULT):
        with pytest.raises(CommandRefused):
            check_allowed(replace(approved, phase=phase), CorrectPart("peg"), "ada", 1.0)
