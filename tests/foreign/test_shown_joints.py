"""Joints of a pick server's waypoints, against the kinematics of FANUC and KUKA themselves."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import xacro
import yaml
from bring import DATA

from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of
from workbench.cli.main import main
from workbench.journal.journal import Journal

NEAR_DEG = 0.001

NEAR_M = 1e-5
"""What 0.001 degrees are at an arm's length of 0.6 m."""

NOT_HERE = pytest.mark.skipif(
    not DATA.is_dir(),
    reason="the public data is not here: ../shared/data/foreign beside the checkout",
)

FANUC = {
    "file": "fanuc_crx_description/robot/crx10ia.urdf.xacro",
    "joints": ["J1", "J2", "J3", "J4", "J5", "J6"],
    "arm": "axis_coupling = [[1, 0, 0, 0, 0, 0], [0, 1, 0, 0, 0, 0], [0, -1, 1, 0, 0, 0], "
    "[0, 0, 0, 1, 0, 0], [0, 0, 0, 0, 1, 0], [0, 0, 0, 0, 0, 1]]\n",
}
KUKA = {
    "file": "kuka_agilus_support/urdf/kr6_r900_2.urdf.xacro",
    "joints": [f"joint_{k}" for k in range(1, 7)],
    "arm": "",
}

LINK = """[controller]
protocol = "pick-server"
host = "127.0.0.1"
port = 1025

[controller.options]
longest = 128

"""


def sent_by_demo(robot, folder, capsys):
    """Waypoints (n, 6) [deg] as they were sent in a demo, and (n, 6) [rad] as proven."""
    home = folder / "cell"
    new = ["cell", "new", "tried", "--urdf", str(DATA / "robots" / robot["file"])]
    assert main([*new, "--tool", "suction", "--part", "puck", "--out", str(home)]) == 0
    text = (home / "cell.toml").read_text()
    begin = text.index("[controller]")
    text = text[:begin] + LINK + text[text.index("[policy]") :]
    assert text.count("[[arm]]\n") == 1
    if robot is FANUC:  # home counts as the controller shows it, too
        typed = [float(value) for value in re.search(r"home_deg = \[(.*)\]", text)[1].split(",")]
        typed[2] -= typed[1]
        text = re.sub(r"home_deg = .*", f"home_deg = {typed}", text)
    (home / "cell.toml").write_text(text.replace("[[arm]]\n", "[[arm]]\n" + robot["arm"]))
    capsys.readouterr()
    demo = ["demo", "--cell", str(home / "cell.toml"), "--sessions", str(folder / "sessions")]
    assert main([*demo, "--speed", "50", "--json"]) == 0
    journal = Journal(Path(json.loads(capsys.readouterr().out)["session"]))
    states = [state for _, state in replay(journal, cell_of(journal))]
    journal.close()
    plan = next(state.plan for state in states if state.plan)
    receipts = max((state.receipts for state in states), key=len)
    sent = [r.sent.split()[1:7] for r in receipts if r.sent.startswith("TO ")]
    legs = [plan.arm(arm).leg(leg) for step in plan.sequence for arm, leg in step.runs]
    shown, proven = np.array(sent, float), np.concatenate([leg.q[1:] for leg in legs])
    assert len(shown) == len(proven) > 10
    assert np.ptp(shown, axis=0).max() > 20
    return shown, proven


def flange_of(robot, frame, folder):
    """The pose of a frame by Pinocchio, of joint values (6,) [rad] of the maker's own file."""
    packages = folder / "packages"
    shutil.copytree(DATA / "robots", packages, ignore=shutil.ignore_patterns("meshes"))
    for file in packages.rglob("*.xacro"):
        text = file.read_text()
        for package in packages.iterdir():
            text = text.replace(f"$(find {package.name})", str(package))
        file.write_text(text)
    model = pin.buildModelFromXML(xacro.process_file(str(packages / robot["file"])).toxml())
    data, places = model.createData(), [model.getJointId(name) for name in robot["joints"]]
    assert model.nq == 6

    def at(values):
        q = np.zeros(6)
        q[[model.idx_qs[k] for k in places]] = values
        pin.framesForwardKinematics(model, data, q)
        base = data.oMf[model.getFrameId("base_link")]
        return base.actInv(data.oMf[model.getFrameId(frame)]), data

    return at, model


