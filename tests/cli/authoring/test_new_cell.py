"""`workbench cell new`: what it chooses where nobody says, and what it leaves to a person."""

import json

import made_arm

from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell


def test_a_cell_with_a_suction_cup_picks_a_part_that_the_cup_can_take(tmp_path, capsys):
    robot, folder = tmp_path / "arm.urdf", tmp_path / "own"
    robot.write_text(made_arm.arm(), encoding="utf-8")
    words = ["cell", "new", "own", "--urdf", str(robot), "--tool", "suction", "--json"]
    assert main([*words, "--out", str(folder)]) == 0
    decisions = " ".join(json.loads(capsys.readouterr().out)["to_decide"])
    assert "there is no plan for a simulated pile" not in decisions
    assert "a simulated one is written, at 127.0.0.1; replace the whole [controller]" in decisions
    cell = read_cell(folder / "cell.toml")
    assert [part.name for part in cell.parts] == ["puck"]
    assert cell.controller.host == "127.0.0.1"


def test_an_empty_name_of_the_robot_file_is_refused_by_what_to_give(capfd):
    assert main(["cell", "new", "own", "--urdf", ""]) == 2
    assert "no robot file is named: give the path of a URDF, xacro" in capfd.readouterr().err
