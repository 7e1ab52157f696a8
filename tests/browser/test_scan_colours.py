"""A scan with colours in a real browser: drawn by height, or as the scanner saw it."""

import io
from dataclasses import replace

import numpy as np
import pytest
from hands import settle
from PIL import Image
from playwright.sync_api import expect

from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import write_cloud
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture(scope="module")
def are_filled():
    """Colours are what is looked at here."""
    return True


def test_a_scan_with_colours_is_shown_in_them(screen, bench, reaches, wait, tmp_path):
    cell = read_cell("yumi")
    scan = synthesize(cell, drop_parts(cell.parts[:1] * 3, cell.bin, seed=2), seed=2)
    # A scanner that sees the left half green and the right one purple.
    is_left = scan.points[:, :1] < np.median(scan.points[:, 0])
    colours = np.where(is_left, (20, 170, 60), (150, 40, 170))
    write_cloud(tmp_path / "coloured.ply", replace(scan, colours=colours))
    screen.tab("Parts")
    box = screen.page.get_by_label("Colours of the scan")
    expect(box).to_be_hidden()
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Scan from file")
    chooser.value.set_files(tmp_path / "coloured.ply")
    reaches("scanned")
    expect(box).to_be_visible()
    settle(screen.page, 1000)
    before = painted(screen.page.screenshot())
    screen.shoot("parts-by-height")
    box.click()
    expect(box).to_be_checked()
    wait(lambda: min(painted(screen.page.screenshot())) > 2000, "green and purple points")
    screen.shoot("parts-in-colours")
    assert max(before) < 500
    box.click()
    wait(lambda: max(painted(screen.page.screenshot())) < 500, "the colours by height again")
    assert screen.errors == []


def painted(picture: bytes) -> tuple[int, int]:
    """How many pixels are green, and how many purple, of what a browser shows."""
    red, green, blue = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB"), int).T
    is_green = (green - red > 60) & (green - blue > 40)
    is_purple = (red - green > 60) & (blue - green > 60)
    return np.count_nonzero(is_green), np.count_nonzero(is_purple)
