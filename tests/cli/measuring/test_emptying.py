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
        (["--what-if", "colours"], "'colours' is no kind of change"),
        (["--resume", "/dev/null/kept"], "/dev/null/kept"),
        (["--strategy", "middle"], "strategy 'middle' is not one of"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_sentence(capsys, typed, sentence):
    assert main(["study", "emptying", "yumi", *typed]) == 2
    told = capsys.readouterr().err
    assert sentence in told and "Traceback" not in told


def test_it_ranks_single_changes_and_goes_on_with_what_is_kept(capsys, tmp_path):
    typed = ["study", "emptying", "yumi", "--parts", "1", "--scenes", "1", "--seed", "3"]
    typed += ["--no-settle", "--what-if", "lifts", "--resume", str(tmp_path / "kept")]
    assert main([*typed, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {row["change"] for row in found["what_if"]} == {
        "straight up alone",
        "all lifts, the first that is clear",
    }
    assert all(row["taken_share_before"] == found["taken_share"] for row in found["what_if"])
    assert len(list((tmp_path / "kept").glob("*.json"))) == 3
    assert main([*typed, "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == found, "nothing is measured anew"
    assert main(typed) == 0
    assert "straight up alone" in capsys.readouterr().out
