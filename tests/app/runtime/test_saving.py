"""What becomes of saving the cell: it is told, and what is not saved is not lost."""

import os
import shutil
import threading
from dataclasses import replace
from functools import partial

import pytest
from full_disk import FullDisk
from idle import Idle
from waiting import PATIENCE, wait_until

from workbench.app.core.cell.bins import ChooseBin
from workbench.app.core.cell.changes import CellRead, ChangeCell, SaveCell
from workbench.app.core.cell.part_edits import EditPart
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.state import Phase
from workbench.app.runtime import effect_runner, record_retries
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.watch import CellWatch
from workbench.formats.cells.reading import part_folders, read_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.saves import DRAFT
from workbench.journal.journal import Journal
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy
from workbench.model.part_edits import grasp_of, with_grasp


@pytest.fixture(autouse=True)
def quick(monkeypatch):
    monkeypatch.setattr(record_retries, "RETRY", 0.01)


@pytest.fixture
def writing(bench, cell, monkeypatch):
    """A cell that is being saved, which will fail as soon as the event is set."""
    may_go = threading.Event()

    def fail(*arguments):
        assert may_go.wait(PATIENCE)
        raise FileError("cell.toml", "the disk is gone")

    monkeypatch.setattr(effect_runner, "read_cell", fail)
    monkeypatch.setattr(bench._effects, "_cell_file", "cell.toml")
    bench.do(ChangeCell(replace(cell, name="other"), "renamed"), "ada")
    bench.do(SaveCell("why"), "ada")
    yield may_go
    may_go.set()


def test_what_became_of_saving_is_told_after_a_task_that_began_meanwhile(
    bench, samples, writing, caplog
):
    bench.do(UseScan(samples.scan()), "ada")
    bench.do(FindParts(), "ada")
    wait_until(lambda: bench.live.note == "waiting")
    tried, do = threading.Semaphore(0), bench._effects._do

    def noted(command, actor):
        if isinstance(command, CellRead):
            tried.release()
        return do(command, actor)

    bench._effects._do = noted
    writing.set()
    assert tried.acquire(timeout=PATIENCE)
    bench.do(CancelJob(), "ada")
    wait_until(lambda: "the disk is gone" in bench.state.cell_problem)


