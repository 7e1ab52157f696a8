"""Pictures as PNG files, with numbers written into them."""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from workbench.formats.files.whole_files import write_whole

LETTERS = 22
"""[pixels] Height of the letters."""


def write_picture(
    path: Path, picture: np.ndarray, words: Sequence[tuple[tuple[float, float], str]] = ()
) -> None:
    """Write a PNG file.

    Args:
        path: of the file.
        picture: (rows, columns, 3) of bytes: red, green and blue, no unit.
        words: what is written where: the column and row of its middle [pixels].

    Raises:
        FileError: it cannot be written.
    """
    # It takes time to load, and few commands need it.
    from PIL import Image, ImageDraw, ImageFont

    image = Image.fromarray(np.ascontiguousarray(picture, np.uint8))
    draw, font = ImageDraw.Draw(image), ImageFont.load_default(LETTERS)
    for place, text in words:
        draw.text(
            place, text, fill="white", anchor="mm", font=font, stroke_width=3, stroke_fill="black"
        )
    held = io.BytesIO()
    image.save(held, "PNG")
    write_whole(path, held.getvalue())
