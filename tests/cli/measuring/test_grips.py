"""`workbench study grips` as it is typed."""

import json

import pytest

from workbench.cli.main import main


def test_it_prints_what_was_said_and_what_stayed(capsys):
    typed = ["study", "grips", "yumi", "--part", "bracket+bolt", "--grips", "6", "--seed", "1"]
    assert main([*typed, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert 3 <= said["all"]["grips"] <= 6
    wanted = {"grips", "stayed", "agreement", "said_to_hold", "false_holds", "false_slips"}
    assert all(wanted <= row.keys() for row in (said["all"], said["near"]))
    assert main(typed) == 0
    told = capsys.readouterr().out
    assert "said to hold" in told and "of 6 left out" in told


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (["yumi", "--grips", "0"], "--grips"),
        (["yumi", "--force", "nan"], "--force"),
        (["yumi", "--acceleration", "-1"], "--acceleration"),
        (["yumi", "--seed", "-1"], "--seed"),
        (["yumi", "--part", "bolt+nothing"], "nothing"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(say, typed, sentence):
    said = say("study", "grips", *typed)
    assert said.code == 2 and sentence in said.problem
