"""Many cycles in a row: none lost, and the journal whole; the long run is for the benchmarks."""

import json


def test_some_cycles_in_a_row_lose_nothing(say, tmp_path):
    said = say("bench", "soak", "--cycles", 6, "--piles", 3, "--sessions", tmp_path, "--json")
    form = json.loads(said.out)
    assert said.code == 0, form["lost"]
    assert form["cycles"] == sum(form["ends"].values()) == 6
    assert form["ends"]["done"] >= 4 and "lost" not in form["ends"]
    assert form["problems"] == []
    # Of three piles only three scans are kept.
    assert form["session_mb"] < 3 * 9 + 10
    assert form["memory_mb"]["own"]["last"] < 2 * form["memory_mb"]["own"]["first"]


def test_impossible_numbers_are_refused(say, tmp_path):
    for option, value in (("--cycles", 0), ("--piles", 0), ("--speed", 0)):
        said = say("bench", "soak", "--sessions", tmp_path, option, value)
        assert said.code == 2 and option in said.problem
