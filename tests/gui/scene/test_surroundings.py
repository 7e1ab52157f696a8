"""The first look at a cell."""

import math
from unittest.mock import Mock

import numpy as np
from bending import with_nests
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from workbench.gui.scene.surroundings import frame_camera, interesting_points, show_frames
from workbench.planning.kinematics.robot import Kinematics

coordinates = st.floats(-2, 2)


@given(
    points=arrays(float, (7, 3), elements=coordinates),
    azimuth=st.floats(0, 2 * math.pi),
    aspect=st.floats(0.5, 3),
)
def test_the_camera_holds_all_points_and_is_no_further_away_than_needed(points, azimuth, aspect):
    points = points + np.arange(21).reshape(7, 3) * 0.01
    direction = np.array([math.cos(azimuth), math.sin(azimuth), 0.6])
    direction /= np.linalg.norm(direction)
    field_of_view = math.radians(40)
    position, _ = frame_camera(points, direction, field_of_view, aspect)
    right = np.cross([0, 0, 1], direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    depth = -(points - position) @ direction
    half = math.tan(field_of_view / 2) * depth
    filled = np.maximum(
        np.abs((points - position) @ up) / half,
        np.abs((points - position) @ right) / (half * aspect),
    )
    assert np.all(depth > 0)
    assert 0.8 < filled.max() < 0.9


def test_bin_scanner_and_places_belong_to_the_first_look(cell):
    points = interesting_points(cell)
    for T in (cell.scanner.T_world_scanner, *cell.arms[0].Ts_world_place):
        assert np.linalg.norm(points - T.translation, axis=1).min() < 0.15


def test_with_the_frames_parts_are_shown_where_they_shall_lie(cell):
    nests, scene = with_nests(cell), Mock()
    show_frames(scene, nests, Kinematics(nests), is_shown=True)
    labels = {call.args[0]: call.args[1] for call in scene.add_label.call_args_list}
    drawn = [call.args[0] for call in scene.add_mesh_simple.call_args_list]
    said = [labels[name.replace("/part", "/label")] for name in drawn]
    assert said == ["right part-place 1", "left part-place 1"]
    assert np.linalg.norm(interesting_points(nests) - [0.33, 0.33, 0.13], axis=1).min() < 0.15
