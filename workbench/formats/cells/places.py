"""Places of a cell file: a pose of the tool, or one of the part that it lets go of."""

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import Table
from workbench.formats.meshes.solids import REACH_MM, read_pose
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import PartPlace

MOST_PLACES = 400
"""On one pallet."""

OF_TOOL = ("position_mm", "rpy_deg")

OF_PART = ("part_position_mm", "part_rpy_deg")

ABOUT_PART = ("part", "free_rotation_deg", "tolerance_mm", "tolerance_deg")
"""What can be said only where the pose is that of the part."""

FINEST_MM, FINEST_DEG = 1.0, 1.0
"""As exactly as a proof holds any hand to its place."""


def read_places(table: Table) -> tuple[tuple[pin.SE3, ...], tuple[PartPlace, ...]]:
    """The places of an arm: poses of the TCP, and places of parts, each in the file's order.

    Args:
        table: of the arm.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    of_tool: list[pin.SE3] = []
    of_part: list[PartPlace] = []
    for place in table.tables("place"):
        is_of_part = _is_of_part(place)
        T_tool, T_part, kind = read_pose(place), _part_pose(place), _kind(place)
        free = place.number("free_rotation_deg", 0, low=0, high=180)
        far = place.number("tolerance_mm", 2, low=FINEST_MM, high=50) / 1000
        turn = place.number("tolerance_deg", 3, low=FINEST_DEG, high=45)
        shifts = _grid(place)
        place.finish()
        if is_of_part:
            of_part += [
                PartPlace(T_part * T, kind, np.deg2rad(free), far, np.deg2rad(turn)) for T in shifts
            ]
        else:
            of_tool += [T_tool * T for T in shifts]
    return tuple(of_tool), tuple(of_part)


def check_kinds(table: Table, places: tuple[PartPlace, ...], known: list[str]) -> None:
    """Whether a cell picks the parts that its places are for.

    Raises:
        FileError: it does not; names the part and those there are.
    """
    for place in places:
        if not any(map(place.is_for, known)):
            raise table.error("arm.place.part", f"{place.part!r} is not one of {', '.join(known)}")


def _is_of_part(table: Table) -> bool:
    """Whether a place says how the part lies: of hand and part it may say one."""
    told = [key for key in OF_PART if table.has(key)]
    for key in OF_TOOL:
        if told and table.has(key):
            raise table.error(
                key, f"is the tool's pose, and {told[0]} that of the part: one is expected"
            )
    if told and not table.has(OF_PART[0]):
        raise table.error(OF_PART[0], f"is missing; it is expected beside {told[0]}")
    for key in ABOUT_PART:
        if not told and table.has(key):
            raise table.error(
                key, "is about where the part lies; part_position_mm is expected beside it"
            )
    return bool(told)


def _part_pose(table: Table) -> pin.SE3:
    xyz = table.numbers(OF_PART[0], 3, [0, 0, 0], low=-REACH_MM, high=REACH_MM) / 1000
    return pose_from_rpy(
        xyz, np.deg2rad(table.numbers(OF_PART[1], 3, [0, 0, 0], low=-360, high=360))
    )


def _kind(table: Table) -> str:
    """The kind that a place is for; empty: any."""
    kind = table.text("part", "", empty=True)
    if table.has("part") and not kind:
        raise table.error("part", "is an empty text")
    return kind


def _grid(table: Table) -> tuple[pin.SE3, ...]:
    """No shift, or those of a `grid` of columns along x and rows along y."""
    columns, rows = table.wholes("grid", 2, [1, 1], low=1, high=100)
    pitch = table.numbers("pitch_mm", 2, [0, 0], low=-5000, high=5000) / 1000
    if columns * rows > MOST_PLACES:
        raise table.error("grid", f"{columns * rows} places, {MOST_PLACES} are allowed")
    if (columns > 1 and pitch[0] == 0) or (rows > 1 and pitch[1] == 0):
        raise table.error("pitch_mm", "must not be 0 where there are several places")
    return tuple(
        pin.SE3(np.eye(3), np.array([column * pitch[0], row * pitch[1], 0.0]))
        for row in range(rows)
        for column in range(columns)
    )
