"""What the page says of the scan step."""

from dataclasses import replace

import pytest

from workbench.gui.shared import views


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
