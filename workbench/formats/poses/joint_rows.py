"""Joints of touches in a text file: a line each, as the pendant shows them."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from workbench.formats.files.whole_files import read_whole, write_whole
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import from_shown, shown_axes
from workbench.model.errors import FileError
from workbench.model.geometry import Floats

LARGEST_FILE = 100_000
"""[bytes]"""

ROUNDED = 1e-3
"""[rad, m] By which joints at a limit may be off."""


def read_joint_rows(path: Path, cell: Cell, arm: Arm) -> tuple[Floats, ...]:
    """Configurations (n,) [rad], chain order; `#` begins a remark.

    Raises:
        FileError: names file and line, and what was expected.
    """
    found: list[Floats] = []
    lower, upper, _ = cell.robot.limits(arm.joints)
    expected = f"{len(arm.joints)} joint values within the limits of {arm.name} are expected"
    lines = read_whole(path, LARGEST_FILE).decode(errors="replace").splitlines()
    for number, line in enumerate(lines, start=1):
        words = line.partition("#")[0].replace(",", " ").replace(";", " ").split()
        if not words:
            continue
        try:
            shown = np.array([float(word) for word in words])
        except ValueError:
            shown = np.empty(0)
        if len(shown) != len(arm.joints):
            raise FileError(path, f"line {number}: {expected}")
        q = from_shown(cell, arm, shown)
        if not np.all((q >= lower - ROUNDED) & (q <= upper + ROUNDED)):
            raise FileError(path, f"line {number}: {expected}")
        found.append(q)
    return tuple(found)


def write_joint_rows(path: Path, cell: Cell, arm: Arm, qs: Iterable[Floats]) -> None:
    """Write what `read_joint_rows` reads, of configurations (n,) [rad], chain order.

    Raises:
        FileError: it cannot be written.
    """
    rows = (", ".join(f"{value:.4f}" for value in shown_axes(cell, arm, q)) for q in qs)
    write_whole(path, "".join(f"{row}\n" for row in rows).encode())
