"""`workbench study emptying` as it is typed."""

import json

import pytest

from workbench.cli.main import main


def test_it_prints_what_it_found_as_json(capsys, tmp_path):
    plot = tmp_path / "emptied.html"
    typed = ["study", "emptying", "yumi", "--parts", "2", "--scenes", "1", "--seed", "3"]
    assert main([*typed, "--no-settle", "--json", "--plot", str(plot)]) == 0
    found = json.loads(capsys.readouterr().out)
    wanted = {"taken_share", "parts_per_hour", "failed_picks", "touches", "planning_ms", "scenes"}
    assert wanted <= found.keys()
    assert set(found["planning_ms"]) == {"median", "p95"}
    (scene,) = found["scenes"]
    assert {"seed", "parts", "taken", "cycles", "motion_seconds", "left"} <= scene.keys()
    assert scene["taken"] + len(scene["left"]) == scene["parts"] == 2
    assert plot.stat().st_size > 0


def test_it_tells_people_what_was_taken_and_what_stayed(capsys):
    typed = ["study", "emptying", "--parts", "2", "--scenes", "1", "--seed", "3"]
    assert main(typed) == 0
    assert "of 2 parts taken" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("typed", "sentence"),
    [
        (["--parts", "0"], "--parts"),
        (["--scenes", "0"], "--scenes"),
        (["--seed", "-1"], "--seed"),
        (["--scan-seconds", "-1"], "--scan-seconds"),
        (["--part", "sprocket"], "sprocket"),
        (["--strategy", "middle"], "strategy 'middle' is not one of"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(capsys, typed, sentence):
    assert main(["study", "emptying", "yumi", *typed]) == 2
    told = capsys.readouterr().err
    assert sentence in told and "Traceback" not in told
