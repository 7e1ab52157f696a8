"""A plan as one file that plays it."""

import itertools

import pytest

import workbench.gui.page.recording
from workbench.gui.page.recording import FRAME, scene_html
from workbench.gui.scene.picture import ScenePicture


def test_a_recording_is_played_to_its_end(states, result, monkeypatch):
    times = []

    class Watched(ScenePicture):
        def draw(self, old, new):
            times.append(new.look.time)

    monkeypatch.setattr(workbench.gui.page.recording, "ScenePicture", Watched)
    assert b"<html" in scene_html(states.planned)
    assert times[0] == 0.0
    assert times[-1] == pytest.approx(result.plan.cycle_seconds)
    assert all(0 < b - a < FRAME * 1.01 for a, b in itertools.pairwise(times))
