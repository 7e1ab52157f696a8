"""The stage of grasps: who draws on it, and when that ends."""

import threading

import pytest

from workbench.gui.grasps.panel import GraspsPanel
from workbench.gui.scene.stage import GraspStage
from workbench.model.part import grasps_of


def test_the_thread_that_looks_at_grasps_ends_with_the_controls(visitor):
    panel = GraspsPanel(visitor)
    panel._end_drawing()
    panel._draw()
    with pytest.raises(RuntimeError):
        panel._looker.submit(print)


def test_the_stage_is_drawn_on_by_one_thread_at_a_time(visitor, monkeypatch):
    panel = GraspsPanel(visitor)
    entered, left = [], []

    def draw_on(self, *args):
        entered.append(1)
        # Whoever draws meanwhile waits.
        thread = threading.Thread(target=lambda: (panel._draw(), left.append(1)), daemon=True)
        thread.start()
        thread.join(0.2)
        assert not left
        monkeypatch.undo()

    monkeypatch.setattr(GraspStage, "open", draw_on)
    panel._turn()
    monkeypatch.setattr(GraspStage, "is_open", True)
    monkeypatch.setattr(GraspStage, "show_tool", draw_on)
    left.clear()
    panel._preview(grasps_of(panel._editing.entry)[0])
    assert len(entered) == 2
