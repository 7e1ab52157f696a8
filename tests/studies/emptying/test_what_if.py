"""Which single change gains most, and a study that goes on after it was stopped."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.emptying.changes import apply_change
from workbench.app.emptying.empty import fallen
from workbench.app.emptying.what_if import rank_changes, tasks_with_changes
from workbench.cli.measuring.emptying import kinds_of
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import FileError, InputError
from workbench.model.messages.changes import ChangeText
from workbench.model.messages.message import plain
from workbench.model.prediction import EmptiedPile, LeftPart, PileTask
from workbench.studies.cases import run_cases
from workbench.studies.emptying import pile_results
from workbench.studies.emptying.pile_results import emptied_all
from workbench.studies.emptying.piles import empty_pile

PILE = PileTask("yumi", "", 2, 3, settles=False)


def made(task: PileTask) -> EmptiedPile:
    """A pile as if it had been emptied: what is taken depends on the task alone."""
    taken = (len(str(task.change or "")) + task.seed) % 3
    left = tuple(
        LeftPart(f"part-{k}", "tool collision", plain("why"), "") for k in range(2 - taken)
    )
    return EmptiedPile(task, 2, taken, (0, 0, 0), 0, 0, taken, 2, float(taken), left, (0.1,),
                 (("propose", 0.1),), 0.0)  # fmt: skip


def nothing(done: float, note: str) -> None:
    pass


def test_changes_are_ranked_by_what_they_gain_on_the_same_piles():
    cell = read_cell("yumi")
    tasks = tasks_with_changes(cell, [PILE, replace(PILE, seed=4)], kinds_of("lifts+margins"))
    changes = list(dict.fromkeys(task.change for task in tasks))
    assert changes[0] is None and ChangeText.NEAR_MARGIN() in changes and len(changes) >= 5
    assert [task.seed for task in tasks] == [3, 4] * len(changes)
    rows = rank_changes([made(task) for task in tasks], scan_seconds=1.0, approval_seconds=0.0)
    assert [row["parts_gained"] for row in rows] == sorted(
        (row["parts_gained"] for row in rows), reverse=True
    )
    assert {row["change"] for row in rows} == {str(change) for change in changes[1:]}
    assert all(row["said"]["id"].startswith("change.") for row in rows)
    before = sum(made(task).taken for task in tasks[:2])
    for row in rows:
        assert row["taken_share_before"] == before / 4
        assert sum(row["taken_by_scene"]) == before + row["parts_gained"]


def test_what_changes_nothing_is_not_tried():
    cell = read_cell("yumi")
    tasks = tasks_with_changes(cell, [PILE], kinds_of("order"))
    assert ChangeText.ORDER(order="travel") not in {task.change for task in tasks}


def test_a_word_that_is_no_kind_of_change_is_refused():
    with pytest.raises(InputError, match="'colours' is no kind of change"):
        kinds_of("lifts+colours")


def test_the_pile_lies_in_a_bin_that_is_moved_as_in_the_one_that_is_not():
    task = replace(PILE, change=ChangeText.BIN_TURNED(by=float(np.deg2rad(90))))
    cell = read_cell("yumi")
    other = apply_change(cell, task.change)
    for a, b in zip(fallen(cell, cell, PILE), fallen(cell, other, task), strict=True):
        at = cell.bin.T_world_bin.actInv(a.T_world_part)
        assert at.isApprox(other.bin.T_world_bin.actInv(b.T_world_part), 1e-9)


def test_a_study_that_was_stopped_goes_on_and_finds_the_same(tmp_path, monkeypatch):
    tilted = ChangeText.TILTED(by=float(np.deg2rad(15)))
    tasks = [replace(PILE, seed=seed, change=tilted) for seed in range(4)]
    done: list[int] = []

    def broken(task: PileTask) -> EmptiedPile:
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(task.seed)
        return made(task)

    def run(function, folder):
        monkeypatch.setattr(pile_results, "empty_pile", function)
        return emptied_all(tasks, folder=folder, workers=1, scheduler=None, report=nothing)

    with pytest.raises(KeyboardInterrupt):
        run(broken, tmp_path / "kept")
    rest: list[int] = []

    def again(task: PileTask) -> EmptiedPile:
        rest.append(task.seed)
        return made(task)

    found = run(again, tmp_path / "kept")
    assert done == [0, 1] and rest == [2, 3]
    assert found == run(again, None) and len(rest) == 6
    assert run(again, tmp_path / "kept") == found and len(rest) == 6


def test_a_file_that_is_no_pile_is_refused_in_one_sentence(tmp_path, monkeypatch):
    monkeypatch.setattr(pile_results, "empty_pile", made)

    def run():
        return emptied_all([PILE], folder=tmp_path, workers=1, scheduler=None, report=nothing)

    run()
    (file,) = tmp_path.glob("*.json")
    for content in ("{}", "[1]", "not json", file.read_text().replace('"taken"', '"token"')):
        file.write_text(content)
        with pytest.raises(FileError, match=str(file)):
            run()


def test_what_is_kept_is_the_pile_as_it_was_emptied(tmp_path):
    first = emptied_all([PILE], folder=tmp_path, workers=1, scheduler=None, report=nothing)
    again = emptied_all([PILE], folder=tmp_path, workers=1, scheduler=None, report=nothing)
    assert again == first
    (other,) = run_cases(empty_pile, [PILE])
    assert replace(other, planning=(), stages=(), finding=0.0) == replace(
        first[0], planning=(), stages=(), finding=0.0
    )


def test_a_change_of_the_cell_empties_the_same_pile():
    scene = empty_pile(replace(PILE, change=ChangeText.UP_ALONE()))
    assert scene.parts == 2 and scene.taken + len(scene.left) == 2


def test_piles_that_another_state_of_the_program_has_emptied_are_emptied_again(
    tmp_path, monkeypatch
):
    """The version says nothing: it is the same from one release to the next."""
    emptied_now: list[int] = []

    def noted(task: PileTask) -> EmptiedPile:
        emptied_now.append(task.seed)
        return made(task)

    monkeypatch.setattr(pile_results, "empty_pile", noted)
    for program in ("one", "one", "other", "one"):
        pile_results._program.cache_clear()
        monkeypatch.setattr(pile_results, "files_digest", lambda program=program: program)
        emptied_all([PILE], folder=tmp_path, workers=1, scheduler=None, report=nothing)
    pile_results._program.cache_clear()
    assert len(emptied_now) == 2
