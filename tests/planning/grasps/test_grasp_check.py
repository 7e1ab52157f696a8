"""Grasps that are good, and each thing that can be wrong with one, with its number."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Tool
from workbench.model.geometry import Box, Mesh, Solid, pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, Part
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.grasp_frames import fitted_opening, frame_at, snap_to_surface


@pytest.fixture(scope="module")
def gripper() -> Tool:
    return read_cell("yumi").arms[0].tool


@pytest.fixture(scope="module")
def cup() -> Tool:
    return read_cell("tx2_90").arms[0].tool


def block(*size: float) -> Part:
    """A cuboid [m]."""
    surface = trimesh.creation.box(size)
    mesh = Mesh(surface.vertices, surface.faces)
    solid = Solid("block", Box(np.array(size)), pin.SE3.Identity())
    return Part("block", mesh, (solid,), 0.1, Symmetry(), GraspLibrary())


def from_above(x: float = 0.0, y: float = 0.0, z: float = 0.0, turn: float = 0.0) -> pin.SE3:
    """The tool pointing down, fingers closing along y."""
    return pose_from_rpy((x, y, z), (np.pi, 0.0, turn))


@pytest.fixture(scope="module")
def checker(gripper) -> GraspChecker:
    return GraspChecker(block(0.06, 0.03, 0.04), gripper)


def kinds(checker: GraspChecker, grasp: Grasp) -> list[str]:
    return [finding.kind for finding in checker.check(grasp).findings]


def test_the_shipped_grasps_are_good_with_the_shipped_tools(gripper, cup):
    for name, tool in (("keyed_cylinder", gripper), ("puck", cup)):
        part = read_part(name)
        checker = GraspChecker(part, tool)
        for grasp in part.library.grasps:
            assert checker.check(grasp).findings == ()
    part = read_part("keyed_cylinder")
    check = GraspChecker(part, gripper).check(part.library.grasps[0])
    assert check.width == pytest.approx(0.03, abs=1e-4)
    assert check.clearance == pytest.approx(0.005, abs=1e-4)


def test_a_good_grasp_tells_width_and_clearance(checker):
    check = checker.check(Grasp("good", from_above(), opening=0.04, grip=0.03))
    assert check.is_ok and check.findings == ()
    assert check.width == pytest.approx(0.03)
    assert check.clearance == pytest.approx(0.005)
    assert check.hold is not None
    assert check.hold.offset == pytest.approx(0.0)
    # Fingers are 10 mm wide, and their tips are 20 mm below the block's top.
    assert check.hold.areas == pytest.approx((200e-6, 200e-6), rel=0.1)


def test_a_finger_that_cuts_is_told_with_its_name_and_depth(checker):
    grasp = Grasp("shifted", from_above(y=0.0062), opening=0.04, grip=0.03)
    findings = checker.check(grasp).findings
    cut = next(finding for finding in findings if finding.kind == "cut")
    assert cut.amount == pytest.approx(0.0012, abs=1e-5)
    assert str(cut.text) == "finger_a cuts the part by 1.2 mm at opening 40.0 mm"
    mirrored = replace(grasp, T_part_tcp=from_above(y=-0.0062))
    assert "finger_b cuts" in str(checker.check(mirrored).findings[0].text)


def test_openings_outside_of_the_stroke_are_told(checker):
    found = checker.check(Grasp("wide", from_above(), opening=0.07, grip=0.03)).findings
    assert [finding.kind for finding in found] == ["stroke"]
    assert str(found[0].text) == "opening 70.0 mm is outside of the stroke, 0.0 mm to 50.0 mm"


def test_a_grip_that_is_not_the_width_is_told(checker):
    loose = Grasp("loose", from_above(), opening=0.045, grip=0.036)
    assert kinds(checker, loose) == ["width"]
    tight = Grasp("tight", from_above(), opening=0.04, grip=0.024)
    assert kinds(checker, tight) == ["cut", "width"]
    pressed = Grasp("pressed", from_above(), opening=0.04, grip=0.029)
    assert kinds(checker, pressed) == []


def test_fingers_beside_the_part_hold_nothing(checker):
    assert kinds(checker, Grasp("beside", from_above(x=0.05), 0.04, 0.03)) == ["contact"]
    assert kinds(checker, Grasp("above", from_above(z=0.03), 0.04, 0.03)) == ["contact"]


def test_the_palm_on_the_part_is_told(checker):
    found = checker.check(Grasp("deep", from_above(z=-0.04), 0.04, 0.03)).findings
    assert found[0].kind == "cut" and "palm" in str(found[0].text)


def test_a_way_in_through_the_part_is_told(gripper):
    # Under a shelf: where it ends nothing is cut, on the way straight down the shelf is.
    shelf = trimesh.creation.box(
        (0.06, 0.1, 0.01), trimesh.transformations.translation_matrix([0, 0, 0.1])
    )
    low = trimesh.creation.box((0.06, 0.03, 0.04))
    surface = trimesh.util.concatenate([low, shelf])
    solids = (
        Solid("low", Box(np.array([0.06, 0.03, 0.04])), pin.SE3.Identity()),
        Solid("shelf", Box(np.array([0.06, 0.1, 0.01])), pose_from_rpy((0, 0, 0.2))),
    )
    mesh = Mesh(surface.vertices, surface.faces)
    part = Part("shelf", mesh, solids, 0.1, Symmetry(), GraspLibrary())
    checker = GraspChecker(part, gripper)
    grasp = Grasp("down", from_above(), 0.04, 0.03, approach_length=0.1)
    assert kinds(checker, grasp) == ["approach"]
    # Leaning back while coming in along x keeps clear of it.
    sideways = replace(grasp, approach=np.array([1.0, 0, 0]))
    assert "approach" not in kinds(checker, sideways)


def test_an_inclined_face_would_slip(gripper):
    wedge = block(0.06, 0.03, 0.04)
    tilted = Grasp("tilted", from_above(turn=np.deg2rad(30)), 0.05, 0.034)
    check = GraspChecker(wedge, gripper).check(tilted)
    assert {finding.kind for finding in check.findings if finding.is_problem} >= {"slip"}
    slip = next(finding for finding in check.findings if finding.kind == "slip")
    assert slip.amount == pytest.approx(np.deg2rad(30), abs=0.01)


def test_a_part_off_the_middle_is_told(checker):
    check = checker.check(Grasp("off", from_above(y=0.002), 0.04, 0.03))
    assert check.hold is not None
    assert abs(check.hold.offset) == pytest.approx(0.002)
    assert kinds(checker, Grasp("off", from_above(y=0.002), 0.04, 0.03)) == ["cut", "contact"]
    assert "2.0 mm off centre" in str(check.findings[1].text)
    assert check.findings[0].is_problem and not check.findings[1].is_problem


def test_width_is_measured_between_the_fingers_only(gripper):
    part = block(0.08, 0.03, 0.04)
    checker = GraspChecker(part, gripper)
    assert checker.hold(from_above()).width == pytest.approx(0.03)
    assert checker.hold(from_above(turn=np.pi / 2)).width == pytest.approx(0.08)
    assert checker.hold(from_above(x=0.1)) is None
    # Of a tube only the wall that the fingers straddle counts.
    tube = trimesh.creation.annulus(0.02, 0.023, 0.05)
    pipe = replace(part, mesh=Mesh(tube.vertices, tube.faces))
    hold = GraspChecker(pipe, gripper).hold(from_above(y=0.0215))
    assert hold.width == pytest.approx(0.003, abs=6e-4)


def test_width_needs_two_fingers(cup):
    assert GraspChecker(block(0.03, 0.03, 0.03), cup).hold(from_above()) is None


def test_a_cup_needs_a_surface_that_closes_its_lip(cup):
    checker = GraspChecker(block(0.1, 0.1, 0.02), cup)

    def at(T: pin.SE3) -> list[str]:
        return [
            str(f.text) for f in checker.check(Grasp("cup", T, 0, 0)).findings if f.kind == "seal"
        ]

    assert at(from_above(z=0.01)) == []
    assert "lie beyond the part" in at(from_above(x=0.045, z=0.01))[0]
    assert at(from_above(z=0.02)) == ["the cup ends 10.0 mm before the surface"]
    assert "uneven by" in at(from_above(z=0.01) * pose_from_rpy((0, 0, 0), (0.2, 0, 0)))[0]
    assert at(from_above(x=0.2, z=0.01)) == ["there is nothing under the cup"]


def test_a_grasp_for_another_tool_says_so(checker):
    check = checker.check(Grasp("cup", from_above(), 0.04, 0.03, tool="cup"))
    assert check.is_ok and "is for tool cup" in str(check.findings[0].text)


def test_a_click_makes_a_grasp_that_works(checker):
    T = frame_at(checker, np.array([0.004, 0.002, 0.02]), np.array([0.0, 0.0, 1.0]))
    assert T.rotation[:, 2] == pytest.approx([0, 0, -1])
    assert abs(T.rotation[0, 0]) == pytest.approx(1.0), "x lies along the longer side"
    # 40 mm are under the point: half of it and 3 mm.  Across the fingers have it in their middle.
    assert T.translation == pytest.approx([0.004, 0.0, -0.003])
    fingers = fitted_opening(checker, T)
    assert fingers is not None and fingers.grip == pytest.approx(0.03)
    assert checker.check(Grasp("click", T, fingers.opening, fingers.grip)).is_ok


def test_a_click_on_the_side_of_a_cylinder_closes_across_its_axis(gripper):
    part = read_part("keyed_cylinder")
    checker = GraspChecker(part, gripper)
    angle = np.deg2rad(33.75)
    normal = np.array([np.cos(angle), np.sin(angle), 0.0])
    T = frame_at(checker, 0.015 * normal + [0, 0, -0.02], normal)
    assert abs(T.rotation[2, 0]) == pytest.approx(1.0)
    fingers = fitted_opening(checker, T)
    assert fingers is not None
    assert checker.check(Grasp("click", T, fingers.opening, fingers.grip)).is_ok


def test_tips_do_not_stand_out_below_a_thin_part(gripper):
    plate = GraspChecker(block(0.1, 0.03, 0.003), gripper)
    T = frame_at(plate, np.array([0.0, 0.0, 0.0015]), np.array([0.0, 0.0, 1.0]))
    assert T.translation[2] > -0.0015


def test_a_cup_stands_on_the_point(cup):
    checker = GraspChecker(block(0.1, 0.1, 0.02), cup)
    T = frame_at(checker, np.array([0.01, 0.0, 0.01]), np.array([0.0, 0.0, 1.0]))
    assert T.translation == pytest.approx([0.01, 0.0, 0.01])
    assert checker.check(Grasp("click", T, 0, 0)).is_ok


def test_snapping_squares_a_pose_to_the_face_that_it_comes_through(checker):
    crooked = from_above(x=0.01, z=0.03) * pose_from_rpy((0, 0, 0), (0.3, 0.2, 0.1))
    T = snap_to_surface(checker, crooked)
    assert T.rotation[:, 2] == pytest.approx([0, 0, -1])
    assert float(T.rotation[:, 0] @ crooked.rotation[:, 0]) > 0.9
    assert T.translation[2] == pytest.approx(-0.003)
    again = snap_to_surface(checker, T)
    assert again.isApprox(T, 1e-9), "what is snapped stays"


def test_snapping_passes_over_triangles_without_an_area(gripper):
    """They have no normal to turn to.  Here the first one lies along an edge of the block."""
    part = block(0.06, 0.03, 0.04)
    corners = np.vstack([part.mesh.points, [[0.03, 0.015, 0.0]]])
    edge = np.flatnonzero((part.mesh.points[:, :2] > 0).all(axis=1))
    mesh = Mesh(corners, np.vstack([[[*edge, 8]], part.mesh.triangles]))
    T = snap_to_surface(
        GraspChecker(replace(part, mesh=mesh), gripper),
        pose_from_rpy((0.1, 0.1, 0.0), (np.pi, 0, 0)),
    )
    assert np.isfinite(T.homogeneous).all()


def test_snapping_from_beside_goes_to_the_nearest_point(checker):
    away = from_above(x=0.05)
    T = snap_to_surface(checker, away)
    assert T.rotation[:, 2] == pytest.approx([-1, 0, 0])
