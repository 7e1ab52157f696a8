"""Where parts lie by a cell file: bins, places by a pose of tool or part, and stations."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, product

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import Table
from workbench.formats.meshes.solids import REACH_MM, read_pose
from workbench.model.cell import Fixture
from workbench.model.derived.by_bin import MOST_BINS, overlapping
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.part import DOWN, Bin, PartPlace, Region, Station

MOST_PLACES = 400
"""On one pallet."""

UPRIGHT = np.deg2rad(0.5)
"""[rad] How far the z of a part may be off the vertical where parts lie in layers."""

OF_TOOL = ("position_mm", "rpy_deg")

OF_PART = ("part_position_mm", "part_rpy_deg")

ABOUT_PART = (
    *("part", "free_rotation_deg", "tolerance_mm", "tolerance_deg", "approach"),
    *("centred_mm", "centred_deg"),
)
"""What can be said only where the pose is that of the part."""

MOST_TILTED, SAME_HEIGHT = np.deg2rad(0.5), 0.05
"""[rad, m] How far a station may be tilted; stations farther apart in height are not compared."""

FINEST_MM, FINEST_DEG = 1.0, 1.0
"""As exactly as a proof holds any hand to its place."""


def read_places(
    table: Table,
) -> tuple[tuple[pin.SE3, ...], tuple[PartPlace, ...], tuple[str, ...]]:
    """The places of an arm: poses of the TCP, and places of parts, each in the file's order.

    Names of the poses come third, empty where nobody has named one.

    Args:
        table: of the arm.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    of_tool: list[pin.SE3] = []
    of_part: list[PartPlace] = []
    names: list[str] = []
    pallets = 0
    for place in table.tables("place"):
        is_of_part = _is_of_part(place)
        T_tool, T_part, kind = read_pose(place), _part_pose(place), _kind(place)
        free = place.number("free_rotation_deg", 0, low=0, high=180)
        far = place.number("tolerance_mm", 2, low=FINEST_MM, high=50) / 1000
        turn = place.number("tolerance_deg", 3, low=FINEST_DEG, high=45)
        approach, name = read_direction(place, "approach", DOWN), place.text("name", "", empty=True)
        centred = _centred(place)
        shifts, layers, height = _grid(place)
        if layers > 1:
            _check_layers(place, is_of_part, T_part)
            pallets += 1
        place.finish()
        if is_of_part:
            part_place = PartPlace(
                *(T_part, kind, np.deg2rad(free), far, np.deg2rad(turn), approach),
                name=name,
                centred=centred,
            )
            for layer, T in product(range(layers), shifts):
                up = np.array([0.0, 0.0, layer * height])
                T_world_part = pin.SE3(T_part.rotation, (T_part * T).translation + up)
                pallet = pallets if layers > 1 else 0
                of_part.append(
                    replace(part_place, T_world_part=T_world_part, pallet=pallet, layer=layer + 1)
                )
        else:
            of_tool += [T_tool * T for T in shifts]
            names += [name] * len(shifts)
    return tuple(of_tool), tuple(of_part), tuple(names) if any(names) else ()


def _centred(place: Table) -> tuple[float, float] | None:
    """What a nest leaves of the error of a part [m, rad]; None where nothing centres it."""
    keys = ("centred_mm", "centred_deg")
    if not any(map(place.has, keys)):
        return None
    for key in keys:
        if not place.has(key):
            raise place.error(key, "is missing; a place that centres parts needs both")
    shift, turn = (place.number(key, 0.1, low=0, high=10) for key in keys)
    return shift / 1000, float(np.deg2rad(turn))


def check_kinds(table: Table, places: tuple[PartPlace, ...], known: list[str]) -> None:
    """Whether a cell picks the parts that its places are for.

    Raises:
        FileError: it does not; names the part and those there are.
    """
    for place in places:
        if not any(map(place.is_for, known)):
            raise table.error("arm.place.part", f"{place.part!r} is not one of {', '.join(known)}")


