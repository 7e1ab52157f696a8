"""Many cycles in a row: none lost, and the journal whole; the long run is for the benchmarks."""

import json

from wires import Talk

from workbench.cli.serving.simulation import simulated_controller
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find


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


def test_what_is_recalled_is_what_the_worker_would_say_again(say, tmp_path):
    said = say(
        *("bench", "soak", "--recall", "--cycles", 5, "--piles", 1),
        *("--sessions", tmp_path, "--json"),
    )
    form = json.loads(said.out)
    assert said.code == 0 and form["ends"] == {"done": 5} and form["problems"] == []
    first, last = form["every_1000_cycles"][0], form["every_1000_cycles"][-1]
    assert last["cycles"] == 5 and first["journal_mb"] > 0
    assert 0 < last["files"] < 200 and 0 < last["threads"] < 100


def test_modules_in_rapid_stand_where_the_simulated_controller_stands():
    folder = find("robots", "yumi") / "rapid"
    usual = read_cell("yumi").controller
    with simulated_controller("yumi", usual, speed=1000.0, rapid=folder) as there:
        talk = Talk(there.port)
        assert talk.say("hello abb-socket/2") == ("hello", "abb-socket/2 R7 L7")
        talk.link.close()


def test_cycles_that_go_on_beside_each_other_lose_nothing(say, tmp_path):
    said = say(
        *("bench", "soak", "--ahead", "--cycles", 4, "--piles", 4, "--seed", 1, "--speed", 20),
        *("--sessions", tmp_path, "--json"),
    )
    form = json.loads(said.out)
    assert said.code == 0, form["lost"]
    assert "lost" not in form["ends"] and form["ends"]["done"] >= 2
    assert form["problems"] == [] and form["stood_ms"] > 0
