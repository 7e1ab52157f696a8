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

RED, MAGENTA = (230, 40, 20), (230, 0, 200)

FEW, MANY = 10, 60
"""Pixels: of some 4000 points that are drawn not all are seen, each a pixel or two."""


@pytest.fixture
def are_filled():
    return True


@pytest.fixture
def sharpness():
    """Points are hardly larger than a pixel."""
    return 1.0


def test_a_scan_with_colours_is_shown_in_them(screen, bench, reaches, wait, tmp_path):
    cell = read_cell("yumi")
    scan = synthesize(cell, drop_parts(cell.parts[:1] * 3, cell.bin, seed=2), seed=2)
    # A scanner that sees the left half red and the right one magenta, as nothing on the page is.
    is_left = scan.points[:, :1] < np.median(scan.points[:, 0])
    colours = np.where(is_left, RED, MAGENTA)
    write_cloud(tmp_path / "coloured.ply", replace(scan, colours=colours))
    screen.tab("Parts")
    box = screen.page.get_by_label("Scan colours")
    expect(box).to_be_hidden()
    with screen.page.expect_file_chooser() as chooser:
        screen.press("Scan from file")
    chooser.value.set_files(tmp_path / "coloured.ply")
    reaches("scanned")
    expect(box).to_be_visible()
    settle(screen.page, 1000)
    assert max(painted(screen)) < FEW
    box.click()
    wait(lambda: min(painted(screen)) > MANY, "red and magenta points")
    assert box.is_checked()
    screen.shoot("parts-in-colours")
    box.click()
    wait(lambda: max(painted(screen)) < FEW, "the colours by height again")
    assert screen.errors == []


def painted(screen) -> tuple[int, int]:
    """How many pixels of the scene are red, and how many magenta."""
    canvas = screen.page.locator("canvas").first.bounding_box()
    picture = screen.page.screenshot(clip=canvas)
    drawn = np.asarray(Image.open(io.BytesIO(picture)).convert("RGB")).astype(int)
    red, magenta = (
        np.count_nonzero(np.abs(drawn - colour).max(axis=2) < 50) for colour in (RED, MAGENTA)
    )
    return red, magenta
