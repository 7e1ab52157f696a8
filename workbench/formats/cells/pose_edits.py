"""Poses and lengths written into the tables that people wrote: only what differs."""

from typing import Any

import numpy as np
import pinocchio as pin

from workbench.formats.cells.places import OF_TOOL
from workbench.formats.files.toml_documents import millimetres, shorts

LOST = 2e-6
"""[m, rad] That much a number may change by being written with four digits [mm, deg]."""


def edit_pose(table: Any, old: pin.SE3, new: pin.SE3, keys: tuple[str, str] = OF_TOOL) -> Any:
    """Write a pose into a table if it is another one than before; the table."""
    if not np.array_equal(old.translation, new.translation):
        table[keys[0]] = millimetres(new.translation)
    if not np.array_equal(old.rotation, new.rotation):
        rpy = np.rad2deg(pin.rpy.matrixToRpy(new.rotation))
        table[keys[1]] = shorts(rpy)
    return table
