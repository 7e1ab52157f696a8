"""Every tab, in both themes and three sizes, looks as it did when somebody last looked at it.

`WORKBENCH_GOLDEN=write pytest tests/browser/test_pictures.py` keeps what is seen now in
`tests/browser/pictures/`, a sheet for each theme and size: look at them before they are committed.
"""

import io
import os
import shutil
import time
from itertools import combinations, product
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from readable import unreadable

from workbench.app.records.sessions import cell_of
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal

ROOT = Path(__file__).resolve().parents[2]
KEPT = Path(__file__).with_name("pictures")
IS_WRITING = os.environ.get("WORKBENCH_GOLDEN") == "write"

TABS = ("Cycle", "Parts", "Candidates", "Plan", "Robot")
TABS += ("Grasps", "Cell", "Emptying", "Calibration", "Statistics")
THEMES, SIZES = ("light", "dark"), ((1280, 720), (1440, 900), (1920, 1080))

SMALLER, ABREAST = 2, 5
"""A kept picture is half as wide and high as the page; so many stand beside each other."""

REGION = 10
"""Kept pixels of the side of a region: of the page 20, about a line of text."""

TOLERANCE = 12
"""[of 255] By so much the mean colour of a region may differ: other letters may, lines may not."""

FINE, MIDDLE = 0xF8, 0x04
"""Bits of a colour that are kept, and what stands for the others."""

STILL, KEPT_STILL = 30.0, 3.0
"""[s] A page that has not changed for so long is as it is, when compared and when kept."""

ENOUGH = 5
"""So many pictures that differ are told; looking at the others would take long."""

UNSEEN = """
canvas, .mantine-ScrollArea-scrollbar { visibility: hidden !important; }
* { transition: none !important; animation: none !important; caret-color: transparent !important; }
"""
"""What WebGL draws is not compared, nor what is on its way to where it will be, nor bars that come
and go as the mouse does."""


@pytest.fixture(scope="module", autouse=True)
def in_utc():
    """Times are shown where one is; browsers are told before they start."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TZ", "UTC")
        time.tzset()
        yield
    time.tzset()


@pytest.fixture
def bench(tmp_path):
    """With the session that is shipped: whatever is told was found when it was recorded."""
    journal = Journal(shutil.copytree(ROOT / "sessions" / "example", tmp_path / "example"))
    bench = Bench(cell_of(journal), journal)
    yield bench
    bench.close()


@pytest.fixture
def sharpness():
    return 1.0


def test_every_tab_looks_as_it_did(screen, shots):
    page, differing = screen.page, []
    page.add_style_tag(content=UNSEEN)
    assert tuple(tab.inner_text() for tab in page.get_by_role("tab").all()) == TABS
    for theme, (width, height) in product(THEMES, SIZES):
        if page.locator(f':root[data-mantine-color-scheme="{theme}"]').count() == 0:
            page.mouse.move(200, 400)
            page.keyboard.press("l")
            page.locator(f':root[data-mantine-color-scheme="{theme}"]').wait_for()
        page.set_viewport_size({"width": width, "height": height})
        kept = None if IS_WRITING else pictures_of(theme, width, height)
        seen = []
        for number, tab in enumerate(TABS):
            screen.tab(tab)
            seen.append(looked_at(page, None if kept is None else kept[number]))
            if kept is None or not (regions := changed(seen[-1], kept[number])):
                continue
            left, top, right, bottom = (
                SMALLER
                * REGION
                * np.array([*np.min(regions, axis=0), *np.max(regions, axis=0) + 1])
            )
            differing.append(
                f"{tab}, {theme}, {width} x {height}: {len(regions)} regions, "
                f"x {left} to {right}, y {top} to {bottom}"
            )
            Image.fromarray(seen[-1]).save(shots / f"differs-{theme}-{width}-{tab}.png")
            assert len(differing) < ENOUGH, differing
        if kept is None:
            keep(seen, theme, width)
    assert not differing


@pytest.mark.parametrize("theme", THEMES)
def test_every_text_is_large_and_dark_enough_to_be_read(screen, theme):
    page = screen.page
    if theme == "dark":
        page.mouse.move(200, 400)
        page.keyboard.press("l")
        page.locator(':root[data-mantine-color-scheme="dark"]').wait_for()
    for tab in TABS:
        screen.tab(tab)
        page.wait_for_timeout(500)
        assert unreadable(page) == [], tab


def test_no_two_tabs_look_alike():
    for theme, (width, height) in product(THEMES, SIZES):
        kept = pictures_of(theme, width, height)
        assert len(kept) == len(TABS)
        assert all(changed(one, other) for one, other in combinations(kept, 2))
    light, dark = (pictures_of(theme, *SIZES[0])[0] for theme in THEMES)
    # A step further down, as when a line has become two.
    assert changed(light, np.roll(light, REGION, axis=0))
    assert len(changed(light, dark)) > light.shape[0] * light.shape[1] / REGION**2 / 2


def looked_at(page, kept):
    """What is seen once it is as kept, or once it stands still."""
    before, since = None, time.monotonic()
    patience = KEPT_STILL if kept is None else STILL
    while True:
        content = page.screenshot()
        picture = Image.open(io.BytesIO(content)).convert("RGB")
        seen = np.asarray(picture.reduce(SMALLER))
        if kept is not None and not changed(seen, kept):
            return seen
        if content != before:
            before, since = content, time.monotonic()
        elif time.monotonic() - since >= patience:
            return seen
        page.wait_for_timeout(200)


def changed(one, other):
    """Where, in regions from the left and the top, two pictures (h, w, 3) differ.

    A pixel up or down is no difference: a row's place is rounded as it comes out, which depends on
    what was there when it was laid out.
    """
    assert one.shape == other.shape
    mean = means(one)
    moved = [means(np.roll(other, step, axis=0)) for step in (-1, 0, 1)]
    apart = np.min([np.abs(mean - each).max(axis=2) for each in moved], axis=0)
    return [(int(x), int(y)) for y, x in np.argwhere(apart > TOLERANCE)]


def means(picture):
    """The mean colours of a picture's regions."""
    height, width = (REGION * (size // REGION) for size in picture.shape[:2])
    shape = (height // REGION, REGION, width // REGION, REGION, 3)
    return picture[:height, :width].reshape(shape).mean(axis=(1, 3))


def sheet(theme, width):
    return KEPT / f"{theme}-{width}.webp"


def keep(seen, theme, width):
    """Write pictures (h, w, 3) as one sheet."""
    rows = [np.hstack(seen[k : k + ABREAST]) for k in range(0, len(seen), ABREAST)]
    KEPT.mkdir(exist_ok=True)
    # Without loss, but for what no eye sees: otherwise what is red would not be where it is.
    whole = np.vstack(rows) & FINE | MIDDLE
    Image.fromarray(whole).save(sheet(theme, width), lossless=True, quality=100, method=6)


def pictures_of(theme, width, height):
    """The pictures (h, w, 3) of a sheet."""
    with Image.open(sheet(theme, width)) as file:
        whole = np.asarray(file.convert("RGB"))
    w, h = width // SMALLER, height // SMALLER
    assert whole.shape == (h * len(TABS) // ABREAST, w * ABREAST, 3)
    places = (divmod(k, ABREAST) for k in range(len(TABS)))
    return [whole[y * h : (y + 1) * h, x * w : (x + 1) * w] for y, x in places]
