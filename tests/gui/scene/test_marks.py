"""Pins of the parts found: apart from each other, upright, and the chosen one larger."""

from contextlib import nullcontext
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from workbench.gui.drawing.own_scene import OwnScene
from workbench.gui.scene.marks import PIN_SPACING, PIN_STEP, draw_chosen, pin_heights
from workbench.gui.scene.picture import ScenePicture
from workbench.gui.shared.own import Own
from workbench.gui.shared.viser_server import close_viser, open_viser


@pytest.fixture
def server():
    server = open_viser("127.0.0.1", 0)
    yield server
    close_viser(server)


@given(arrays(float, st.tuples(st.integers(0, 12), st.just(3)), elements=st.floats(0.0, 0.08)))
def test_no_label_of_a_part_lies_on_that_of_a_part_near_it(tops):
    heights = pin_heights(tops)
    assert np.all(heights > tops[:, 2])
    for number, top in enumerate(tops):
        near = np.linalg.norm(tops[:, :2] - top[:2], axis=1) < PIN_SPACING
        near[number] = False
        assert np.all(np.abs(heights[near] - heights[number]) > PIN_STEP - 1e-9)


def test_pins_of_a_heap_end_in_the_order_of_its_parts():
    heights = pin_heights(np.array([[0.0, 0.0, z] for z in (0.01, 0.02, 0.021)]))
    assert all(low < high for low, high in pairwise(heights))


def test_a_pin_stands_upright_on_the_part_that_turns(server, cell, states, view_of):
    scene = server.scene
    ScenePicture(server, cell, most_points=500).draw(None, view_of(states.planned))
    for number, detection in enumerate(states.planned.detections, 1):
        name = f"/parts/part-{number}/pin"
        w, x, y, z = scene.get_handle_by_name(name).wxyz
        R_part_pin = pin.Quaternion(w, x, y, z).matrix()
        np.testing.assert_allclose(
            detection.T_world_part.rotation @ R_part_pin, np.eye(3), atol=1e-6
        )
        assert scene.get_handle_by_name(f"{name}/label").text == str(number)
        assert scene.get_handle_by_name(f"{name}/label").depth_test


def test_the_chosen_part_alone_has_a_larger_number(server, states, view_of):
    scene = server.scene
    first, second = (
        replace(view_of(states.localized), own=Own(part=part))
        for part in states.localized.detections
    )
    labels = [f"/parts/part-{number}/pin/label" for number in (1, 2)]
    draw_chosen(scene, None, first)
    assert scene.get_handle_by_name(labels[0]).font_screen_scale > 1.0
    draw_chosen(scene, first, second)
    assert scene.get_handle_by_name(labels[0]) is None
    assert scene.get_handle_by_name(labels[1]).text == "2"
    draw_chosen(scene, second, replace(second, own=Own()))
    assert scene.get_handle_by_name(labels[1]) is None


def test_the_larger_number_goes_with_the_controls_that_chose_it(visitor, states, view_of):
    visitor.client.atomic = nullcontext
    scene, name = visitor.client.scene, "/parts/part-1/pin/label"
    own = Own(part=states.localized.detections[0])
    OwnScene(visitor).show(None, replace(view_of(states.localized), own=own))
    assert scene.get_handle_by_name(name) is not None
    # A fix that is applied to the cell has the controls made anew.
    visitor.end(is_gone=False)
    assert scene.get_handle_by_name(name) is None
