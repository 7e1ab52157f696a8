"""Which Chromium draws the pages of tests and the pictures of documents."""

import shutil

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser")
"""The first has no window, tabs or menus to draw where nobody sees them."""


def find_chromium() -> str | None:
    """The program, if one is installed."""
    return next(filter(None, map(shutil.which, NAMES)), None)
