"""Changes of grasps: what they leave standing, who is refused, how files and drafts follow."""

import shutil
import time
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from waiting import wait_until

from workbench.app.core.cell.changes import ChangeCell, RedoCell, SaveCell, UndoCell
from workbench.app.core.cell.part_edits import DropDraft, EditPart
from workbench.app.core.command import Entry
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.effects import KeepDrafts, RemoveDraft, UseCell
from workbench.app.core.state import Phase, State
from workbench.app.records.forms import large_arrays, restore_value
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import part_folders, read_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.saves import DRAFT, draft_of, versions
from workbench.model.digest import canonical, digest_of
from workbench.model.errors import CommandRefused
from workbench.model.part import GraspPair, GraspPattern
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.model.symmetry import Symmetry


def after(state: State, command, actor="ada", at=1.0):
    check_allowed(state, command, actor, at)
    return decide(state, Entry(state.number + 1, at, actor, command))


@pytest.fixture
def localized(cell, samples) -> State:
    scan = samples.scan()
    return State(
        cell,
        Phase.LOCALIZED,
        scan=scan,
        detections=samples.detections(),
        scene_digest=scan.digest,
        saved=cell.digest,
    )


def opened(entry, opening: float):
    """The entry with another opening [m]."""
    return with_grasp(entry, replace(grasp_of(entry), opening=opening))


def edit_of(state: State, opening: float) -> EditPart:
    part = state.cell.parts[0]
    first = part.library.entries[0]
    return EditPart(part.name, (first,), (opened(first, opening),), says="wider")


def test_with_other_grasps_the_parts_found_stay_and_plans_do_not(localized):
    state, effects = after(localized, edit_of(localized, 0.044))
    assert grasp_of(state.cell.parts[0].library.entries[0]).opening == pytest.approx(0.044)
    assert (state.phase, state.message) == (Phase.LOCALIZED, "wider")
    assert state.detections is localized.detections
    assert state.scene_digest == localized.scene_digest
    assert [type(effect) for effect in effects] == [UseCell, KeepDrafts]
    undone, _ = after(state, UndoCell())
    assert undone.cell.digest == localized.cell.digest
    assert undone.detections is localized.detections
    again, _ = after(undone, RedoCell())
    assert again.cell.digest == state.cell.digest


def test_who_edits_what_was_changed_meanwhile_is_told_and_loses_nothing(localized):
    first, late = edit_of(localized, 0.044), edit_of(localized, 0.042)
    state, _ = after(localized, first)
    with pytest.raises(CommandRefused, match="changed by somebody else in the meantime"):
        check_allowed(state, late, "bob", 2.0)
    part = state.cell.parts[0]
    own = with_grasp(late.now[0], replace(grasp_of(late.now[0]), name="bobs"))
    merged, _ = after(state, EditPart(part.name, (), (own,)), "bob")
    names = [entry.name for entry in merged.cell.parts[0].library.entries]
    assert names == [*(entry.name for entry in part.library.entries), "bobs"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"opening": float("nan")}, "opening_mm"),
        ({"opening": -0.01}, "opening_mm"),
        ({"grip": 0.9}, "grip_mm"),
        ({"name": ""}, "name"),
        ({"name": "x" * 99}, "name"),
        ({"name": "a\nb"}, "name"),
        ({"name": "a@b"}, "name"),
        ({"approach": np.zeros(3)}, "approach"),
        ({"approach_length": 50.0}, "approach_length_mm"),
        ({"tilt": 9.0}, "tilt_deg"),
        ({"priority": 10**9}, "priority"),
    ],
)
def test_what_no_file_may_hold_is_refused(localized, change, says):
    part = localized.cell.parts[0]
    grasp = replace(grasp_of(part.library.entries[0]), **({"name": "new"} | change))
    with pytest.raises(CommandRefused, match=says):
        check_allowed(localized, EditPart(part.name, (), (grasp,)), "ada", 1.0)


def test_names_stay_unique_and_unknown_parts_are_refused(localized):
    part = localized.cell.parts[0]
    first = part.library.entries[0]
    with pytest.raises(CommandRefused, match="used twice"):
        check_allowed(localized, EditPart(part.name, (), (first,)), "ada", 1.0)
    with pytest.raises(CommandRefused, match="has no part 'nut'"):
        check_allowed(localized, EditPart("nut", (), (first,)), "ada", 1.0)
    with pytest.raises(CommandRefused, match="has no part 'nut'"):
        check_allowed(localized, DropDraft("nut"), "ada", 1.0)
    with pytest.raises(CommandRefused, match="nothing of part"):
        check_allowed(localized, EditPart(part.name), "ada", 1.0)
    with pytest.raises(CommandRefused, match="turns are needed"):
        check_allowed(localized, EditPart(part.name, symmetry=Symmetry(fold=-1)), "ada", 1.0)


@pytest.mark.parametrize("axis", [(0, 0, 2), (0, 0, 0), (np.nan, 0, 1)])
def test_an_axis_of_symmetry_that_is_no_direction_is_refused(localized, axis):
    symmetry = Symmetry(np.array(axis, dtype=float))
    with pytest.raises(CommandRefused, match="a unit axis"):
        check_allowed(localized, EditPart("peg", symmetry=symmetry), "ada", 1.0)