def turned(axis, angle):
    return pin.SE3(
        pin.AngleAxis(angle, np.eye(3)["xyz".index(axis)]).toRotationMatrix(), np.zeros(3)
    )


def moved(x, y, z):
    return pin.SE3(np.eye(3), np.array([x, y, z]))


def is_near(T, other):
    """Within 0.001 degrees, and what these are at the flange."""
    off = T.actInv(other)
    angle = np.rad2deg(np.linalg.norm(pin.log3(off.rotation)))
    return angle < NEAR_DEG and np.linalg.norm(off.translation) < NEAR_M


@NOT_HERE
def test_fanuc_shows_what_is_sent_where_its_own_kinematics_has_the_robot(tmp_path, capsys):
    shown, proven = sent_by_demo(FANUC, tmp_path, capsys)
    # FANUC's ROS 2 driver adds the J2 of the controller to its J3, and nothing else.
    of_file = np.deg2rad(shown)
    of_file[:, 2] += of_file[:, 1]
    assert np.abs(np.rad2deg(of_file - proven)).max() < NEAR_DEG
    assert np.abs(np.rad2deg(np.deg2rad(shown) - proven)).max() > 1, "the coupling matters"
    at, model = flange_of(FANUC, "fanuc_flange", tmp_path)
    # Modified Denavit-Hartenberg rows (a, alpha, theta, r) of Abbes and Poisson 2024, table 2: they
    # are in the controller's own joints, and their base is where axes 1 and 2 meet.
    data = at(np.zeros(6))[1]
    base = data.oMf[model.getFrameId("base_link")].actInv(data.oMi[model.getJointId("J1")])
    for words, q in zip(np.deg2rad(shown), proven, strict=True):
        T, data = at(q)
        j1, j2, j3, j4, j5, j6 = words
        rows = (
            (0, 0, j1, 0),
            (0, -np.pi / 2, j2 - np.pi / 2, 0),
            (0.54, np.pi, j2 + j3, 0),
            (0, -np.pi / 2, j4, -0.54),
            (0, np.pi / 2, j5, 0.15),
            (0, -np.pi / 2, j6, -0.16),
        )
        there = base
        for a, alpha, theta, r in rows:
            there *= turned("x", alpha) * moved(a, 0, 0) * turned("z", theta) * moved(0, 0, r)
        # The table's last z points into the flange.
        assert is_near(T, there * turned("x", np.pi)), (np.rad2deg(words), T, there)
        forearm = data.oMi[model.getJointId("J4")].rotation @ [1.0, 0, 0]
        assert np.rad2deg(np.arcsin(forearm[2])) == pytest.approx(
            np.rad2deg(np.arcsin(np.sin(j3))), abs=NEAR_DEG
        ), "J3 counts the forearm against the horizontal"


@NOT_HERE
def test_kuka_shows_what_is_sent_where_its_own_kinematics_has_the_robot(tmp_path, capsys):
    shown, proven = sent_by_demo(KUKA, tmp_path, capsys)
    assert np.abs(shown - np.rad2deg(proven)).max() < NEAR_DEG
    at, _ = flange_of(KUKA, "tool0", tmp_path)
    text = (DATA / "robots/kuka_agilus_support/config/opw_parameters_kr6r900_2.yaml").read_text()
    stated = yaml.safe_load(text.replace("deg(-90.0)", str(-np.pi / 2)))
    size = stated["opw_kinematics_geometric_parameters"]
    offsets = np.array(stated["opw_kinematics_joint_offsets"])
    signs = np.array(stated["opw_kinematics_joint_sign_corrections"])
    for words, q in zip(np.deg2rad(shown), proven, strict=True):
        t = words * signs - offsets
        there = (
            turned("z", t[0])
            * moved(size["a1"], size["b"], size["c1"])
            * turned("y", t[1])
            * moved(0, 0, size["c2"])
            * turned("y", t[2])
            * moved(size["a2"], 0, size["c3"])
            * turned("z", t[3])
            * turned("y", t[4])
            * turned("z", t[5])
            * moved(0, 0, size["c4"])
        )
        assert is_near(at(q)[0], there), (at(q)[0], there)
