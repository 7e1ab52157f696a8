"""`workbench cell pose`: what a pendant shows, and why it shows something else."""

import json
import shutil

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.poses.conventions import convention
from workbench.model.geometry import pose_from_rpy
from workbench.planning.kinematics.posture_check import base_poses
from workbench.planning.kinematics.robot import Kinematics

JOINTS = (10, -20, 35, 40, 55, -60)


@pytest.fixture(scope="module")
def robot():
    cell = read_cell("tx2_90")
    return Kinematics(cell), cell.arms[0]


def shown_with(T):
    return [str(round(number, 4)) for number in convention("staubli").show(T)]


def compared(say, T, *more):
    words = ["cell", "pose", "tx2_90", "--format", "staubli"]
    return say(*words, "--joints-deg", *JOINTS, "--shown", *shown_with(T), *more)


def at(robot, joints=JOINTS):
    kinematics, arm = robot
    return base_poses(kinematics, arm, arm.from_axes(np.deg2rad(joints)))


def test_a_pose_is_printed_as_the_pendant_of_a_maker_shows_it(say, robot):
    said = say("cell", "pose", "tx2_90", "--format", "kuka", "--joints-deg", *JOINTS, "--json")
    form = json.loads(said.out)
    assert said.code == 0 and form["causes"] == [] and form["joints_deg"] == list(JOINTS)
    assert form["numbers"] == ["X [mm]", "Y [mm]", "Z [mm]", "A [deg]", "B [deg]", "C [deg]"]
    flange, tcp, _ = (convention("kuka").pose(each["shown"]) for each in form["poses"])
    assert np.allclose(flange.homogeneous, at(robot)["flange"].homogeneous, atol=1e-6)
    assert np.allclose(tcp.homogeneous, at(robot)["tcp"].homogeneous, atol=1e-6)


def test_joints_are_those_that_a_controller_shows_which_counts_in_its_own_way(say, robot, tmp_path):
    folder = shutil.copytree(find("robots", "tx2_90"), tmp_path / "tx2_90")
    text = (folder / "cell.toml").read_text()
    rows = np.eye(6, dtype=int)
    rows[2, 1] = -1
    text = text.replace("[[arm]]\n", f"[[arm]]\naxis_coupling = {rows.tolist()}\n")
    (folder / "cell.toml").write_text(text.replace("abb-socket", "pick-server"))
    shown = [*JOINTS[:2], JOINTS[2] - JOINTS[1], *JOINTS[3:]]
    words = ("cell", "pose", folder / "cell.toml", "--json", "--joints-deg", *shown)
    form = json.loads(say(*words).out)
    assert form["joints_deg"] == shown
    flange = convention(form["format"]).pose(form["poses"][0]["shown"])
    assert np.allclose(flange.homogeneous, at(robot)["flange"].homogeneous, atol=1e-6)


def test_home_is_shown_when_no_joints_are_given(say):
    said = say("cell", "pose", "yumi", "--arm", "left")
    assert said.code == 0 and "left arm of yumi at" in said.out and "as ABB shows it" in said.out


@pytest.mark.parametrize("frame", ["flange", "tcp"])
def test_a_pendant_that_agrees_is_said_to_agree(say, robot, frame):
    said = compared(say, at(robot)[frame])
    assert said.code == 0
    what = "TCP" if frame == "tcp" else "flange"
    assert f"the pendant shows the {what} where the cell has it" in said.out


def test_a_joint_whose_zero_differs_is_named(say, robot):
    moved = list(JOINTS)
    moved[2] += 1.5
    said = compared(say, at(robot, moved)["tcp"])
    assert said.code == 3
    assert "the zero of axis 3" in said.out and "+1.50 deg" in said.out


def test_another_base_is_named_first_where_one_number_explains_it(say, robot):
    raised = pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.478]))
    form = json.loads(compared(say, raised * at(robot)["flange"], "--json").out)
    assert form["causes"][0]["kind"] == "base" and form["causes"][0]["frame"] == "flange"
    assert np.allclose(form["causes"][0]["pose"], [0, 0, 478, 0, 0, 0], atol=0.01)


def test_a_base_that_is_turned_is_named_beside_the_first_joint(say, robot):
    half = pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, np.pi))
    form = json.loads(compared(say, half * at(robot)["tcp"], "--json").out)
    kinds = {(cause["kind"], cause["frame"]) for cause in form["causes"]}
    assert kinds == {("joint", "tcp"), ("base", "tcp")}
    assert abs(abs(form["causes"][0]["offset"]) - np.pi) < 1e-3


def test_another_tool_is_named_first_where_one_number_explains_it(say, robot):
    longer = at(robot)["tcp"] * pose_from_rpy((0.0, 0.0, 0.03))
    said = compared(say, longer)
    first, second = said.out.splitlines()[-4:-2]
    assert said.code == 3 and first.startswith("the pendant uses another tool")
    assert second.startswith("or the pendant uses another base")
    assert "compare a second posture" in said.out


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (("--joints-deg", 1, 2, 3), "--joints-deg needs 6 numbers for the right arm"),
        (("--arm", "third"), "has no arm 'third'"),
        (("--format", "ur", "--shown", 1, 2), "a pose as Universal Robots shows it has"),
    ],
)
def test_what_cannot_be_is_refused_in_a_sentence(say, words, says):
    said = say("cell", "pose", "tx2_90", *words)
    assert said.code == 2 and says in said.err
