"""The button that fills a grasp library: what it adds, to which part, and what is said."""

from dataclasses import replace

from workbench.app.core.cell.changes import ChangeCell, UndoCell
from workbench.app.core.people import Role
from workbench.app.filling import fill_process
from workbench.app.filling.fill import Filled
from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.filling import FillControls
from workbench.model.candidate import Reason
from workbench.model.digest import digest_of
from workbench.model.errors import InputError, JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp

PART = "keyed_cylinder"

HAND = Grasp("side", pose_from_rpy((0, 0, 0.02)), 0.04, 0.03)


def found_by_filling(*entries):
    """What a filling comes to."""
    return Filled(
        entries, (0.5,) * len(entries), 8, 6, ((Reason.TOOL_COLLISION.message, 2),), 1, 0, (), 1.0
    )


def test_a_filled_library_is_added_in_one_step_and_undone_in_one(bench, visitor, monkeypatch):
    before = bench.state.cell.part(PART).library
    new = (replace(HAND, name="across"), replace(HAND, name="end"))
    monkeypatch.setattr(fill_process, "fill_apart", lambda *_: found_by_filling(*new))
    controls = FillControls(visitor, Editing(visitor))
    controls._search._work()
    names = [entry.name for entry in bench.state.cell.part(PART).library.entries]
    assert names[-2:] == ["across", "end"] and "6 of 8 parts" in controls._search._line.content
    bench.do(UndoCell(), "Ada", Role.ENGINEER)
    assert digest_of(bench.state.cell.part(PART).library) == digest_of(before)


def test_what_was_found_is_added_to_its_part_also_where_another_is_in_hand_by_now(
    bench, visitor, monkeypatch
):
    cell, other = bench.state.cell, read_part(find("parts", "bolt"))
    bench.do(ChangeCell(replace(cell, parts=(*cell.parts, other)), "another part"), "Ada")
    editing, new = Editing(visitor), (replace(HAND, name="across"),)

    def fill(*_):
        editing.choose(part=other.name)
        return found_by_filling(*new)

    monkeypatch.setattr(fill_process, "fill_apart", fill)
    FillControls(visitor, editing)._search._work()
    library = bench.state.cell.part(PART).library
    assert library.entries[-1].name == "across" and library.searches
    assert digest_of(bench.state.cell.part(other.name).library) == digest_of(other.library)
    assert editing.part.name == other.name


def test_a_filling_that_is_stopped_adds_nothing(bench, visitor, monkeypatch):
    def stopped(cell, part, report, given_up):
        controls._search._cancelled.set()
        assert given_up.is_set()
        raise JobCancelled("it was cancelled")

    before = bench.state.cell.digest
    monkeypatch.setattr(fill_process, "fill_apart", stopped)
    controls = FillControls(visitor, Editing(visitor))
    controls._search._work()
    assert (
        bench.state.cell.digest == before and "nothing was added" in controls._search._line.content
    )


def test_what_cannot_be_filled_is_said_in_a_sentence(visitor, monkeypatch):
    def refused(*_):
        raise InputError("part plate is too large for the bin")

    monkeypatch.setattr(fill_process, "fill_apart", refused)
    controls = FillControls(visitor, Editing(visitor))
    controls._search._work()
    assert "part plate is too large for the bin" in controls._search._line.content
