"""Arms by Denavit-Hartenberg tables: the same as multiplying the matrices of the books."""

import shutil

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.files.toml_keys import Table
from workbench.formats.robots.dh import read_dh
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection


def about(axis: str, angle: float) -> np.ndarray:
    rpy = {"x": (angle, 0, 0), "z": (0, 0, angle)}[axis]
    return pose_from_rpy((0, 0, 0), rpy).homogeneous


def along(axis: str, length: float) -> np.ndarray:
    return pose_from_rpy({"x": (length, 0, 0), "z": (0, 0, length)}[axis]).homogeneous


def of_the_book(rows, q, convention) -> np.ndarray:
    T = np.eye(4)
    for row, value in zip(rows, q, strict=True):
        alpha, theta = np.deg2rad([row["alpha_deg"], row["theta_deg"]])
        a, d = row["a_mm"] / 1000, row["d_mm"] / 1000
        theta, d = (theta + value, d) if row["kind"] == "revolute" else (theta, d + value)
        x, z = along("x", a) @ about("x", alpha), about("z", theta) @ along("z", d)
        T = T @ (z @ x if convention == "standard" else x @ z)
    return T


def of_the_robot(robot, q) -> np.ndarray:
    T = np.eye(4)
    values = iter(q)
    for joint in robot.chain("flange"):
        T = T @ joint.T_parent_joint.homogeneous
        if joint.kind == "revolute":
            T = T @ about("z", next(values))
        elif joint.kind == "prismatic":
            T = T @ along("z", next(values))
    return T


angles, lengths = st.floats(-180, 180), st.floats(-500, 500)
row = st.fixed_dictionaries(
    {
        "alpha_deg": angles,
        "theta_deg": angles,
        "a_mm": lengths,
        "d_mm": lengths,
        "kind": st.sampled_from(["revolute", "prismatic"]),
    }
)


@settings(max_examples=100, deadline=None)
@given(st.lists(row, min_size=1, max_size=7), st.sampled_from(["standard", "modified"]), st.data())
def test_the_flange_is_where_the_book_has_it(tmp_path_factory, rows, convention, data):
    given_rows = [
        row
        | (
            {"range_deg": [-180, 180], "speed_deg": 100}
            if row["kind"] == "revolute"
            else {"range_mm": [-500, 500], "speed_mm": 100}
        )
        for row in rows
    ]
    path = tmp_path_factory.getbasetemp() / "cell.toml"
    robot = read_dh(Table(path, {"convention": convention, "joint": given_rows}), "r")
    q = [data.draw(st.floats(-0.5, 0.5)) for _ in rows]
    np.testing.assert_allclose(of_the_robot(robot, q), of_the_book(rows, q, convention), atol=1e-9)


TABLE = """
[robot.dh]
convention = "standard"
radius_mm = 50

[[robot.dh.joint]]
alpha_deg = -90
a_mm = 50
d_mm = 478
range_deg = [-180, 180]
speed_deg = 400
[[robot.dh.joint]]
a_mm = 425
d_mm = 50
theta_deg = -90
range_deg = [-130, 147]
speed_deg = 400
[[robot.dh.joint]]
alpha_deg = 90
theta_deg = 90
range_deg = [-145, 145]
speed_deg = 430
[[robot.dh.joint]]
alpha_deg = -90
d_mm = 425
range_deg = [-270, 270]
speed_deg = 540
[[robot.dh.joint]]
alpha_deg = 90
range_deg = [-115, 140]
speed_deg = 475
[[robot.dh.joint]]
d_mm = 100
range_deg = [-270, 270]
speed_deg = 760
"""
"""The TX2-90 by the measures of its data sheet."""


@pytest.fixture
def path(tmp_path):
    shutil.copytree(find("robots", "tx2_90"), tmp_path / "by_table")
    path = tmp_path / "by_table" / "cell.toml"
    text = path.read_text()
    text = text.replace('urdf = "tx2_90.urdf"\nsrdf = "tx2_90.srdf"', TABLE)
    path.write_text(text.replace('flange = "link_6"', 'flange = "flange"'))
    return path


def test_the_shipped_robot_by_its_table_has_the_same_kinematics(path):
    by_table, shipped = read_cell(path), read_cell("tx2_90")
    rng = np.random.default_rng(0)
    arm = shipped.arms[0]
    lower, upper, _ = shipped.robot.limits(arm.joints)
    from workbench.planning.kinematics.chain import chain_of

    one, other = chain_of(by_table, by_table.arms[0]), chain_of(shipped, arm)
    for _ in range(20):
        q = rng.uniform(lower, upper)
        assert one.pose(q).isApprox(other.pose(q), 1e-6)


def test_a_cell_by_a_table_plans_a_pick(path):
    cell = read_cell(path)
    height = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, height + 0.0005))
    result = plan_pick(cell, (Detection("puck", T),), "s")
    assert result.plan is not None, [str(c.verdict) for c in result.candidates]
    assert result.proof.holds, result.proof.violations


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"standard"', '"craig"', "not one of standard, modified"),
        ("range_deg = [-180, 180]", "range_deg = [180, -180]", "must be"),
        ("speed_deg = 400", "speed = 400", "speed_deg: is missing"),
        ("a_mm = 50", "a_mm = 50000", "is not between"),
        ("a_mm = 50", "a = 50", "is not known here"),
    ],
)
def test_a_wrong_table_says_which_key(path, old, new, expected):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(FileError, match=expected):
        read_cell(path)
