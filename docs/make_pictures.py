"""Makes the pictures of the documents anew: `make pictures`.

The real page is driven in headless Chromium against the simulated YuMi cell; seeds are fixed.
Without arguments all pictures are made, otherwise those of the stories that are named. `points`
is none of the documents': it shows every point of the page's list, in `build/points/`.
"""

import os
import sys
import tempfile
from pathlib import Path

from more_stories import STORIES
from picture_tools import PICTURES, browser
from point_stories import points

NAMED = {**STORIES, "points": points}
"""Stories that can be asked for."""


def main(names: list[str]) -> None:
    """Go through the stories."""
    unknown = [name for name in names if name not in NAMED]
    if unknown:
        raise SystemExit(f"no story {unknown[0]}; there are {', '.join(NAMED)}")
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, browser() as chrome:
        for name in names or STORIES:
            own = Path(folder) / name
            own.mkdir()
            os.chdir(own)
            NAMED[name](chrome, own)
        os.chdir("/")


if __name__ == "__main__":
    main(sys.argv[1:])
