"""`workbench cell`: what a cell is made of, and whether it can work."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from workbench.formats.files.shipped import find


@pytest.fixture
def changed(tmp_path: Path):
    """A copy of the YuMi's cell file with a text replaced."""

    def made(old: str, new: str) -> Path:
        folder = tmp_path / "cell"
        shutil.copytree(find("robots", "yumi"), folder)
        path = folder / "cell.toml"
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))
        return path

    return made


@pytest.mark.parametrize("cell", ["yumi", "tx2_90"])
def test_nothing_speaks_against_the_shipped_cells(say, cell):
    said = say("cell", "check", cell)
    assert said.code == 0, said.out
    assert "nothing speaks against this cell" in said.out


def test_the_form_tells_reach_by_arm(say):
    told = json.loads(say("cell", "check", "yumi", "--json").out)
    assert told["ok"] is True
    assert [arm["arm"] for arm in told["arms"]] == ["right", "left"]
    for arm in told["arms"]:
        assert arm["clear_at_home"] is True
        assert sum(arm["bin"].values()) == 300
        assert arm["bin"]["clear"] > 150


@pytest.mark.extensive
@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("position_mm = [410, 0, -5]", "position_mm = [2410, 0, -5]", "no pose in the bin"),
        (
            "position_mm = [330, -330, 110]",
            "position_mm = [330, -2330, 110]",
            "right arm: reaches none of its places",
        ),
        (
            "position_mm = [330, -330, 110]\nrpy_deg = [180, 0, 0]",
            "part_position_mm = [330, -330, 105]",
            "right arm: at place 1 of parts keyed_cylinder is nearer than 5 mm to tray_right_stand",
        ),
        (
            "position_mm = [330, -330, 110]\nrpy_deg = [180, 0, 0]",
            "part_position_mm = [-330, -2330, 130]",
            "right arm: at place 1 of parts keyed_cylinder is out of reach by each of 15 grasps",
        ),
        (
            "home_deg = [0, -130, 30, 0, 40, 0, -135]",
            "home_deg = [90, -100, 0, 0, 0, 0, -135]",
            "right arm: at home",
        ),
    ],
    ids=["bin far away", "places far away", "part in a tray", "part far away", "home in collision"],
)
def test_what_speaks_against_a_cell_is_told(say, changed, old, new, expected):
    said = say("cell", "check", changed(old, new))
    assert said.code == 3, said.out
    assert expected in said.out


def test_home_is_shown_as_a_controller_shows_it_that_counts_in_its_own_way(say, tmp_path):
    folder = shutil.copytree(find("robots", "tx2_90"), tmp_path / "cell")
    path = folder / "pick_server.toml"
    offsets = "[[arm]]\naxis_offsets = [0, -90, 0, 0, 0, 0]\n"
    text = path.read_text().replace("[[arm]]\n", offsets)
    assert "home_deg = [0, 0, 90," in text
    path.write_text(text.replace("home_deg = [0, 0, 90,", "home_deg = [0, -90, 90,"))
    said = say("cell", "check", path)
    assert "axes before axis_coupling and axis_offsets" in said.out
    assert "home as the controller shows it: 0, -90, 90, 0, 90, 0" in said.out
    assert "as the controller" not in say("cell", "check", "tx2_90").out.partition("counts them")[2]


def test_a_cell_that_sends_poses_says_that_no_motion_is_proven(say, tmp_path):
    folder = shutil.copytree(find("robots", "tx2_90"), tmp_path / "cell")
    path = folder / "pick_server.toml"
    path.write_text(path.read_text().replace("longest =", 'poses = "staubli"\nlongest ='))
    said = say("cell", "check", path)
    assert "vision only" in said.out and "nothing of the robot's motion is proven" in said.out


def test_show_names_all_that_is_there(say):
    said = say("cell", "show", "tx2_90")
    assert said.code == 0
    for expected in ("suction_cup", "puck", "400, 600, 350 mm", "abb-socket", "policy margin"):
        assert expected in said.out


def test_a_cell_that_is_not_there_is_bad_input(say):
    said = say("cell", "check", "nowhere")
    assert said.code == 2
    assert "nowhere" in said.problem


def test_the_loads_of_the_tools_are_told_with_what_is_estimated(say):
    said = say("cell", "check", "yumi", "--json")
    told = json.loads(said.out)
    for one in told["loads"]:
        assert (one["tool"], one["mass_g"]) == ("smart_gripper", 230.0)
        assert one["centre_of_gravity_mm"] == [8.2, 11.7, 52.0]
    assert told["notes"] == []
    said = say("cell", "check", "tx2_90")
    assert "load of suction_cup: 0.385 kg, centre of gravity 0, 0, 92 mm" in said.out
    assert "inertia_kgm2 of suction_cup estimated from its bodies" in said.out
    assert "the robot link abb-socket sends no load; set it on the controller" in said.out


def test_a_mass_that_is_missing_is_asked_for_once(say, changed):
    lines = "mass_g = 230\ncentre_of_gravity_mm = [8.2, 11.7, 52]\n"
    lines += "inertia_kgm2 = [0.00021, 0.00024, 0.00009]\n"
    said = say("cell", "check", changed(lines, ""))
    assert said.code == 0, said.out
    assert said.out.count("note: mass_g of smart_gripper is missing") == 1
    assert "load of smart_gripper" not in said.out


@pytest.mark.parametrize(
    ("new", "why"),
    [
        ("mass_g = 0", "mass_g: more than 0 is expected"),
        ("mass_g = nan", "mass_g"),
        ("mass_g = 230\ninertia_kgm2 = [-0.1, 0.1, 0.1]", "inertia_kgm2"),
    ],
)
def test_a_load_that_cannot_be_is_bad_input(say, changed, new, why):
    path = changed("mass_g = 230", new)
    text = path.read_text()
    if new.count("inertia"):
        path.write_text(text.replace("inertia_kgm2 = [0.00021, 0.00024, 0.00009]\n", ""))
    said = say("cell", "check", path)
    assert said.code == 2, said.out
    assert "cell.toml" in said.problem and why in said.problem


def test_a_picture_shows_each_tool_on_its_flange(say, tmp_path):
    path = tmp_path / "tool.html"
    said = say("cell", "check", "yumi", "--picture", path)
    assert said.code == 0, said.out
    text = path.read_text()
    for arm in ("right", "left"):
        assert f"{arm} arm: smart_gripper on {arm}_flange" in text
    drawn = json.loads(re.search(r'Plotly.newPlot\(\s*"[^"]*",\s*(\[.*?\]),\s*\{', text, re.S)[1])
    axes = {trace["name"]: trace for trace in drawn if trace["scene"] == "scene"}
    ends = {name: along_of(axes[name]) for name in ("last joint axis", "z of the flange")}
    assert ends["z of the flange"] @ ends["last joint axis"] == pytest.approx(1.0, abs=1e-6)


def along_of(trace):
    """The direction (3,) of a drawn line."""
    along = np.array([trace[axis][1] - trace[axis][0] for axis in "xyz"])
    return along / np.linalg.norm(along)


def test_a_picture_where_none_can_be_written_is_refused(say, tmp_path):
    said = say("cell", "check", "yumi", "--picture", tmp_path / "nowhere" / "tool.html")
    assert said.code == 2
    assert "nowhere/tool.html" in said.err
