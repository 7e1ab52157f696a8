"""Ways to look at the cell: what each holds, and from where."""

import math
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.gui.page.looks import DOUBLE_CLICK, KEYS, Looks, camera_of, centre_camera
from workbench.gui.scene.stage import STAGE
from workbench.gui.scene.surroundings import ASPECT, FIELD_OF_VIEW, first_look, interesting_points
from workbench.gui.shared.look import Look
from workbench.gui.shared.movable_frames import pose_of, things
from workbench.model.errors import InputError
from workbench.words.catalogs import LANGUAGES
from workbench.words.words import words_of


def seen(camera, points):
    """Whether all points (n, 3) [m] are in the picture."""
    position, centre = camera
    forward = (centre - position) / np.linalg.norm(centre - position)
    right = np.cross(forward, [0.0, 0.0, 1.0])
    right /= np.linalg.norm(right)
    x, y, z = np.stack([right, np.cross(right, forward), forward]) @ (points - position).T
    tangent = math.tan(FIELD_OF_VIEW / 2)
    return bool(
        np.all(z > 0) and np.all(abs(y) < tangent * z) and np.all(abs(x) < tangent * ASPECT * z)
    )


@pytest.mark.parametrize("name", ["Default view", "Top", "Front"])
def test_the_whole_cell_is_seen_from_everywhere(states, cell, name):
    assert seen(camera_of(name, states.idle, Look()), interesting_points(cell))


def test_each_look_is_from_where_it_says(states, cell):
    cameras = {name: camera_of(name, states.planned, Look(candidate=0)) for name in KEYS}
    np.testing.assert_allclose(cameras["Default view"], first_look(cell))
    steep = {
        name: (position - centre)[2] / np.linalg.norm(position - centre)
        for name, (position, centre) in cameras.items()
    }
    assert steep["Top"] > 0.99 and steep["Front"] < 0.2
    bin_middle = cell.bin.T_world_bin.translation
    assert np.linalg.norm(cameras["Bin"][1] - bin_middle) < 0.1
    tip = states.planned.candidates[0].T_world_tcp.translation
    assert np.linalg.norm(cameras["Selected"][1] - tip) < 0.05


def test_without_a_candidate_the_parts_are_selected_and_without_those_nothing(states):
    parts = [one.T_world_part.translation for one in states.planned.detections]
    assert seen(camera_of("Selected", states.planned, Look()), np.array(parts))
    with pytest.raises(InputError, match="nothing is selected"):
        camera_of("Selected", states.idle, Look())


def test_a_thing_that_was_chosen_is_selected_before_candidate_and_parts(states, cell):
    for thing in things(cell):
        camera = camera_of("Selected", states.planned, Look(candidate=0), thing)
        assert seen(camera, pose_of(cell, thing).translation[None]), thing
    by_bin = camera_of("Selected", states.idle, Look(), "bin")
    assert np.linalg.norm(by_bin[1] - cell.bin.T_world_bin.translation) < 0.1
    with pytest.raises(InputError, match="nothing is selected"):
        camera_of("Selected", states.idle, Look(), "a fixture that was taken away")


def test_what_is_clicked_twice_comes_into_the_middle_as_it_was_seen(visitor, states, view_of, cell):
    position, centre = first_look(cell)
    camera = SimpleNamespace(position=position, look_at=centre, update_timestamp=0.0)
    visitor.client.camera, visitor.client.atomic = camera, nullcontext
    looks = Looks(visitor)
    looks.show(view_of(states.idle))
    floor = cell.bin.T_world_bin.translation
    above, down = floor + np.array([0.02, 0.0, 0.5]), np.array([0.0, 0.0, -1.0])

    looks._take_click(above, down, 1.0)
    looks._take_click(above, down, 1.0 + 2 * DOUBLE_CLICK)
    looks._take_click(above, np.array([0.1, 0.0, -1.0]), 1.0 + 2.5 * DOUBLE_CLICK)
    assert np.array_equal(camera.position, position), "three single clicks"
    looks._take_click(above, np.array([0.1, 0.0, -1.0]), 1.0 + 3 * DOUBLE_CLICK)
    assert abs(camera.look_at[2] - floor[2]) < 0.01
    np.testing.assert_allclose(camera.position - camera.look_at, position - centre)
    before = camera.look_at
    for at in (9.0, 9.1):
        looks._take_click(above, -down, at)
    assert camera.look_at is before, "nothing lies there"


def test_a_click_on_a_part_chooses_it_and_one_beside_it_chooses_none(visitor, states, view_of):
    looks = Looks(visitor)
    looks.show(view_of(states.localized))
    found = states.localized.detections
    down = np.array([0.0, 0.0, -1.0])
    for number, part in enumerate(found):
        middle = states.localized.cell.part(part.part).mesh.middle
        above = part.T_world_part.act(middle) + np.array([0.0, 0.0, 0.5])
        looks._take_click(above, down, 10.0 * number)
        assert visitor.own.now.pointed is part
        looks._take_click(above, -down, 10.0 * number + 5.0)
        assert visitor.own.now.pointed is None
    visitor.client.scene.add_frame(STAGE)
    looks._take_click(above, down, 99.0)
    assert visitor.own.now.pointed is None, "the part stands alone"


def test_a_part_behind_the_floor_is_not_clicked_on(visitor, states, view_of):
    looks = Looks(visitor)
    looks.show(view_of(states.localized))
    part = states.localized.detections[0]
    below = part.T_world_part.translation - np.array([0.0, 0.0, 0.5])
    looks._take_click(below, np.array([0.0, 0.0, 1.0]), 1.0)
    assert visitor.own.now.pointed is None, "the floor of the bin is in front"


def test_a_centred_camera_is_moved_and_not_turned():
    camera = np.array([1.0, 2.0, 3.0]), np.array([0.0, 0.0, 0.5])
    position, centre = centre_camera(camera, np.array([0.2, 0.0, 0.0]))
    assert np.array_equal(centre, [0.2, 0.0, 0.0]) and np.allclose(position, [1.2, 2.0, 2.5])


def test_keys_leave_the_camera_alone_while_the_part_stands_alone(visitor, cell):
    position, centre = first_look(cell)
    camera = SimpleNamespace(position=position, look_at=centre, up_direction=None)
    visitor.client.camera, visitor.client.atomic = camera, nullcontext
    looks = Looks(visitor)
    visitor.client.scene.add_frame(STAGE)
    looks._type("Top")
    assert camera.position is position
    visitor.client.scene.remove_by_name(STAGE)
    looks._type("Top")
    assert camera.position is not position


@pytest.mark.parametrize("language", LANGUAGES)
def test_no_look_is_called_what_the_rest_of_a_robot_is_called(language):
    words = words_of(language)
    home = words.say("home").casefold()
    assert [name for name in KEYS if home in words.say(name).casefold()] == []
