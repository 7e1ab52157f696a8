"""A camera inside a wall at its view: one sentence by `cell check`, and no path there."""

import shutil

import pytest

from workbench.cli.exits import NO_PLAN
from workbench.cli.main import main
from workbench.formats.files.shipped import find

WALL = """
[[fixture]]
name = "wall"
position_mm = [600, 0, 1018]

[[fixture.solid]]
name = "wall"
shape = "box"
size_mm = [20, 20, 200]
"""


@pytest.fixture
def walled(tmp_path):
    folder = shutil.copytree(find("robots", "tx2_90"), tmp_path / "tx2_90")
    path = folder / "on_arm.toml"
    text = path.read_text(encoding="utf-8")
    part = str(find("parts", "puck"))
    path.write_text(text.replace('"puck"', f'"{part}"') + WALL, encoding="utf-8")
    return path


def test_a_camera_inside_a_wall_is_named_with_both_bodies(walled, capsys):
    assert main(["cell", "check", str(walled)]) == NO_PLAN
    said = capsys.readouterr()
    (problem,) = [line for line in (said.out + said.err).splitlines() if "problem" in line]
    assert "at view bin right camera and wall_wall overlap by " in problem


def test_no_path_leads_to_a_view_inside_a_wall(walled, capsys, tmp_path):
    out = tmp_path / "plan.json"
    assert main(["plan", str(walled), "--view", "bin", "--out", str(out)]) == NO_PLAN
    said = " ".join(capsys.readouterr().out.split())
    assert "no plan: no path: right camera and wall_wall, penetration" in said
    assert not out.exists()
