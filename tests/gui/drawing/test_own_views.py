"""A pose of a calibration is chosen by its number, which may come to be another one's."""

from types import SimpleNamespace

import pytest

from workbench.gui.drawing.own_views import has_lost_observation
from workbench.gui.shared.own import Own


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
