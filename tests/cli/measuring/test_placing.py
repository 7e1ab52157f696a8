"""`workbench study placing` as it is typed."""

import json

import pytest

from workbench.cli.main import main


def test_it_prints_what_was_said_and_measured(capsys):
    typed = ["study", "placing", "yumi", "--part", "bracket", "--grips", "20", "--seed", "1"]
    assert main([*typed, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["all"]["grips"] >= 20 and said["grasps"]
    wanted = {"grips", "predicted", "measured", "difference", "slipped", "tipped", "lost", "missed"}
    assert all(wanted <= row.keys() for row in (said["all"], *said["grasps"].values()))
    assert main(typed) == 0
    told = capsys.readouterr().out
    assert "grips, the share within the tolerances of the place" in told and "all" in told


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (["yumi", "--grips", "0"], "--grips"),
        (["yumi", "--wider", "nan"], "--wider"),
        (["yumi", "--force", "-1"], "--force"),
        (["yumi", "--seed", "-1"], "--seed"),
        (["yumi", "--part", "nothing"], "nothing"),
        (["tx2_90", "--grips", "10"], "no arm has a hand with two fingers"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(say, typed, sentence):
    said = say("study", "placing", *typed)
    assert said.code == 2 and sentence in said.problem
