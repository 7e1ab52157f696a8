"""`workbench bench both-arms` as it is typed."""

import json

import pytest

from workbench.cli.main import main

TYPED = ["bench", "both-arms", "--pairs", "2", "--seed", "3"]


def test_it_prints_a_row_for_each_planner_and_kind_of_ends_as_json(capsys):
    assert main([*TYPED, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["cell"], said["joints"]) == ("yumi", 14)
    assert [(row["planner"], row["ends"], row["pairs"]) for row in said["rows"][::2]] == [
        ("rrtconnect", "all", 2),
        ("OMPL RRT-Connect", "all", 2),
    ]
    assert len(said["rows"]) == 4


def test_it_tells_people_what_was_solved(capsys):
    assert main(TYPED) == 0
    told = capsys.readouterr().out
    assert "14 joints as one" in told and "not straight ahead" in told


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (["--pairs", "0"], "--pairs"),
        (["--seconds", "nan"], "--seconds"),
        (["--seed", "-1"], "--seed"),
        (["--cell", "tx2_90"], "one arm"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(say, typed, sentence):
    said = say("bench", "both-arms", *typed)
    assert said.code == 2 and sentence in said.problem
