"""The study of parts that do not lie there."""

import json
from collections import Counter

import pytest

from workbench.cli.main import main
from workbench.studies.seeing.absent import (
    SITUATIONS,
    AbsentSearch,
    AbsentTask,
    absent_rows,
    absent_tasks,
)


def test_parts_and_scanners_take_turns():
    tasks = absent_tasks("yumi", ("bolt", "puck"), ("fine", "rough"), scans=8, seed=5)
    assert Counter(task.situation for task in tasks) == dict.fromkeys(SITUATIONS, 8)
    wrong = [task for task in tasks if task.situation == "wrong part"]
    assert set(Counter((t.lying, t.searched, t.build) for t in wrong).values()) == {2}
    assert all(task.lying != task.searched for task in wrong)
    assert [task.seed for task in wrong] == list(range(5, 13))


def test_reports_above_a_half_are_false_alarms():
    task = AbsentTask("yumi", "rubbish", "", "bolt", "fine", 0)
    searches = [AbsentSearch(task, (0.9, 0.3, 0.6), 1.0), AbsentSearch(task, (0.5,), 3.0)]
    row = absent_rows(searches)[SITUATIONS.index("rubbish")]
    assert (row["scans"], row["reports"]) == (2, 4)
    assert (row["false_alarms"], row["scans_with_false_alarms"]) == (2, 1)
    assert row["processor_seconds"] == {"median": 2.0, "worst": 3.0}


@pytest.mark.parametrize("typed", [["--parts", "bolt"], ["--parts", "bolt", "bolt"]])
def test_one_part_is_not_enough(typed, capsys):
    assert main(["study", "absent", *typed]) == 2
    assert "two parts" in capsys.readouterr().err


@pytest.mark.extensive
def test_the_command_searches_each_situation(capsys):
    typed = ["--scans", "1", "--parts", "bolt", "puck", "--noise", "fine", "--seed", "3", "--json"]
    assert main(["study", "absent", *typed]) == 0
    told = json.loads(capsys.readouterr().out)
    assert [row["scans"] for row in told["rows"]] == [1, 1, 1]
    assert told["rows"][SITUATIONS.index("empty bin")]["reports"] == 0
    assert all(each["processor_seconds"] > 0 for each in told["searches"])
