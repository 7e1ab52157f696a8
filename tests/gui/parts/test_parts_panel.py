"""The tab with the parts found: what is chosen stays chosen when others change the list."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.people import Person, Role
from workbench.app.runtime.live import Live
from workbench.gui.parts import panel as parts_panel
from workbench.gui.parts.panel import PartsPanel
from workbench.gui.shared.look import View
from workbench.gui.uploads.reading import FittedScanner
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection


@pytest.fixture
def panel(visitor, bench, scan, detections):
    """Before three parts, as drawn."""
    bench.do(UseScan(scan), "Ada")
    number = bench.do(FindParts(), "Ada").number
    third = Detection("keyed_cylinder", pose_from_rpy((0.4, 0.0, 0.1), (0.0, 0.0, 0.0)))
    bench.do(JobEnded(number, (*detections, third)), "worker")
    panel = PartsPanel(visitor)
    panel.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0))
    return panel


@pytest.fixture
def draw(panel, visitor, bench):
    """Draws what has become of it."""
    before = bench.state

    def show() -> None:
        nonlocal before
        old, before = before, bench.state
        views = (View(state, Live(), visitor.look.now, (), 0.0) for state in (old, before))
        panel.show(*views)

    return show


def marked(panel) -> list[bool]:
    return ["wb-chosen" in row for row in panel._table.content.split("<tr")[2:]]


def test_the_first_of_the_parts_found_is_chosen(panel):
    assert marked(panel) == [True, False, False]
    assert panel._visitor.own.now.part is panel._visitor.bench.state.detections[0]


def test_a_part_that_was_clicked_on_in_the_scene_is_chosen(panel, bench, draw):
    panel._visitor.own.change(pointed=bench.state.detections[2])
    draw()
    assert marked(panel) == [False, False, True]
    panel._choose(1)
    draw()
    assert marked(panel) == [False, True, False], "the click is not taken twice"
    panel._visitor.own.change(pointed=None)
    draw()
    assert marked(panel) == [False, True, False]


def test_a_choice_stays_with_its_part_when_somebody_else_vetoes_one_before_it(panel, bench, draw):
    _, second, third = bench.state.detections
    panel._choose(1)
    assert marked(panel) == [False, True, False]
    bench.do(UseDetections((second, third), "part-1 was vetoed"), "Bob")
    draw()
    assert marked(panel) == [True, False]
    panel._visitor.ask(panel._without)
    assert bench.state.detections == (third,)


def test_a_choice_goes_with_its_part(panel, visitor, bench, draw):
    first, _, third = bench.state.detections
    panel._choose(1)
    bench.do(UseDetections((first, third), "part-2 was vetoed"), "Bob")
    # Before it is drawn, too.
    assert not panel._correct(pose_from_rpy((0.4, 0.1, 0.1), (0.0, 0.0, 0.0)))
    assert visitor.client.told == ["choose a part in the table first"]
    draw()
    assert marked(panel) == [False, False]
    assert panel._veto.disabled and panel._inputs._apply.disabled
    assert bench.state.detections == (first, third)
    panel._choose(1)
    assert marked(panel) == [False, True]
    assert not panel._veto.disabled and not panel._inputs._apply.disabled


def test_a_row_that_was_drawn_is_the_part_that_is_meant(panel, visitor, bench):
    _, second, third = bench.state.detections
    bench.do(UseDetections((second, third), "part-1 was vetoed"), "Bob")
    panel._choose(1)
    panel._visitor.ask(panel._without)
    assert bench.state.detections == (third,)


def test_a_part_that_was_moved_or_added_is_chosen(panel, bench, draw):
    panel._choose(2)
    T = pose_from_rpy((0.4, 0.1, 0.1), (0.0, 0.0, 0.0))
    assert panel._correct(T)
    draw()
    assert marked(panel) == [False, False, True]
    np.testing.assert_allclose(bench.state.detections[2].T_world_part.translation, T.translation)
    panel._add_one()
    draw()
    assert marked(panel) == [False, False, False, True]


def test_what_is_refused_changes_no_choice(panel, visitor, bench, draw):
    visitor.person = Person("Bob", Role.OPERATOR)
    bench.do(TakeControl(), "Ada")
    panel._choose(1)
    panel._add_one()
    assert not panel._correct(pose_from_rpy((0.4, 0.1, 0.1), (0.0, 0.0, 0.0)))
    draw()
    assert marked(panel) == [False, True, False]


def test_colours_can_be_chosen_where_the_scan_has_some(panel, visitor, bench, draw, scan):
    assert not panel._scan_colours.visible
    colours = np.arange(scan.points.size).reshape(-1, 3) % 251
    bench.do(UseScan(replace(scan, colours=colours)), "Ada")
    draw()
    assert panel._scan_colours.visible and not panel._scan_colours.disabled
    assert not panel._scan_colours.value
    visitor.look.change(scan_colours=True)
    draw()
    assert panel._scan_colours.value, "somebody else has chosen them for all"
    bench.do(UseScan(scan), "Ada")
    draw()
    assert not panel._scan_colours.visible


def test_a_cell_that_was_changed_while_a_scanner_was_fitted_stays_as_it_is(
    panel, bench, scan, monkeypatch
):
    cell = bench.state.cell
    moved = replace(cell, bin=replace(cell.bin, T_world_bin=pose_from_rpy((0.5, 0.0, 0.0))))
    mount = replace(cell.scanner, depth_noise=0.0007)

    def fit(*_, **__):
        bench.do(ChangeCell(moved, "the bin is moved"), "Bob")
        return FittedScanner(mount, cell.bin, ())

    monkeypatch.setattr(parts_panel, "fitted_scanner", fit)
    monkeypatch.setattr(parts_panel, "sent_scan", lambda *_, **__: scan)
    with pytest.raises(CommandRefused, match="changed by somebody else"):
        panel._fitted("pile.ply", b"", lambda: False)
    assert bench.state.cell.digest == moved.digest
