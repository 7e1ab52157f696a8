"""The study of CAD files of a wrong size."""

import json

import pytest

from workbench.cli.main import main
from workbench.model.scan import ScaleCheck
from workbench.studies.localization import Found, Scene, Task
from workbench.studies.seeing.wrong_cad import wrong_cad_rows, wrong_cad_tasks


def test_each_error_is_searched_by_each_scanner():
    tasks = wrong_cad_tasks(
        "yumi", ("bolt",), ("fine", "rough"), scales=(1.0, 1.05), offsets=(0.001,), scenes=2, seed=7
    )
    assert [task.seed for task in tasks] == list(range(7, 19))
    errors = {(task.cad_scale, task.cad_offset, task.build) for task in tasks}
    assert len(errors) == 6 and (1.0, 0.001, "rough") in errors


def test_a_row_counts_what_is_told():
    task = Task("yumi", "bolt", "fine", 8, 0, cad_scale=1.05)
    right, wrong = (
        Found(distance, 0.0, True, is_right, probability=0.9)
        for distance, is_right in ((0.001, True), (0.003, False))
    )
    scenes = [
        Scene(task, (right, wrong), (0.9, 0.8), (True, False), 1.0,
              scales=(ScaleCheck("bolt", ratio, 0.002, 4),))
        for ratio in (0.953, 0.97)
    ]  # fmt: skip
    (row,) = wrong_cad_rows(scenes)
    assert (row["right"], row["found"], row["missed"], row["clear"]) == (2, 4, 2, 4)
    assert (row["reported"], row["off"], row["piles"]) == (1, 2, 2)
    assert row["stated"] == pytest.approx(0.9)
    assert row["calibration_error"] == pytest.approx(0.4)


@pytest.mark.extensive
def test_the_command_reports_a_wrong_scale(capsys):
    typed = ["--parts", "bolt", "--noise", "fine", "--scales", "1.05", "--offsets-mm", "0.5"]
    assert main(["study", "wrong-cad", *typed, "--seed", "3", "--json"]) == 0
    scaled, offset = json.loads(capsys.readouterr().out)["rows"]
    assert (scaled["scale"], offset["offset"]) == (1.05, 0.0005)
    assert scaled["off"] == 1 and offset["found"] >= 6
