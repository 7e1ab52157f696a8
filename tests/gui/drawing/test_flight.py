"""The camera flies to what was chosen in a table, in the browser of who chose it."""

import threading
from contextlib import nullcontext
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.gui.drawing.flight import (
    FARTHEST_VIEW,
    FRAMES,
    NEAREST_VIEW,
    CameraFlight,
    camera_between,
    camera_near,
)
from workbench.gui.scene.stage import STAGE

POINT = np.array([0.4, 0.1, 0.05])
SEEN = np.array([2.0, 1.0, 1.5]), np.array([0.0, 0.0, 0.5])


class Camera(SimpleNamespace):
    """Notes each place that it was put at."""

    def __setattr__(self, name, value):
        super().__setattr__(name, value)
        if name == "look_at":
            self.__dict__.setdefault("ways", []).append((self.position, value))


@pytest.fixture
def camera(visitor):
    camera = Camera(position=SEEN[0], update_timestamp=1.0)
    camera.look_at = SEEN[1]
    camera.ways.clear()
    visitor.client.camera, visitor.client.atomic = camera, nullcontext
    visitor.__dict__["wants_less_motion"] = False
    return camera


def fly(visitor):
    CameraFlight(visitor).fly_to(POINT)
    for thread in threading.enumerate():
        if thread.name == "camera":
            thread.join()


@pytest.mark.parametrize("distance", [0.1, 0.5, 3.0])
def test_it_looks_along_the_same_direction_from_not_too_far(distance):
    away = np.array([0.6, 0.0, 0.8])
    position, centre = camera_near((SEEN[1] + away * distance, SEEN[1]), POINT)
    assert np.array_equal(centre, POINT)
    expected = min(max(distance, NEAREST_VIEW), FARTHEST_VIEW)
    np.testing.assert_allclose(position - centre, away * expected)


def test_it_begins_and_ends_gently():
    end = camera_near(SEEN, POINT)
    ways = [camera_between(SEEN, end, share)[0] for share in (0.0, 0.1, 0.5, 1.0)]
    steps = np.linalg.norm(ways - SEEN[0], axis=1) / np.linalg.norm(end[0] - SEEN[0])
    np.testing.assert_allclose(steps, [0.0, 0.028, 0.5, 1.0])


def test_it_arrives_over_some_pictures(visitor, camera):
    fly(visitor)
    assert len(camera.ways) == FRAMES
    np.testing.assert_allclose(camera.ways[-1], camera_near(SEEN, POINT))


def test_who_asks_for_little_motion_is_there_at_once(visitor, camera):
    visitor.__dict__["wants_less_motion"] = True
    fly(visitor)
    assert len(camera.ways) == 1
    np.testing.assert_allclose(camera.ways[-1], camera_near(SEEN, POINT))


def test_a_plan_that_is_played_and_a_part_that_stands_alone_are_not_left(visitor, camera):
    visitor.look.change(is_playing=True)
    fly(visitor)
    visitor.look.change(is_playing=False)
    visitor.client.scene.add_frame(STAGE)
    fly(visitor)
    visitor.client.scene.remove_by_name(STAGE)
    camera.update_timestamp = 0.0
    fly(visitor)
    assert camera.ways == [], "nor is a camera moved that was not heard of yet"