def test_what_became_of_saving_is_recorded_when_the_disk_has_room_again(
    bench, writing, monkeypatch
):
    disk = FullDisk(monkeypatch)
    disk.fill()
    writing.set()
    wait_until(lambda: disk.tries > 2)
    assert bench.state.cell_problem == "" and "no space left" in str(bench.live.unrecorded)
    disk.free()
    wait_until(lambda: "the disk is gone" in bench.state.cell_problem)
    wait_until(lambda: bench.live.unrecorded is None)


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A cell file that may be written, beside its part."""
    monkeypatch.chdir(tmp_path)
    for kind, name in (("robots", "yumi"), ("parts", "keyed_cylinder")):
        shutil.copytree(find(kind, name), tmp_path / kind / name)
    return tmp_path / "robots/yumi/cell.toml"


@pytest.fixture
def edited(place, tmp_path):
    """A bench with other grasps than the files have."""
    machines = partial(EffectRunner, cell_file=place, module="tiny_work")
    bench = Bench(read_cell(place), Journal(tmp_path / "session"), effects=machines)
    part = bench.state.cell.parts[0]
    entry = part.library.entries[0]
    wider = with_grasp(entry, replace(grasp_of(entry), opening=0.044))
    bench.do(EditPart(part.name, (entry,), (wider,)), "ada")
    yield bench
    bench.close()


def test_a_cell_that_cannot_be_written_leaves_its_parts_and_drafts(edited, place):
    folder = part_folders(place)["keyed_cylinder"]
    wait_until((folder / DRAFT).exists)
    before = (folder / "grasps.toml").read_bytes()
    # Saving never renames a fixture.
    cell = edited.state.cell
    renamed = tuple(replace(fixture, name=f"{fixture.name}-2") for fixture in cell.fixtures)
    edited.do(ChangeCell(replace(cell, fixtures=renamed), "other names"), "ada")
    edited.do(SaveCell(""), "ada")
    wait_until(lambda: "cannot be written into the file" in edited.state.cell_problem)
    assert (folder / "grasps.toml").read_bytes() == before
    assert (folder / DRAFT).exists()


def test_what_is_saved_names_the_file_and_what_changed_in_it(edited, place):
    cell = edited.state.cell
    moved = replace(cell.bin, T_world_bin=pose_from_rpy((0.02, 0, 0)) * cell.bin.T_world_bin)
    edited.do(ChangeCell(replace(cell, bin=moved), "moved"), "ada")
    edited.do(SaveCell(""), "ada")
    wait_until(lambda: str(edited.state.message).startswith("saved: "))
    told = str(edited.state.message)
    assert "the grasps of keyed_cylinder as version 2" in told
    assert f"{place.parent.name}/{place.name} (the bin was moved by 20.0 mm)" in told


def test_files_that_somebody_has_changed_are_not_written_and_read_then(edited, place):
    mine = edited.state.cell.digest
    theirs = place.read_text().replace("position_mm = [410, 0, -5]", "position_mm = [420, 0, -5]")
    place.write_text(theirs)
    edited.do(SaveCell(""), "ada")
    wait_until(lambda: "were changed since they were read" in edited.state.cell_problem)
    assert place.read_text() == theirs
    wait_until(lambda: not edited.live.is_saving)
    watch = CellWatch(place, edited, every=0.02)
    try:
        wait_until(lambda: edited.state.cell_problem == "")
        assert edited.state.cell.bin.T_world_bin.translation[0] == 0.42
        assert edited.state.before[0].cell.digest == mine, "an undo brings back what was not saved"
    finally:
        watch.close()


def test_an_edit_before_the_watch_began_is_read(place, tmp_path):
    bench = Bench(read_cell(place), Journal(tmp_path / "session"), effects=Idle)
    theirs = place.read_text().replace("position_mm = [410, 0, -5]", "position_mm = [420, 0, -5]")
    place.write_text(theirs)
    watch = CellWatch(place, bench, every=0.02)
    try:
        wait_until(lambda: bench.state.cell.bin.T_world_bin.translation[0] == 0.42)
    finally:
        watch.close()
        bench.close()


def test_a_save_that_failed_half_way_gives_up_nothing(edited, place, monkeypatch):
    def fail(*arguments):
        raise FileError(place, "the disk is full")

    watch = CellWatch(place, edited, every=0.02)
    try:
        mine = edited.state.cell.digest
        with monkeypatch.context() as full:
            full.setattr(effect_runner, "save_cell", fail)
            edited.do(SaveCell(""), "ada")
            wait_until(lambda: "the disk is full" in edited.state.cell_problem)
        looks, look = threading.Semaphore(0), watch._take

        def noted():
            taken = look()
            looks.release()
            return taken

        watch._take = noted
        for _ in range(2):
            assert looks.acquire(timeout=PATIENCE), "the grasps are another file now"
        assert edited.state.cell.digest == mine
        assert "the disk is full" in edited.state.cell_problem
        edited.do(SaveCell(""), "ada")
        wait_until(lambda: edited.state.saved == edited.state.cell.digest)
        assert edited.state.cell_problem == ""
    finally:
        watch.close()


def test_a_broken_cell_in_a_folder_whose_name_is_no_text_is_told(cell, tmp_path):
    folder = tmp_path / os.fsdecode(b"cell\xff")
    folder.mkdir()
    (folder / "cell.toml").write_text("nothing of a cell")
    bench = Bench(cell, Journal(tmp_path / "session"), effects=Idle)
    watch = CellWatch(folder / "cell.toml", bench, every=0.02)
    try:
        state = bench.wait(lambda state: state.cell_problem != "", PATIENCE)
        assert "cell?" in state.cell_problem and state.phase is Phase.IDLE
    finally:
        watch.close()
        bench.close()


def test_the_bin_that_is_chosen_is_moved_and_saved_into_its_own_table(place, tmp_path):
    file = place.with_name("two_bins.toml")
    machines = partial(EffectRunner, cell_file=file, module="tiny_work")
    bench = Bench(read_cell(file), Journal(tmp_path / "session"), effects=machines)
    watch = CellWatch(file, bench, every=0.02)
    try:
        bench.do(ChooseBin("left"), "ada")
        cell = bench.state.cell
        T = pose_from_rpy((0, 0.004, 0)) * cell.bin.T_world_bin
        bench.do(ChangeCell(replace(cell, bin=replace(cell.bin, T_world_bin=T)), "moved"), "ada")
        assert not bench.state.is_saved
        bench.do(SaveCell(""), "ada")
        wait_until(lambda: bench.state.is_saved)
        assert bench.state.cell_problem == "" and bench.state.cell.bin.name == "left"
        right, left = read_cell(file).bins
        assert left.T_world_bin.isApprox(T, 1e-5)
        assert right.T_world_bin.isApprox(cell.bins[0].T_world_bin, 1e-9)
    finally:
        watch.close()
        bench.close()


@pytest.mark.parametrize(
    ("view", "is_named"),
    [
        ("position_mm = [410, 0, 480]\nrpy_deg = [180, 0, 90]", True),
        ("joints_deg = [-90.3, -33.9, 23.4, 81.2, 109.7, 17.7, 36]", False),
    ],
)
def test_saving_says_when_a_calibration_turns_views_into_joints(place, tmp_path, view, is_named):
    path = place.with_name("on_arm.toml")
    joints = "joints_deg = [-90.3, -33.9, 23.4, 81.2, 109.7, 17.7, 36]"
    assert joints in path.read_text()
    path.write_text(path.read_text().replace(joints, view, 1))
    machines = partial(EffectRunner, cell_file=path, module="tiny_work")
    bench = Bench(read_cell(path), Journal(tmp_path / "session"), effects=machines)
    try:
        scanner = bench.state.cell.scanner
        shift = pose_from_rpy((0.002, 0, 0), (0, 0, 0))
        moved = replace(scanner.on_arm, T_flange_scanner=scanner.on_arm.T_flange_scanner * shift)
        cell = replace(bench.state.cell, scanner=replace(scanner, on_arm=moved))
        bench.do(ChangeCell(cell, "calibrated"), "ada")
        bench.do(SaveCell(""), "ada")
        wait_until(lambda: str(bench.state.message).startswith("saved: "))
        assert ("views by joints" in str(bench.state.message)) == is_named
        assert read_cell(path).scanner.on_arm.view.q.tolist() == pytest.approx(
            scanner.on_arm.view.q.tolist(), abs=1e-6
        )
    finally:
        bench.close()
