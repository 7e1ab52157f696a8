"""How much load grips hold, against what can be worked out by hand."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Tool
from workbench.model.geometry import Box, Mesh, Solid, pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, Part
from workbench.model.symmetry import Symmetry
from workbench.perception.views.surfaces import triangles_of
from workbench.planning.grasps.firmness import GRAVITY, RESERVE, firmness, in_words
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.grasps.grip_program import Contacts, Touch

FORCE, FRICTION = 20.0, 0.5


def bar(length: float, mass: float, friction: float | None = FRICTION) -> Part:
    """A bar of 16 x 16 mm along x, its middle at the origin."""
    box = Box(np.array([length, 0.016, 0.016]))
    surface = triangles_of(box)
    mesh = Mesh(np.asarray(surface.vertices), np.asarray(surface.faces))
    piece = Solid("bar", box, pin.SE3.Identity())
    return Part("bar", mesh, (piece,), mass, Symmetry(), GraspLibrary(), friction)


def across(x: float = 0.0) -> Grasp:
    """From above, with the fingers on the sides of the bar."""
    T = pose_from_rpy((x, 0.0, -0.008), (np.pi, 0.0, 0.0))
    return Grasp("across", T, opening=0.02, grip=0.016)


@pytest.fixture(scope="module")
def gripper() -> Tool:
    return replace(read_cell("yumi").arms[0].tool, force=FORCE)


@pytest.fixture(scope="module")
def cup() -> Tool:
    return replace(read_cell("tx2_90").arms[0].tool, force=FORCE)


def pads(radius: float, friction: float = FRICTION) -> Contacts:
    """Two even round pads, 20 mm apart along y."""
    rows = np.linspace(-1.0, 1.0, 21)
    x, z = (one.ravel() for one in np.meshgrid(rows, rows))
    inside = np.hypot(x, z) <= 1.0
    flat = radius * np.column_stack([x, np.zeros_like(x), z])[inside]
    weights = np.full(len(flat), 1 / len(flat))
    y = np.array([0.0, 1.0, 0.0])
    return Contacts(
        tuple(Touch(flat + side * 0.01 * y, weights, -side * y, -side * y) for side in (1.0, -1.0)),
        FORCE,
        friction,
    )


def test_in_line_with_the_pads_friction_of_both_holds():
    """2 mu F, whatever the pads are large."""
    firm = firmness(pads(0.005), np.zeros(3), mass=3.0, acceleration=0.0)
    assert firm.share * firm.load == pytest.approx(2 * FRICTION * FORCE, rel=0.02)
    assert firm.load == pytest.approx(RESERVE * 3.0 * GRAVITY)
    assert not firm.turns


@pytest.mark.parametrize("radius", [0.003, 0.006])
def test_far_from_the_pads_the_torque_of_both_holds(radius):
    """A round patch under even pressure takes 2/3 mu F r about its normal: two of them."""
    lever = 0.2
    firm = firmness(pads(radius), np.array([lever, 0.0, 0.0]), mass=1.0, acceleration=0.0)
    assert firm.share * firm.load == pytest.approx(
        4 / 3 * FRICTION * FORCE * radius / lever, rel=0.1
    )
    assert firm.turns


def test_a_point_takes_no_torque():
    here, y = np.zeros((1, 3)), np.array([0.0, 1.0, 0.0])
    touches = tuple(
        Touch(here + side * 0.01 * y, np.ones(1), -side * y, -side * y) for side in (1.0, -1.0)
    )
    contacts = Contacts(touches, FORCE, FRICTION)
    assert firmness(contacts, np.array([0.05, 0.0, 0.0]), 0.1, 0.0).share < 0.01
    assert firmness(contacts, np.zeros(3), 0.1, 0.0).share > 10.0


def test_the_share_falls_as_mass_and_acceleration_grow():
    centre = np.array([0.03, 0.0, 0.0])
    light = firmness(pads(0.005), centre, 0.1, 0.0)
    assert firmness(pads(0.005), centre, 0.2, 0.0).share == pytest.approx(light.share / 2)
    assert firmness(pads(0.005), centre, 0.1, GRAVITY).share == pytest.approx(light.share / 2)
    assert firmness(pads(0.005, 0.25), centre, 0.1, 0.0).share < 0.6 * light.share


def test_a_bar_is_held_in_its_middle_and_turns_at_its_end(gripper):
    checker = GraspChecker(bar(0.2, 0.5), gripper, 2.0)
    middle, end = checker.check(across()), checker.check(across(0.09))
    assert middle.is_ok and middle.firmness is not None and middle.firmness.is_enough
    assert [finding.kind for finding in end.findings] == ["weight"]
    assert str(end.findings[0].text).startswith("would turn in the fingers: 0.")
    assert str(end.findings[0].text).endswith(
        "of the torque is held (20 N, friction 0.5, 2.0 m/s2)"
    )


def test_too_heavy_a_part_slips(gripper):
    check = GraspChecker(bar(0.04, 5.0), gripper, 2.0).check(across())
    assert str(check.findings[0].text).startswith("would slip in the fingers: 0.28 of the load")
    assert check.findings[0].amount == pytest.approx(
        2 * FRICTION * FORCE / 5 / 11.81 / RESERVE, rel=0.04
    )


def test_what_nobody_has_stated_is_not_judged(gripper):
    heavy, unstated = bar(0.2, 50.0), bar(0.2, 50.0, friction=None)
    for part, tool, acceleration in (
        (unstated, gripper, 2.0),
        (heavy, replace(gripper, force=None), 2.0),
        (heavy, gripper, None),
    ):
        check = GraspChecker(part, tool, acceleration).check(across())
        assert check.is_ok and check.firmness is None
    assert unstated.digest != heavy.digest


def test_a_cup_holds_by_its_pull_and_turns_under_a_long_part(cup):
    """Sideways friction of the lip holds no more than mu (F - what pulls away)."""
    on_top = Grasp("top", pose_from_rpy((0.0, 0.0, 0.0), (np.pi, 0.0, 0.0)), 0.0, 0.0)
    box = Box(np.array([0.1, 0.1, 0.02]))
    surface = triangles_of(box)
    mesh = Mesh(np.asarray(surface.vertices) - [0, 0, 0.01], np.asarray(surface.faces))
    piece = Solid("plate", box, pose_from_rpy((0.0, 0.0, -0.01)))
    plate = Part("plate", mesh, (piece,), 0.2, Symmetry(), GraspLibrary(), FRICTION)
    firm = GraspChecker(plate, cup, 0.0).check(on_top).firmness
    assert firm is not None and firm.is_cup
    assert 2.5 < firm.share < FRICTION * FORCE / (0.2 * GRAVITY)
    beside = replace(on_top, T_part_tcp=pose_from_rpy((0.03, 0.0, 0.0), (np.pi, 0.0, 0.0)))
    aside = GraspChecker(replace(plate, mass=0.5), cup, 0.0).check(beside)
    assert str(aside.findings[0].text).startswith("would turn on the cup: 0.")


def test_suggestions_leave_out_what_would_turn_and_say_so(gripper):
    part, refused = bar(0.2, 1.0), []
    every = suggest(part, gripper, most=40, seed=1)
    firm = suggest(part, gripper, most=40, seed=1, acceleration=2.0, refused=refused.append)
    assert firm and refused and len(firm) < len(every)
    assert all(one.check.firmness is not None and one.check.firmness.is_enough for one in firm)
    assert max(one.lever for one in firm) < max(one.lever for one in every)
    assert all(check.findings[0].kind == "weight" for check in refused)


def test_what_is_not_enough_is_never_told_as_whole():
    firm = firmness(pads(0.005), np.zeros(3), 3.0, 0.0)
    just = replace(firm, share=0.9999)
    assert str(in_words(just)).startswith("would slip in the fingers: 0.99 of the load")
    assert str(in_words(replace(just, turns=True, is_cup=True))).startswith(
        "would turn on the cup: 0.99"
    )
    assert str(in_words(replace(firm, share=50.0))).startswith("holds 9.9 times the load (20 N")