@pytest.mark.parametrize(("copies", "fold"), [(100_000, 1), (100, 360)])
def test_more_grasps_than_can_be_tried_are_refused(localized, copies, fold):
    entry = replace(grasp_of(localized.cell.parts[0].library.entries[0]), name="new")
    many = tuple(np.linspace(0.0, 0.1, copies))
    pattern = GraspPattern(entry, np.array([0.0, 0.0, 1.0]), offsets=many)
    symmetry = Symmetry(fold=fold)
    with pytest.raises(CommandRefused, match="10,000 are allowed"):
        check_allowed(localized, EditPart("peg", (), (pattern,), symmetry=symmetry), "ada", 1.0)


def test_pairs_follow_names_and_vanish_with_their_grasps(localized):
    part = localized.cell.parts[0]
    first = part.library.entries[0]
    other = replace(grasp_of(first), name="other")
    state, _ = after(localized, EditPart(part.name, (), (other,)))
    pair = GraspPair(first.name, "other", is_ordered=True)
    state, _ = after(state, EditPart(part.name, pairs=(pair,)))
    other = state.cell.parts[0].library.entries[-1]
    state, _ = after(state, EditPart(part.name, (other,), (replace(other, name="else"),)))
    (pair,) = state.cell.parts[0].library.pairs
    assert (pair.first, pair.second, pair.is_ordered) == (first.name, "else", True)
    other = state.cell.parts[0].library.entries[-1]
    state, _ = after(state, EditPart(part.name, (other,), ()))
    assert state.cell.parts[0].library.pairs == ()


def test_an_edit_comes_back_from_the_journal(localized):
    edit = edit_of(localized, 0.044)
    files = large_arrays(edit)
    back = restore_value(EditPart, canonical(edit), files.__getitem__)
    assert digest_of(back) == digest_of(edit)
    one, other = (after(localized, command)[0] for command in (edit, back))
    assert one.cell.digest == other.cell.digest


def test_another_symmetry_takes_the_parts_found_away(localized):
    part = localized.cell.parts[0]
    state, _ = after(localized, EditPart(part.name, symmetry=Symmetry(fold=6)))
    assert (state.phase, state.detections) == (Phase.SCANNED, None)
    assert len(state.cell.parts[0].grasps) > len(state.cell.parts[0].library.grasps)


def test_dropping_a_draft_is_carried_out_by_the_machines(localized):
    _, effects = after(localized, DropDraft(localized.cell.parts[0].name))
    assert [type(effect) for effect in effects] == [RemoveDraft]


def opening_in(library):
    return None if library is None else grasp_of(library.entries[0]).opening


def test_a_bench_keeps_drafts_and_saves_versions(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for kind, name in (("robots", "yumi"), ("parts", "keyed_cylinder")):
        shutil.copytree(find(kind, name), tmp_path / kind / name)
    path = tmp_path / "robots/yumi/cell.toml"
    folder = part_folders(path)["keyed_cylinder"]
    assert folder == tmp_path / "parts/keyed_cylinder"
    cell = read_cell(path)
    machines = partial(EffectRunner, cell_file=path, module="tiny_work")
    journal = new_session(tmp_path / "sessions", cell, time.time())
    bench = Bench(cell, journal, effects=machines)
    try:
        bench.do(edit_of(bench.state, 0.044), "ada")
        # Written while nobody waits for it.
        wait_until(lambda: opening_in(draft_of(folder)) == pytest.approx(0.044))
        moved = replace(bench.state.cell.bin, wall=0.003)
        with pytest.raises(CommandRefused):
            bench.do(ChangeCell(replace(bench.state.cell, bin=moved), "nothing"), "ada")
        bench.do(SaveCell("wider for the new fingers"), "ada")
        wait_until(lambda: bench.state.saved == bench.state.cell.digest)
        assert bench.state.cell_problem == ""
        assert str(bench.state.message) == "saved: the grasps of keyed_cylinder as version 2"
    finally:
        bench.close()
    assert not (folder / DRAFT).exists()
    text = (folder / "grasps.toml").read_text()
    assert "opening_mm = 44" in text
    assert "# 360 / 5 = 72 degrees apart" in text
    before, now = versions(folder)
    assert (before.remark, now.by, now.remark) == (
        "as it was before",
        "ada",
        "wider for the new fingers",
    )
    assert grasp_of(before.library.entries[0]).opening == pytest.approx(0.04)
    assert digest_of(now.library) == digest_of(read_cell(path).parts[0].library)


def test_pairs_that_were_changed_meanwhile_are_not_replaced(localized):
    part = localized.cell.parts[0]
    name, was = part.library.entries[0].name, part.library.pairs
    mine = EditPart(part.name, pairs=(GraspPair(name, name),), pairs_was=was)
    theirs = EditPart(part.name, pairs=(GraspPair(name, name, True),), pairs_was=was)
    state, _ = after(localized, theirs)
    with pytest.raises(CommandRefused, match=r"pairs .* were changed by somebody else"):
        after(state, mine)
    assert after(localized, mine)[0].cell.parts[0].library.pairs[0].first == name
