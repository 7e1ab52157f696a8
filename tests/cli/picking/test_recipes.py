"""Plans by a recipe on the command line, and how their cell is found again."""

import json
import shutil

import pytest

from workbench.formats.files.shipped import find

LEFT = '\n[[recipe]]\nnumber = 7\nname = "left and slow"\nstrategy = "left"\nspeed = 0.2\n'


@pytest.fixture
def cell(tmp_path):
    shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")
    with (tmp_path / "yumi" / "cell.toml").open("a", encoding="utf-8") as file:
        file.write(LEFT)
    return tmp_path / "yumi" / "cell.toml"


def test_a_plan_by_a_recipe_is_proven_in_the_cell_by_that_recipe(say, line, cell, tmp_path):
    plan = tmp_path / "plan.json"
    typed = ("plan", cell, "--poses", line.poses, "--out", plan)
    assert "no recipe 8; it has 7 left and slow" in say(*typed, "--recipe", "8").err
    said = say(*typed, "--recipe", "7")
    assert said.code == 0, said.out
    made = json.loads(plan.read_text())
    assert made["strategy"] == "left"
    said = say("verify", plan, "--cell", cell, "--poses", line.poses)
    assert said.code == 0, said.out
    # The shipped cell has no recipe, and so another digest.
    assert say("verify", plan, "--poses", line.poses).code == 3