def read_stations(table: Table, fixtures: Sequence[Fixture]) -> tuple[Station, ...]:
    """The stations of a cell, none of them in another one.

    Args:
        table: of the cell.
        fixtures: that they may belong to.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    poses = {known_fixture.name: known_fixture.T_world_fixture for known_fixture in fixtures}
    found: list[Station] = []
    where: list[pin.SE3] = []
    for station_table in table.tables("station"):
        name, fixture = station_table.text("name"), station_table.text("fixture", "", empty=True)
        if fixture and fixture not in poses:
            known = ", ".join(poses) or "none"
            raise station_table.error(
                "fixture", f"{fixture!r:.60} is no fixture of the cell: {known}"
            )
        size = station_table.numbers("size_mm", 2, low=10, high=5000) / 1000
        station = Station(name, read_pose(station_table), size, fixture)
        where.append(poses.get(fixture, pin.SE3.Identity()) * station.T_base_station)
        if where[-1].rotation[2, 2] < np.cos(MOST_TILTED):
            raise station_table.error(
                "rpy_deg", "does not lie level, so that parts would slide or roll off"
            )
        station_table.finish()
        found.append(station)
    table.once("station.name", (station.name for station in found))
    for (station, T), (other, U) in combinations(zip(found, where, strict=True), 2):
        if _share_room(T.actInv(U), station.size, other.size):
            raise table.error("station", f"{station.name} and {other.name} lie over each other")
    return tuple(found)


def _share_room(T: pin.SE3, size: Floats, other: Floats) -> bool:
    """Whether two surfaces (2,) [m] are at one height and overlap, the other at T in the first."""
    if abs(T.translation[2]) > SAME_HEIGHT:
        return False
    signs = np.array([(1, 1), (1, -1), (-1, -1), (-1, 1)]) / 2
    mine = signs * size
    theirs = (signs * other) @ T.rotation[:2, :2].T + T.translation[:2]
    axes = np.vstack([np.eye(2), T.rotation[:2, :2].T])
    a, b = mine @ axes.T, theirs @ axes.T
    apart = (a.max(axis=0) <= b.min(axis=0)) | (b.max(axis=0) <= a.min(axis=0))
    return not apart.any()


def _is_of_part(table: Table) -> bool:
    """Whether a place says how the part lies: of hand and part it may say one."""
    keys = [key for key in OF_PART if table.has(key)]
    for key in OF_TOOL:
        if keys and table.has(key):
            raise table.error(
                key, f"is the tool's pose, and {keys[0]} that of the part: one is expected"
            )
    if keys and not table.has(OF_PART[0]):
        raise table.error(OF_PART[0], f"is missing; it is expected beside {keys[0]}")
    for key in ABOUT_PART:
        if not keys and table.has(key):
            raise table.error(
                key, "is about where the part lies; part_position_mm is expected beside it"
            )
    return bool(keys)


def _part_pose(table: Table) -> pin.SE3:
    xyz = table.numbers(OF_PART[0], 3, [0, 0, 0], low=-REACH_MM, high=REACH_MM) / 1000
    return pose_from_rpy(
        xyz, np.deg2rad(table.numbers(OF_PART[1], 3, [0, 0, 0], low=-360, high=360))
    )


def read_direction(
    table: Table, key: str, default: tuple[float, float, float]
) -> tuple[float, float, float]:
    """A unit direction of a key, which may state it with any length but 0.

    Raises:
        FileError: it has no length, or is none.
    """
    direction = table.numbers(key, 3, list(default), low=-1000, high=1000)
    length = float(np.linalg.norm(direction))
    if length < 1e-6:
        raise table.error(key, "has no length; a direction like [1, 0, 0] is expected")
    x, y, z = (float(v) for v in direction / length + 0.0)
    return x, y, z


def _kind(table: Table) -> str:
    """The kind that a place is for; empty: any."""
    kind = table.text("part", "", empty=True)
    if table.has("part") and not kind:
        raise table.error("part", "is an empty text")
    return kind


def _grid(table: Table) -> tuple[tuple[pin.SE3, ...], int, float]:
    """The shifts within a layer of a `grid`, how many layers there are, and how high [m] one is.

    Columns run along x and rows along y; where there is no grid there is one shift, by nothing.
    """
    grid = table.wholes("grid", (2, 3), [1, 1], low=1, high=100)
    usual = [0] * len(grid)
    pitch = table.numbers("pitch_mm", (2, 3), usual, low=-5000, high=5000) / 1000
    if len(pitch) != len(grid):
        raise table.error(
            "pitch_mm", f"{len(grid)} numbers are expected, as many as grid has; {len(pitch)} are"
        )
    columns, rows, layers = (*grid, 1)[:3]
    if columns * rows * layers > MOST_PLACES:
        raise table.error("grid", f"{columns * rows * layers} places, {MOST_PLACES} are allowed")
    if (columns > 1 and pitch[0] == 0) or (rows > 1 and pitch[1] == 0):
        raise table.error("pitch_mm", "must not be 0 where there are several places")
    if layers > 1 and pitch[2] <= 0:
        raise table.error(
            "pitch_mm",
            f"the third number is how far each layer is above the one below: {pitch[2] * 1000:g} "
            "is not above 0",
        )
    shifts = tuple(
        pin.SE3(np.eye(3), np.array([column * pitch[0], row * pitch[1], 0.0]))
        for row in range(rows)
        for column in range(columns)
    )
    return shifts, layers, float((*pitch, 0.0)[2])


def _check_layers(table: Table, is_of_part: bool, T_part: pin.SE3) -> None:
    """Whether parts can be put onto each other at a place: it says how they lie, and level."""
    if not is_of_part:
        raise table.error(
            "grid",
            "has layers, and the place is a pose of the tool: only part_position_mm says how a "
            "part lies, and so what the next one stands on",
        )
    off = float(np.arccos(np.clip(abs(T_part.rotation[2, 2]), 0.0, 1.0)))
    if off > UPRIGHT:
        raise table.error(
            OF_PART[1],
            f"turns z of the part {np.rad2deg(off):.1f} degrees off the vertical; layers need it "
            "up or down",
        )


def read_bins(table: Table) -> tuple[Bin, ...]:
    """The bins of a cell; parts are taken from the first one unless another is chosen.

    Args:
        table: of the cell.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    if not table.is_array("bin"):
        return (read_bin(table.table("bin")),)
    tables = list(table.tables("bin"))
    if not 1 <= len(tables) <= MOST_BINS:
        raise table.error("bin", f"{len(tables)} bins, 1 to {MOST_BINS} are expected")
    bins = tuple(read_bin(one, number) for number, one in enumerate(tables, start=1))
    if len(bins) == 1:
        return (replace(bins[0], number=0),)
    for one, found in zip(tables, bins, strict=True):
        if not found.name:
            raise one.error("name", "is missing; each of several bins needs a name of its own")
    table.once("bin.name", (found.name for found in bins))
    if pair := overlapping(bins):
        raise table.error("bin", f"{pair[0]!r} and {pair[1]!r} overlap; bins stand apart")
    return bins


