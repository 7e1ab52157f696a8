"""`workbench bench motion` as it is typed."""

import json

import pytest
from motion_stand_in import make_motion_problems, write_set

from workbench.cli.main import main


@pytest.fixture
def folder(tmp_path):
    make_motion_problems(tmp_path / "problems")
    return tmp_path / "problems"


def test_it_prints_a_row_a_set_as_json(capsys, folder):
    typed = ["bench", "motion", str(folder), "--robot", "planar", "--against", "ompl", "--json"]
    assert main(typed) == 0
    said = json.loads(capsys.readouterr().out)
    wanted = {"set", "problems", "invalid", "solved", "median_ms", "mean_ms", "p95_ms"}
    for rows in (said["sets"], said["against"]["sets"]):
        assert [row["set"] for row in rows] == ["free", "in_the_way"]
        assert all(wanted <= row.keys() for row in rows)
        assert [row["solved"] for row in rows] == [1, 1]
    assert said["all"]["problems"] == 4 and said["all"]["invalid"] == 2


def test_it_tells_people_what_was_solved_and_what_is_invalid(capsys, folder):
    assert main(["bench", "motion", str(folder)]) == 0
    told = capsys.readouterr().out
    assert "in_the_way beyond: invalid, its goal is beyond the limits of a joint" in told
    assert "1 of 1" in told and "rrtconnect" in told


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (["--robot", "scara"], "no problems for robot 'scara'"),
        (["--planner", "dijkstra"], "dijkstra"),
        (["--iterations", "0"], "--iterations"),
        (["--seconds", "nan"], "--seconds"),
        (["--margin", "-1"], "--margin"),
        (["--seed", "-1"], "--seed"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(say, folder, typed, sentence):
    said = say("bench", "motion", folder, *typed)
    assert said.code == 2 and sentence in said.problem


def test_a_bad_folder_or_file_is_refused_in_one_sentence(say, folder, tmp_path):
    said = say("bench", "motion", tmp_path / "nowhere")
    assert said.code == 2 and "no such folder" in said.problem
    write_set(folder / "free.json", "planar", "free", [{"name": "one"}])
    said = say("bench", "motion", folder)
    assert said.code == 2
    assert "free.json: key problems[1].start: is missing" in said.problem
