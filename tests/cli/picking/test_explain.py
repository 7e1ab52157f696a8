"""`workbench explain`: a verdict for everything, a funnel that adds up, a fix that helps."""

import itertools
import json
from pathlib import Path

POSES = Path(__file__).resolve().parents[2] / "cells" / "public_yumi" / "Poses.txt"


def test_the_funnel_adds_up(line, say):
    said = say("explain", "yumi", "--poses", line.poses, "--json")
    assert said.code == 0
    told = json.loads(said.out)
    candidates, funnel = told["candidates"], told["funnel"]
    assert len(candidates) == funnel[0]["entered"] == 60
    for before, after in itertools.pairwise(funnel):
        assert after["entered"] == before["entered"] - before["refused"]
    last = funnel[-1]
    admitted = sum(one["reason"] == "OK" for one in candidates)
    assert last["entered"] - last["refused"] == admitted > 0
    assert told["ok"] is True


def test_verdicts_are_those_of_plan(line, say, tmp_path):
    explained = json.loads(say("explain", "yumi", "--poses", line.poses, "--json").out)
    planned = json.loads(
        say("plan", "yumi", "--poses", line.poses, "--out", tmp_path / "p.json", "--json").out
    )
    assert explained["candidates"] == planned["candidates"]


def test_words_name_stages_and_the_fix(line, say):
    said = say("explain", "yumi", "--poses", line.poses)
    assert said.code == 0
    for word in ("preselection", "grasp", "approach", "extract", "place", "nearest fix:"):
        assert word in said.out


def test_when_nothing_can_be_taken_the_code_says_so(say, tmp_path):
    path = tmp_path / "Poses.txt"
    path.write_text(POSES.read_text().replace("2 400\n", "2 2400\n").replace("2 420\n", "2 2420\n"))
    said = say("explain", "yumi", "--poses", path)
    assert said.code == 3
    assert "0 can be taken" in said.out


def test_no_poses_are_bad_input(say, tmp_path):
    path = tmp_path / "none.json"
    path.write_text('{"format": "workbench-poses/1", "detections": []}')
    said = say("explain", "yumi", "--poses", path)
    assert said.code == 2
    assert "none.json" in said.problem
