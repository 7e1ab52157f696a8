"""Values are made once, cannot be changed, and refuse what is no pose and no scan."""

import dataclasses
import pickle

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.formats.cells.reading import read_cell
from workbench.model.digest import canonical
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import pose_from_matrix, pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, GraspPattern
from workbench.model.plan import ArmPlan, Guarantee, Leg, Plan, Step, Strategy
from workbench.model.scan import Detection, LocalizationResult, Scan

angles = st.floats(-3.0, 3.0)
lengths = st.floats(-2.0, 2.0)
poses = st.builds(
    lambda x, y, z, r, p, w: pose_from_rpy((x, y, z), (r, p, w)),
    lengths,
    lengths,
    lengths,
    angles,
    angles,
    angles,
)


@settings(max_examples=50, deadline=None)
@given(poses, poses, poses)
def test_poses_form_a_group(T_a_b, T_b_c, T_c_d):
    left, right = (T_a_b * T_b_c) * T_c_d, T_a_b * (T_b_c * T_c_d)
    np.testing.assert_allclose(left.homogeneous, right.homogeneous, atol=1e-9)
    identity = T_a_b * T_a_b.inverse()
    np.testing.assert_allclose(identity.homogeneous, np.eye(4), atol=1e-9)


@settings(max_examples=50, deadline=None)
@given(poses)
def test_a_matrix_gives_back_its_pose(T):
    again = pose_from_matrix(T.homogeneous[:3])
    np.testing.assert_allclose(again.homogeneous, T.homogeneous, atol=1e-12)


@pytest.mark.parametrize(
    ("matrix", "says"),
    [
        (np.eye(3), "3 x 4 or 4 x 4"),
        (np.full((3, 4), np.nan), "finite"),
        (np.diag([1.0, 1.0, -1.0, 1.0]), "not a rotation"),
        (2 * np.eye(4)[:3], "not a rotation"),
        (np.vstack([np.eye(4)[:3], np.ones(4)]), "last row"),
    ],
)
def test_what_is_no_pose_is_refused(matrix, says):
    with pytest.raises(InputError, match=says):
        pose_from_matrix(matrix)


def test_a_value_keeps_no_door_open_to_its_insides():
    T, points = pin.SE3.Identity(), np.zeros((4, 3))
    points[:, 2] = 1.0
    scan = Scan(points, T, "test")
    before = scan.digest
    T.translation[:] = 5.0
    points[:] = 9.0
    assert scan.points.max() == 1.0 and scan.T_world_scanner.translation.max() == 0.0
    assert dataclasses.replace(scan).digest == before
    with pytest.raises(ValueError, match="read-only"):
        scan.points[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        scan.source = "other"


def test_time_and_source_do_not_make_another_scan():
    points = np.ones((3, 3))
    one = Scan(points, pin.SE3.Identity(), "a", at=1.0)
    assert one.digest == Scan(points, pin.SE3.Identity(), "b", at=2.0).digest
    assert one.digest != Scan(points + 1e-6, pin.SE3.Identity(), "a").digest


@pytest.mark.parametrize("points", [np.zeros((0, 3)), np.zeros((3, 2)), np.full((2, 3), np.inf)])
def test_a_scan_needs_finite_points(points):
    with pytest.raises(InputError):
        Scan(points, pin.SE3.Identity(), "test")


def test_a_pattern_writes_out_its_copies_around_and_along():
    grasp = Grasp("side", pose_from_rpy((0.01, 0.0, 0.0)), 0.04, 0.03)
    pattern = GraspPattern(grasp, np.array([0.0, 0.0, 1.0]), (0.0, np.pi / 2), (0.0, 0.02))
    copies = GraspLibrary((grasp, pattern)).grasps
    assert [copy.name for copy in copies] == ["side"] + [
        f"side-{row}-{column}" for row in (1, 2) for column in (1, 2)
    ]
    np.testing.assert_allclose(copies[4].T_part_tcp.translation, [0.0, 0.01, 0.02], atol=1e-12)


def plan(**changes) -> Plan:
    leg = Leg("reach", "joint", False, 0.04, np.zeros((2, 7)), np.array([0.0, 1.0]))
    arm = ArmPlan("right", 0, "side", pin.SE3.Identity(), ("j",), (leg,))
    fields = {
        "cell": "c",
        "cell_digest": "1",
        "scan_digest": "2",
        "seed": 0,
        "strategy": Strategy.single("right"),
        "guarantee": Guarantee.ONE_AT_A_TIME,
        "detections": (Detection("p", pin.SE3.Identity()),),
        "arms": (arm,),
        "sequence": (Step((("right", "reach"),)),),
    }
    return Plan(**(fields | changes))


def test_computing_time_is_not_part_of_a_plan_but_all_else_is():
    assert plan().digest == plan(seconds={"route": 1.0}).digest
    for change in (
        {"seed": 1},
        {"cell_digest": "3"},
        {"strategy": Strategy.single("left")},
        {"arms": ()},
    ):
        assert plan(**change).digest != plan().digest


def test_a_file_error_survives_the_way_to_another_process():
    import pickle

    error = pickle.loads(pickle.dumps(FileError("a.toml", "key x: is missing")))
    assert str(error) == "a.toml: key x: is missing"


def test_a_strategy_is_its_text_wherever_it_goes():
    for text in ("alternated", "coordinated", "right", "arm_2-b"):
        strategy = Strategy(text)
        assert canonical(strategy) == str(strategy) == text
        assert pickle.loads(pickle.dumps(strategy)) == strategy
    assert Strategy("right") == Strategy.single("right")
    assert Strategy.COORDINATED.arm == Strategy.ALTERNATED.arm == ""
    assert Strategy.single("manipulator").words == "manipulator arm only"
    assert Strategy.ALTERNATED.words == "alternated"


@pytest.mark.parametrize("text", ["", "right arm", "-x", "a" * 41, "größe", "right\n"])
def test_what_no_arm_can_be_called_is_no_strategy(text):
    with pytest.raises(InputError, match="the name of an arm is expected"):
        Strategy(text)


def test_values_say_what_they_are_in_a_line_and_in_a_notebook():
    cell = read_cell("yumi")
    T = pin.SE3(np.eye(3), np.array([0.1, 0.2, 0.0304]))
    found = Detection("<b>bolt", T, score=0.913, roll_known=False)
    line = "<Detection part: <b>bolt, place: (100.0, 200.0, 30.4) mm, score: 0.91, roll: not known>"
    assert repr(found) == line
    assert "&lt;b&gt;bolt" in found._repr_html_() and "<b>" not in found._repr_html_()
    result = LocalizationResult((found,))
    assert repr(result) == "<LocalizationResult found: <b>bolt 0.91, rejected: 0>"
    for value in (cell, cell.parts[0]):
        assert value.name in repr(value) and len(repr(value)) < 300