def read_bin(table: Table, number: int = 0) -> Bin:
    """The table of a bin with its regions."""
    found = Bin(
        read_pose(table),
        table.numbers("size_mm", 3, low=10, high=5000) / 1000,
        table.number("wall_mm", 3, low=0.5, high=100) / 1000,
        table.flag("walls", True),
        tuple(_region(region) for region in table.tables("region")),
        table.text("name", "", empty=True),
        number,
        _drop_place(table),
    )
    table.once("region.name", (region.name for region in found.regions))
    for region in found.regions:
        x, y, z = np.abs(region.T_bin_region.translation)
        if x > found.size[0] / 2 or y > found.size[1] / 2 or z > found.size[2]:
            raise table.error(
                "region.position_mm",
                f"the middle of region {region.name!r} lies outside of the bin; it is counted from "
                "the middle of the bin's floor",
            )
    table.finish()
    return found


def _drop_place(table: Table) -> tuple[float, ...] | None:
    """Where (3,) [m] in the world the TCP is as a hand drops back what it holds, if stated."""
    place = table.numbers("drop_back_mm", 3, [0.0] * 3, low=-10_000, high=10_000) / 1000
    return tuple(place.tolist()) if table.has("drop_back_mm") else None


def _region(table: Table) -> Region:
    found = Region(
        table.text("name"),
        read_pose(table),
        table.numbers("size_mm", 3, low=1, high=5000) / 1000,
    )
    table.finish()
    return found
