"""What the page says of the scan step."""

from dataclasses import replace

import pytest

from workbench.gui.shared import views
from workbench.model.robot import ScannedView


@pytest.mark.parametrize(
    ("source", "word"),
    [
        ("simulated", "simulated bin"),
        ("folder", "folder"),
        ("http", "address"),
        ("merged", "each"),
        ("else", "cell"),
    ],
)
def test_a_scan_is_told_as_the_scanner_takes_it(states, source, word):
    cell = states.idle.cell
    mount = replace(cell.scanner, source=source, address="somewhere")
    told = views.scan_line(replace(states.idle, cell=replace(cell, scanner=mount)))
    assert word in told and ("simulated" in told) == (source == "simulated")


def test_a_view_that_does_not_fit_the_others_stays_said_beside_the_scan(states):
    state = states.planned
    pose = state.scan.T_world_scanner
    few, rest = 100, len(state.scan.points) - 100
    fits = (ScannedView("high", few, pose, 0.001), ScannedView("low", rest, pose))
    off = (replace(fits[0], shift=0.004, turn=0.01), fits[1])
    told = [
        views.scan_line(replace(state, scan=replace(state.scan, views=each)))
        for each in (fits, off)
    ]
    assert "does not fit" not in told[0] and "wb-bad" not in told[0]
    assert "view high does not fit the others: 4.0 mm and 0.6 deg off, 0.0% looked" in told[1]
    assert "wb-bad" in told[1]


@pytest.mark.parametrize("name", ["localized", "planned", "approved"])
def test_parts_that_came_without_a_scan_tick_neither_the_scan_nor_the_search(states, name):
    state = replace(getattr(states, name), scan=None)
    assert views.strip_html(state).count('class="wb-done"') == views.REACHED[state.phase] - 2
    told = views.parts_line(state)
    assert "no scan: 2 parts placed by hand or from outside" in told
    assert "score" not in told
