"""Poses that another program puts into a folder are taken; broken ones are told of."""

import json
import os
import time
from dataclasses import replace

import numpy as np
import pytest
from idle import Idle
from waiting import PATIENCE

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.jobs import CancelJob
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.decide import check_allowed
from workbench.app.core.people import POSES_FOLDER
from workbench.app.core.state import State
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.watch_poses import PosesWatch
from workbench.formats.plans.pose_files import write_poses
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, PosesFolder


@pytest.fixture
def bench(cell, tmp_path):
    (tmp_path / "poses").mkdir()
    watched = replace(cell, poses_folder=PosesFolder(str(tmp_path / "poses"), ""))
    bench = Bench(watched, Journal(tmp_path / "session"), effects=Idle)
    yield bench
    bench.close()


@pytest.fixture
def watch(bench):
    watch = PosesWatch(bench, every=0.02, still=0.1)
    yield watch
    watch.close()


@pytest.fixture
def told(bench):
    """A watch that looks when it is told to; what it saw before is complete."""
    watch = PosesWatch(bench, every=PATIENCE, still=0.0)
    yield watch
    watch.close()


def reaches(bench, condition):
    state = bench.wait(condition, PATIENCE)
    assert condition(state), state.message
    return state


def halcon(*positions_mm) -> str:
    numbers = [v for x, y, z in positions_mm for v in (1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z)]
    return "\n".join([str(len(numbers)), *(f"2 {value}" for value in numbers)])


def test_a_file_of_halcon_is_taken(bench, watch, tmp_path):
    (tmp_path / "poses" / "Poses.txt").write_text(halcon((100, 20, 30), (50, 0, 10)))
    state = reaches(bench, lambda state: len(state.detections or ()) == 2)
    assert state.detections[0].part == "peg"
    assert np.allclose(state.detections[0].T_world_part.translation, (0.1, 0.02, 0.03))
    assert state.phase == "localized"
    (remark,) = state.remarks
    assert (remark.by, str(remark.says)) == (POSES_FOLDER, "2 poses taken from Poses.txt")
    assert str(state.message) == "2 poses taken from Poses.txt, by poses folder"


def test_our_json_and_a_file_written_again_are_taken(bench, watch, tmp_path):
    path = tmp_path / "poses" / "found.json"
    write_poses(path, (Detection("peg", pose_from_rpy((0.1, 0, 0)), 0.7),))
    assert reaches(bench, lambda s: s.detections is not None).detections[0].score == 0.7
    write_poses(path, (Detection("peg", pose_from_rpy((0.2, 0, 0)), 0.8),))
    reaches(bench, lambda s: s.detections[0].score == 0.8)


def test_a_file_is_read_when_it_is_complete(bench, told, tmp_path):
    text = halcon(*[(k, k, k) for k in range(6)])
    with (tmp_path / "poses" / "Poses.txt").open("w") as file:
        for start in range(0, len(text), 60):
            file.write(text[start : start + 60])
            file.flush()
            told._look()
            assert bench.state.detections is None
    told._look()
    assert len(bench.state.detections) == 6
    assert all("cannot be used" not in message for message in said(bench))


def said(bench) -> list[str]:
    """All messages of the session."""
    rows = [json.loads(row.body) for row in bench._journal.entries()]
    return [row["after"]["message"] for row in rows if "after" in row]


def test_a_renamed_file_counts_and_one_from_before_does_not(bench, tmp_path):
    (tmp_path / "poses" / "old.txt").write_text(halcon((1, 1, 1)))
    watch = PosesWatch(bench, every=0.02, still=0.1)
    try:
        (tmp_path / "poses" / "new.part").write_text(halcon((2, 2, 2), (3, 3, 3)))
        (tmp_path / "poses" / "new.part").rename(tmp_path / "poses" / "new.txt")
        assert len(reaches(bench, lambda s: s.detections is not None).detections) == 2
    finally:
        watch.close()


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"no poses at all", "neither JSON nor a HALCON tuple"),
        (b"", "is empty"),
        (b"12\n2 1.0", "promises 12 numbers"),
        (b"\xff\xfe\x00", "neither JSON nor a HALCON tuple"),
        (b'{"format": "workbench-poses/1", "detections": [{"part": "nut"}]}', "T_world_part"),
        (halcon((99999, 0, 0)).encode(), "m"),
    ],
)
def test_a_broken_file_is_told_of_and_the_next_one_taken(bench, watch, tmp_path, content, problem):
    # Renamed into place: half of it would be told of otherwise.
    (tmp_path / "bad.txt").write_bytes(content)
    (tmp_path / "bad.txt").rename(tmp_path / "poses" / "bad.txt")
    state = reaches(bench, lambda s: "cannot be used" in str(s.message))
    assert problem in str(state.message) and "bad.txt" in str(state.message)
    assert state.detections is None
    (tmp_path / "poses" / "good.txt").write_text(halcon((10, 10, 10)))
    reaches(bench, lambda s: s.detections is not None)


