"""What a candidate can be looked at in."""

import numpy as np
import pytest

from workbench.gui.drawing.poses import PoseFinder
from workbench.model.candidate import Reason


@pytest.fixture(scope="module")
def finder() -> PoseFinder:
    return PoseFinder()


def test_a_good_candidate_shows_its_way_and_its_spare_freedom(finder, states, result):
    good = next(one for one in result.candidates if one.verdict.is_ok)
    poses = finder.poses(states.planned, good)
    assert [pose.label for pose in poses[:4]] == ["pre-grasp", "grasp", "lifted", "place"]
    elbows = [pose for pose in poses if "elbow" in pose.label]
    assert len(elbows) > 5
    assert any(np.allclose(pose.q, poses[1].q) and pose.note.startswith("clear") for pose in elbows)
    assert all((pose.note.startswith("clear")) == (not pose.meets) for pose in poses)


def test_a_refused_candidate_shows_where_it_failed_and_what_meets(finder, states, result):
    refused = [one for one in result.candidates if one.verdict.q is not None]
    for one in refused:
        (pose,) = finder.poses(states.planned, one)
        assert np.array_equal(pose.q, one.verdict.q)
        assert str(one.verdict.reason) in pose.note
        if one.verdict.pair is not None:
            assert len(pose.meets) >= 2


def test_what_fell_before_any_configuration_has_no_pose(finder, states, result):
    fell = next(one for one in result.candidates if one.verdict.reason is Reason.TOOL_COLLISION)
    assert finder.poses(states.planned, fell) == ()
