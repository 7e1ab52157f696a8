"""`workbench part` and `workbench grasps`, from a CAD file to grasps in a library."""

import json
from pathlib import Path

import pytest
import trimesh

from workbench.formats.parts.reading import read_part


@pytest.fixture
def box(tmp_path, monkeypatch):
    """A closed box in a file, in a working directory of its own."""
    monkeypatch.chdir(tmp_path)
    trimesh.creation.box((60, 30, 20)).export(tmp_path / "box.stl")
    return tmp_path / "box.stl"


def test_a_box_becomes_a_part_with_grasps(say, box):
    said = say("part", "import", box, "--name", "box", "--accept-symmetry", "--json")
    assert said.code == 0, said.err
    told = json.loads(said.out)
    assert told["unit_assumed"] and told["size_mm"] == [60, 30, 20]
    assert told["mass_g"] == pytest.approx(36 * 1.2)
    part = read_part("box")
    assert part.symmetry.fold == 2
    said = say("grasps", "suggest", "box", "--most", 4, "--add", "--json")
    assert said.code == 0, said.err
    names = [one["name"] for one in json.loads(said.out)["grasps"]]
    assert [one.name for one in read_part("box").library.grasps] == names and len(names) == 4
    listed = json.loads(say("part", "list", "--json").out)["parts"]
    assert {one["name"]: one["grasps"] for one in listed}["box"] == 4
    again = say("part", "import", box, "--name", "box")
    assert again.code == 2 and "is there already" in again.problem


@pytest.mark.parametrize(
    "file, name",
    [("Gear Motor (v2).stl", "Gear_Motor__v2"), ("_é.stl", "part"), ("x" * 90 + ".stl", "x" * 60)],
)
def test_a_part_is_named_after_its_file_where_no_name_is_given(say, box, file, name):
    box.rename(file)
    said = say("part", "import", file, "--json")
    assert said.code == 0, said.err
    assert read_part(name).name == name
    assert say("part", "import", file).code == 2


@pytest.mark.extensive
def test_import_and_check_say_one_figure_of_pieces_that_are_too_large(say, box):
    slot = (((0, 0, 5), (60, 40, 10)), ((-25, 0, 20), (10, 40, 20)), ((25, 0, 20), (10, 40, 20)))
    bodies = []
    for middle, sides in slot:
        bodies.append(trimesh.creation.box(sides))
        bodies[-1].apply_translation(middle)
    trimesh.util.concatenate(bodies).export("slot.stl")
    made = say("part", "import", "slot.stl", "--name", "slot", "--repair", "--json")
    assert made.code == 0, made.err
    checked = json.loads(say("part", "check", "slot", "--json").out)
    assert json.loads(made.out)["excess_mm"] == checked["excess_mm"]


def test_bad_input_is_one_line(say, box):
    assert "letters, digits" in say("part", "import", box, "--name", "../box").problem
    assert "there is no such file" in say("part", "import", "gone.stl", "--name", "gone").problem
    assert "--mass-g" in say("part", "import", box, "--name", "b", "--mass-g", -1).problem
    assert "no such name under parts/" in say("part", "check", "nothing").problem
    assert "--most" in say("grasps", "suggest", "puck", "--most", 0).problem
    assert "no arm 'middle'" in say("grasps", "suggest", "puck", "--arm", "middle").problem


def test_check_says_what_lies_flat_and_what_the_scanner_sees(say, box):
    trimesh.creation.annulus(3.2, 6.25, 1.6).export("washer.stl")
    made = say("part", "import", "washer.stl", "--name", "washer", "--unit", "mm")
    assert made.code == 0, made.err
    assert say("grasps", "suggest", "washer", "--cell", "yumi", "--most", 4, "--add").code == 0
    said = say("part", "check", "washer", "--cell", "yumi", "--json")
    told = json.loads(said.out)
    assert said.code == 3 and told["coverage"]["lying_share"] < 0.5
    assert told["scanner"]["across"] < 45
    problems = " ".join(told["problems"])
    assert "of the ways to lie on the floor" in problems and "pixels across" in problems


def test_a_part_without_grasps_passes_only_where_plans_search_grips(say, box):
    assert say("part", "import", box, "--name", "bare").code == 0
    assert say("part", "check", "bare").code == 0
    file = Path("parts/bare/grasps.toml")
    file.write_text(file.read_text().replace("search = true", ""))
    said = say("part", "check", "bare", "--json")
    told = json.loads(said.out)
    assert said.code == 3 and not told["ok"]
    assert told["problems"] == ["it has no grasps: workbench grasps suggest bare --add"]
    assert told["watertight"] and told["coverage"]["share"] == 0.0


@pytest.mark.extensive
def test_import_and_check_say_in_a_sentence_how_exact_the_bodies_are(say, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    trimesh.creation.annulus(14, 16.5, 60).export("tube.stl")
    made = say("part", "import", "tube.stl", "--name", "tube", "--unit", "mm")
    assert made.code == 0, made.err
    sentence = next(line for line in made.out.splitlines() if "bodies used for distances" in line)
    figure = float(sentence.split("at most ")[1].split(" mm")[0])
    assert 0 < figure <= 0.55
    checked = say("part", "check", "tube")
    told = f"The bodies used for distances are at most {figure:.2f} mm larger than the mesh."
    assert told in checked.out
    assert len(read_part("tube").pieces) <= 16
