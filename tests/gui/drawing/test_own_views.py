"""A pose of a calibration is chosen by its number, which may come to be another one's."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.app.core.state import State
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.gui.cell.jogging import JogControls
from workbench.gui.drawing.own_scene import OwnScene
from workbench.gui.drawing.own_views import OwnViews, has_lost_observation
from workbench.gui.page.modes import Mode, mode_html, mode_of
from workbench.gui.shared.own import Own, OwnLook, ShownPlate
from workbench.model.calibration import BallPlate, PlateObservation
from workbench.model.derived.scanner_poses import scanner_pose
from workbench.model.geometry import pose_from_rpy


def with_poses(*names: str):
    return SimpleNamespace(observations=tuple(SimpleNamespace(name=name) for name in names))


THREE = with_poses("pose 1", "pose 2", "pose 3")


@pytest.mark.parametrize(
    ("number", "before", "now", "is_lost"),
    [
        (None, THREE, with_poses(), False),
        (1, THREE, THREE, False),
        (1, THREE, with_poses("pose 1", "pose 2"), False),
        (1, with_poses("pose 1"), THREE, False),
        (1, None, THREE, False),
        # The last one was removed, all were, and one before the chosen one.
        (2, THREE, with_poses("pose 1", "pose 2"), True),
        (0, THREE, with_poses(), True),
        (0, None, with_poses(), True),
        (1, THREE, with_poses("pose 2", "pose 3"), True),
    ],
)
def test_a_pose_that_was_removed_is_lost(number, before, now, is_lost):
    assert has_lost_observation(Own(observation=number), before, now) is is_lost


HOME_POSE = PlateObservation(
    "pose 1", "right", np.zeros(7), BallPlate(), np.eye(3), 0.0001, np.ones((4, 3))
)


@pytest.fixture
def jogged(cell):
    """A robot that is jogged to a suggested pose, with the plate."""
    jog = {arm.name: np.asarray(arm.home) for arm in cell.arms}
    return Own(jog=jog, plate=ShownPlate("right", BallPlate(), pose_from_rpy((0, 0, 0.1))))


def test_a_scanned_pose_covers_the_robot_that_is_jogged_until_it_is_closed(
    states, view_of, visitor, jogged
):
    shared = view_of(replace(states.idle, observations=(HOME_POSE,)))
    views, controls = OwnViews(), JogControls(visitor)
    first = views.of(jogged, None, shared)
    controls.show(None, first)
    assert mode_of(first) is Mode.JOG and controls._gizmo is not None
    posed = views.of(replace(jogged, observation=0), first, shared)
    controls.show(first, posed)
    assert mode_of(posed) is Mode.POSE and controls._gizmo is None
    back = views.of(jogged, posed, shared)
    controls.show(posed, back)
    assert mode_of(back) is Mode.JOG and controls._gizmo is not None


def test_the_plate_of_a_suggestion_is_drawn_and_named_until_jogging_ends(
    states, view_of, visitor, jogged
):
    scene, views = OwnScene(visitor), OwnViews()
    first = views.of(jogged, None, view_of(states.idle))
    scene.show(None, first)
    at_hand = visitor.client.scene.get_handle_by_name("/plate").position
    assert np.linalg.norm(at_hand) > 0.1, "it is placed at the hand"
    assert "the plate as the suggestion assumes it" in mode_html(first)
    look = OwnLook(lambda: None)
    look.change(jog=jogged.jog, plate=jogged.plate)
    look.change(jog=None)
    assert look.now.plate is None
    after = views.of(look.now, first, view_of(states.idle))
    scene.show(first, after)
    assert visitor.client.scene.get_handle_by_name("/plate") is None
    assert "suggestion" not in mode_html(after)


def test_the_scanner_on_an_arm_goes_with_the_robot_that_is_jogged(view_of, visitor):
    cell = read_cell(find("robots", "tx2_90") / "on_arm.toml")
    carrier = cell.scanner.on_arm
    q = np.asarray(carrier.view.q) + 0.2
    own = Own(jog={cell.arms[0].name: q})
    first = OwnViews().of(own, None, view_of(State(cell)))
    scene = OwnScene(visitor)
    scene.show(None, first)
    drawn = visitor.client.scene.get_handle_by_name("/scanner").position
    assert np.allclose(drawn, scanner_pose(cell, q).translation, atol=1e-6)
