"""The short benchmarks: set beside what was kept, and failing only when one cannot be run."""

import json

import pytest

from workbench.cli.measuring import short_benchmarks as shorts


@pytest.fixture
def one(monkeypatch):
    """Only the quickest of them, and quicker still."""
    monkeypatch.setattr(
        shorts,
        "SHORT",
        {"pick": shorts.Short(("bench", "pick", "--scenes", "1"), shorts.SHORT["pick"].figures)},
    )


def test_figures_are_kept_and_compared(say, one, tmp_path):
    kept = tmp_path / "figures.json"
    said = say("bench", "short", "--against", kept, "--keep")
    assert said.code == 0, said.err
    figures = json.loads(kept.read_text())["figures"]["pick"]
    assert figures["route, median ms"] > 0
    said = say("bench", "short", "--against", kept, "--json")
    told = json.loads(said.out)
    assert told["ok"] and told["before"]["figures"]["pick"] == figures
    assert set(told["figures"]["pick"]) == set(figures)


@pytest.mark.parametrize("content", ["{}", '{"figures": 1, "machine": ""}', "[]"])
def test_a_file_of_something_else_is_refused_before_anything_runs(say, tmp_path, content):
    (tmp_path / "other.json").write_text(content)
    said = say("bench", "short", "--against", tmp_path / "other.json")
    assert said.code == 2 and "other.json" in said.problem


def test_one_that_cannot_be_run_fails(say, monkeypatch, tmp_path):
    broken = shorts.Short(("bench", "pick", "--scenes", "0"), lambda said: {})
    monkeypatch.setattr(shorts, "SHORT", {"pick": broken})
    said = say("bench", "short", "--against", tmp_path / "none.json", "--keep")
    assert said.code == 1 and "failed: pick: ended with 2" in said.out
    assert not (tmp_path / "none.json").exists()