def test_poses_of_a_part_that_is_not_known_are_told_of(bench, watch, tmp_path):
    write_poses(tmp_path / "poses" / "nuts.json", (Detection("nut", pose_from_rpy((0, 0, 0))),))
    state = reaches(bench, lambda s: "cannot be used" in str(s.message))
    assert "has no part 'nut'" in str(state.message)


def test_a_cell_without_parts_says_that_the_part_is_not_known(bench, watch, tmp_path):
    bench.do(ChangeCell(replace(bench.state.cell, parts=()), "no parts"), "ada")
    (tmp_path / "poses" / "Poses.txt").write_text(halcon((1, 1, 1)))
    reaches(bench, lambda s: "poses from outside cannot be used: Poses.txt" in str(s.message))


@pytest.mark.parametrize("name", [b"\xff.txt", b"a\nb.txt", b"x" * 240 + b".txt"])
@pytest.mark.parametrize("content", [halcon((1, 1, 1)), "no poses"])
def test_a_file_with_a_name_that_cannot_be_recorded_is_read(bench, watch, tmp_path, name, content):
    # Renamed into place: a busy machine may pause between making a file and filling it.
    (tmp_path / "written").write_text(content)
    (tmp_path / "written").rename(tmp_path / "poses" / os.fsdecode(name))
    reaches(bench, lambda s: s.message)
    assert (bench.state.detections is None) == (content == "no poses")


def test_the_newest_of_several_files_is_taken_last(bench, told, tmp_path):
    bench.do(TakeScan(), "ada")
    for number, name in enumerate(("b", "c", "a", "d"), start=1):
        path = tmp_path / f"{name}.txt"
        path.write_text(halcon((number, 0, 0)))
        os.utime(path, (number, number))
    for path in tmp_path.glob("?.txt"):
        path.rename(tmp_path / "poses" / path.name)
    for _ in range(3):
        told._look()
    assert bench.state.remarks == (), "a task is under way"
    bench.do(CancelJob(), "ada")
    told._look()
    assert [str(one.says) for one in bench.state.remarks] == [
        f"1 pose taken from {name}.txt" for name in ("b", "c", "a", "d")
    ]


def test_a_file_waits_until_a_task_ends_however_long_that_takes(bench, told, tmp_path, monkeypatch):
    bench.do(TakeScan(), "ada")
    (tmp_path / "poses" / "Poses.txt").write_text(halcon((1, 2, 3)))
    clock = time.monotonic()
    for hours in (0, 1, 2):
        monkeypatch.setattr(time, "monotonic", lambda now=clock + 3600 * hours: now)
        told._look()
    monkeypatch.undo()
    bench.do(CancelJob(), "ada")
    told._look()
    assert bench.state.detections is not None


def test_a_folder_that_comes_later_is_watched(bench, told, tmp_path):
    later = PosesFolder(str(tmp_path / "later"), "peg")
    bench.do(ChangeCell(replace(bench.state.cell, poses_folder=later), "another folder"), "ada")
    told._look()
    (tmp_path / "later").mkdir()
    (tmp_path / "later" / "Poses.txt").write_text(halcon((5, 5, 5)))
    for _ in range(2):
        told._look()
    assert bench.state.detections is not None


def test_the_folder_may_give_poses_and_nothing_else(cell, samples):
    state = State(cell)
    check_allowed(state, UseDetections(samples.detections()), POSES_FOLDER, 0.0)
    with pytest.raises(CommandRefused, match="name of a machine"):
        check_allowed(state, TakeScan(), POSES_FOLDER, 0.0)
    with pytest.raises(CommandRefused, match="name of a machine"):
        check_allowed(state, UseDetections(samples.detections()), "worker", 0.0)


def test_files_that_are_gone_are_forgotten_and_none_is_taken_twice(bench, tmp_path):
    folder = tmp_path / "poses"
    # It looks when it is told to here.
    watch = PosesWatch(bench, every=PATIENCE, still=0.0)
    try:
        (folder / "kept.txt").write_text(halcon((1, 2, 3)))
        for number in range(3):
            (folder / f"{number}.txt").write_text(halcon((number, 2, 3)))
            (folder / f"{number}.json").write_text("not yet")
            watch._look()
            (folder / f"{number}.json").unlink()
            watch._look()
            (folder / f"{number}.txt").unlink()
        number = bench.state.number
        # A share that is not to be reached for a while.
        folder.rename(tmp_path / "away")
        watch._look()
        (tmp_path / "away").rename(folder)
        for _ in range(3):
            watch._look()
        assert set(watch._done) == {folder / "kept.txt"} and watch._seen == {}
        assert bench.state.number == number, "kept.txt was taken once"
    finally:
        watch.close()
