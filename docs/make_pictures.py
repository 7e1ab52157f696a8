"""Makes the pictures of the documents anew: `make pictures`.

The real page is driven in headless Chromium against the simulated YuMi cell; seeds are fixed.
Without arguments all pictures are made, otherwise those of the stories that are named.
"""

import os
import sys
import tempfile
from pathlib import Path

from more_stories import STORIES
from picture_tools import PICTURES, browser


def main(names: list[str]) -> None:
    """Go through the stories."""
    unknown = [name for name in names if name not in STORIES]
    if unknown:
        raise SystemExit(f"no story {unknown[0]}; there are {', '.join(STORIES)}")
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder, browser() as chrome:
        for name in names or STORIES:
            own = Path(folder) / name
            own.mkdir()
            os.chdir(own)
            STORIES[name](chrome, own)
        os.chdir("/")


if __name__ == "__main__":
    main(sys.argv[1:])
