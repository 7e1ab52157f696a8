"""The robot moved by hand: what it meets, how the tool is led, what can be moved and taught."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bending import with_nests
from hypothesis import example, given, settings
from hypothesis import strategies as st
from shipped import shipped

from workbench.app.core.state import EditedCell, State
from workbench.gui.cell.jog import JogFinder, lead_to
from workbench.gui.cell.views import cell_line, contacts_html, tree_html
from workbench.gui.shared.movable_frames import (
    frame_of,
    move_frame,
    pose_of,
    shown_pose,
    things,
    tool_of,
    typed_pose,
    with_home,
    with_places,
)
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import plain
from workbench.planning.kinematics.chain import chain_of

CELL = shipped("yumi")
ARM = CELL.arms[0]
CHAIN = chain_of(CELL, ARM)


def test_at_home_the_robot_is_clear_and_the_nearest_pair_is_named():
    jogged = JogFinder().check_jog(State(CELL), {ARM.name: np.asarray(ARM.home)})
    assert jogged.contacts == () and jogged.meets == ()
    assert 0 < jogged.clearance < 0.1 and jogged.pair is not None
    assert "Clear; nearest: " in contacts_html(jogged)


def test_everything_that_is_too_close_is_told_nearest_first():
    finder, rng = JogFinder(), np.random.default_rng(0)
    jogged = finder.check_jog(State(CELL), {})
    while len(jogged.contacts) < 3:
        q = rng.uniform(CHAIN.lower, CHAIN.upper)
        jogged = finder.check_jog(State(CELL), {ARM.name: q})
    distances = [contact.distance for contact in jogged.contacts]
    assert distances == sorted(distances)
    assert len({contact.pair for contact in jogged.contacts}) == len(jogged.contacts)
    assert len(jogged.meets) >= 2
    said = contacts_html(jogged)
    assert all(name in said for name in jogged.contacts[0].pair)


def test_the_tool_is_led_along_without_a_jump():
    q = np.asarray(ARM.home)
    T = CHAIN.pose(q)
    for _ in range(20):
        T = T * pose_from_rpy((0, 0, -0.002), (0, 0, 0.01))
        onward = lead_to(CHAIN, q, T)
        assert onward is not None and np.abs(onward - q).max() < 0.1
        q = onward
    assert CHAIN.pose(q).isApprox(T, 1e-5)


def test_out_of_reach_nobody_is_led():
    assert lead_to(CHAIN, np.asarray(ARM.home), pose_from_rpy((3, 0, 0))) is None


@settings(deadline=None)
@given(st.sampled_from(things(CELL)), st.tuples(*[st.floats(-0.5, 0.5)] * 3))
def test_every_thing_can_be_moved_and_nothing_else_moves(thing, xyz):
    T = pose_from_rpy(xyz, (0.1, 0.2, 0.3))
    cell = move_frame(CELL, thing, T)
    for other in things(CELL):
        if other == thing:
            assert np.allclose(pose_of(cell, other).homogeneous, T.homogeneous, atol=1e-12)
            continue
        # A TCP stays at its flange, wherever the robot is.
        was, now = (frame_of(one, other).actInv(pose_of(one, other)) for one in (CELL, cell))
        atol = 1e-12 if tool_of(CELL, other) else 0.0
        assert np.allclose(now.homogeneous, was.homogeneous, rtol=0.0, atol=atol)


@given(
    st.tuples(*[st.floats(-900, 900)] * 3),
    st.tuples(st.floats(-179, 179), st.floats(-89, 89), st.floats(-179, 179)),
)
@example((0.0, 0.0, 0.0), (0.0005, 0.0005, 0.0005))
@example((0.0, 0.0, 0.0), (0.001, 0.0, 0.0))
def test_what_is_shown_typed_again_is_the_same(position, rpy):
    T = typed_pose(*shown_pose(typed_pose(position, rpy)))
    again = typed_pose(*shown_pose(T))
    assert np.allclose(T.homogeneous, again.homogeneous, atol=1e-9)
    assert np.allclose(T.translation * 1000, position, atol=0.0051)


@pytest.mark.parametrize("pitch", [90.0, -90.0, 89.9999, -89.9999])
@given(roll=st.floats(-180, 180), yaw=st.floats(-180, 180))
def test_where_roll_and_yaw_are_one_all_is_told_as_yaw(pitch, roll, yaw):
    T = typed_pose((0, 0, 0), (roll, pitch, yaw))
    _, (shown_roll, shown_pitch, shown_yaw) = shown_pose(T)
    assert shown_roll == 0.0 and abs(shown_pitch) == 90.0 and -180.0 < shown_yaw <= 180.0
    again = typed_pose((0, 0, 0), (shown_roll, shown_pitch, shown_yaw))
    assert np.linalg.norm(pin.log3(T.actInv(again).rotation)) < 4e-5


def test_near_there_a_pose_is_not_bent_to_read_well():
    T = typed_pose((0, 0, 0), (20.0, 89.9, 30.0))
    assert shown_pose(T)[1] == (20.0, 89.9, 30.0)


def test_homes_and_places_are_taught():
    home = np.asarray(ARM.home) + 0.1
    assert np.array_equal(with_home(CELL, "right", home).arm("right").home, home)
    assert with_home(CELL, "right", home).arm("left") is CELL.arm("left")
    assert things(with_places(CELL, "left", ())) == tuple(
        name for name in things(CELL) if not name.startswith("left place")
    )


def test_the_line_about_the_file():
    cell = CELL
    assert "As in its file" in cell_line(State(cell, saved=cell.digest))
    assert "Changed and not saved" in cell_line(
        State(cell, saved="other", before=(EditedCell(cell, plain("moved")),))
    )
    said = cell_line(State(cell, saved=cell.digest, cell_problem="key <bin>: is missing"))
    assert "cannot be used" in said and "<bin>" not in said


def test_no_jog_is_explained():
    assert "nothing is sent" in contacts_html(None)


@pytest.mark.parametrize("thing", ["bin", "scanner", "robot"])
def test_a_moved_thing_makes_another_cell(thing):
    assert move_frame(CELL, thing, pose_from_rpy((0.4, 0.1, 0.2))).digest != CELL.digest


def test_the_tree_names_everything_and_escapes_it():
    said = tree_html(CELL)
    for name in ("robot yumi", "right arm, 7 axes", "part keyed_cylinder", "tray_left", "bin"):
        assert name in said
    evil = replace(CELL, fixtures=(replace(CELL.fixtures[0], name="<script>"),))
    assert "<script>" not in tree_html(evil)


def test_a_place_of_parts_is_moved_and_stays_what_it_is():
    nests = with_nests(CELL, part="keyed_cylinder", free_rotation=0.5)
    thing = "left part-place 1"
    assert thing in things(nests) and "left place 1" not in things(nests)
    T = pose_from_rpy((0.3, 0.3, 0.2), (0.1, 0.2, 0.3))
    other = move_frame(nests, thing, T)
    assert pose_of(other, thing).isApprox(T, 1e-12)
    (place,) = other.arm("left").part_places
    assert (place.part, place.free_rotation) == ("keyed_cylinder", 0.5)
    assert digest_of(other.arm("right")) == digest_of(nests.arm("right"))
    assert other.digest != nests.digest
