"""Rows of numbers as text, as files of point clouds have them."""

import io
from collections.abc import Sequence
from itertools import chain, islice
from pathlib import Path

import numpy as np

from workbench.model.errors import FileError
from workbench.model.geometry import Floats
from workbench.model.messages.files import FileProblem


def read_rows(
    path: Path, content: bytes, start: int, *, columns: Sequence[int], count: int, skip: int = 0
) -> Floats:
    """Some columns of rows of numbers, shape (count, columns), no unit; blank lines do not count.

    Args:
        path: of the file, for messages.
        content: of the file.
        start: the byte with which the rows begin.
        columns: that are wanted, counted from 0.
        count: rows that are read; what follows is passed over.
        skip: rows before them.

    Raises:
        FileError: there are fewer rows, or one holds something else.
    """
    skip = min(skip, len(content))  # a header may promise more rows than a file can hold
    file = io.BytesIO(content)
    file.seek(start)
    filled = (line for line in file if not line.isspace())
    lines = islice(filled, skip, skip + count)
    first = next(lines, None)
    values = np.empty((0, len(columns)))
    if first is not None:  # NumPy warns of no lines at all
        try:
            values = np.loadtxt(chain([first], lines), comments=None, usecols=columns, ndmin=2)
        except ValueError as error:
            # NumPy counts from 0 and speaks of rows, which are the points of the file.
            raise FileError(path, f"a point is not a row of numbers: {str(error)[:200]}") from None
    if len(values) < count:
        detail = f"it declares {count} points and holds {len(values)}"
        raise FileError(path, FileProblem.CUT_OFF(detail=detail))
    return values
