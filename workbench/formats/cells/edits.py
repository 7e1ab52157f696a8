"""Changes of a cell written into the file that people wrote: only what differs, comments stay."""

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import tomlkit

from workbench.formats.cells.calibrations import record_table
from workbench.formats.cells.places import OF_PART
from workbench.formats.cells.pose_edits import LOST, edit_pose
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.tool_edits import all_as_written, as_written, edit_tools
from workbench.formats.files.change_log import LOG, add_line, utc
from workbench.formats.files.toml_documents import millimetres, read_document, short, shorts
from workbench.formats.files.whole_files import write_whole
from workbench.formats.parts.grasp_files import are_written_alike
from workbench.model.cell import Arm, Cell, Policy
from workbench.model.derived.controller_axes import to_controller
from workbench.model.digest import digest_of
from workbench.model.errors import FileError
from workbench.model.geometry import Floats
from workbench.model.messages.files import FileProblem
from workbench.model.part import Bin, PartPlace
from workbench.model.recipes.recipe import names_of
from workbench.model.robot import ArmScanner

UNWRITABLE = FileProblem.UNWRITABLE()


def save_cell(path: Path, cell: Cell) -> None:
    """Write the differences between a cell and its file into the file.

    If anything other than these differs, the file stays unchanged:

    - the parts that the cell picks;
    - poses of robot, bin, regions, scanner and fixtures, sizes and walls of bins;
    - the scanner's calibration, pose on its arm, unit, axes and range;
    - homes, places and tools of the arms, TCPs, and new or removed tools;
    - of the policy: the lifts and the margin of linear motions.

    Args:
        path: of the cell file, which must be readable as a cell.
        cell: the cell to write.

    Raises:
        FileError: the file cannot be read or written, or something else differs.
    """
    write_whole(path, written_cell(path, cell))


def written_cell(path: Path, cell: Cell) -> bytes:
    """What `save_cell` would write into the file; nothing is changed yet.

    Raises:
        FileError: the file cannot be read, its folder cannot be written, or something differs
            that cannot be written into it.
    """
    old = read_cell(path)
    if _names(old) != _names(cell):
        raise FileError(path, UNWRITABLE)
    document: Any = read_document(path)
    _edit(document, old, cell)
    edit_tools(document, old, cell, path.parent)
    written = tomlkit.dumps(document).encode()
    trial = path.with_name(f".{path.name}.trial")
    try:
        write_whole(trial, written)
        again = read_cell(trial)
    except FileError as error:
        raise FileError(path, FileProblem.NOT_WRITTEN(problem=error.problem)) from None
    finally:
        trial.unlink(missing_ok=True)
    if not _is_same(again, cell):
        raise FileError(path, UNWRITABLE)
    return written


def log_change(path: Path, cell: Cell, actor: str, at: float, remark: str) -> None:
    """Add a line about a saved change to the log next to the cell file.

    Raises:
        FileError: it cannot be written.
    """
    entry = {"at": utc(at), "by": actor, "cell": cell.digest, "remark": remark}
    add_line(path.with_name(LOG), entry)


def _names(cell: Cell) -> list[list[str]]:
    """Of arms, fixtures, bins and their regions, in order: none can be added or taken away."""
    regions = (box.regions for box in cell.bins)
    named = (cell.arms, cell.fixtures, cell.bins, *regions)
    return [[each.name for each in many] for many in named]


def _bin_as(mine: Bin, other: Bin) -> Bin:
    """A bin where the other is, of its size, with its regions there."""
    regions = tuple(
        replace(region, T_bin_region=moved.T_bin_region)
        for region, moved in zip(mine.regions, other.regions, strict=True)
    )
    size, walls = other.size, other.has_walls
    return replace(mine, T_world_bin=other.T_world_bin, size=size, regions=regions, has_walls=walls)


def _is_same(cell: Cell, other: Cell) -> bool:
    """Whether two cells differ by no more than what is lost when numbers are written."""
    if [part.name for part in cell.parts] != [part.name for part in other.parts]:
        return False
    parts = tuple(
        replace(mine, library=part.library, symmetry=part.symmetry)
        if are_written_alike(mine.library, part.library)
        and str(mine.symmetry) == str(part.symmetry)
        else mine
        for mine, part in zip(cell.parts, other.parts, strict=True)
    )
    arms = tuple(
        replace(
            mine,
            tool=as_written(mine.tool, arm.tool),
            tools=all_as_written(mine.tools, arm.tools),
            home=arm.home,
            Ts_world_place=arm.Ts_world_place,
            part_places=_moved_as(mine.part_places, arm.part_places),
        )
        for mine, arm in zip(cell.arms, other.arms, strict=True)
    )
    fixtures = tuple(
        replace(mine, T_world_fixture=fixture.T_world_fixture)
        for mine, fixture in zip(cell.fixtures, other.fixtures, strict=True)
    )
    mount, other_mount = cell.scanner, other.scanner
    calibration, record = mount.calibration, other_mount.calibration
    carrier, other_carrier = mount.on_arm, other_mount.on_arm
    if carrier is not None and other_carrier is not None:
        carrier = replace(carrier, T_flange_scanner=other_carrier.T_flange_scanner)
    if calibration is not None and record is not None:
        calibration = replace(
            calibration,
            rms=record.rms,
            position_error=record.position_error,
            angle_error=record.angle_error,
            covariance=record.covariance,
        )
    alike = replace(
        cell,
        T_world_robot=other.T_world_robot,
        bin=_bin_as(cell.bin, other.bin),
        other_bins=tuple(map(_bin_as, cell.other_bins, other.other_bins)),
        scanner=replace(
            mount,
            T_world_scanner=other_mount.T_world_scanner,
            calibration=calibration,
            on_arm=carrier,
        ),
        arms=arms,
        fixtures=fixtures,
        parts=parts,
    )
    mine, others = _numbers(cell), _numbers(other)
    is_near = len(mine) == len(others) and bool(np.allclose(mine, others, atol=LOST))
    return is_near and alike.digest == other.digest


def _numbers(cell: Cell) -> Floats:
    """What `_edit` can write, in one row."""
    Ts = [cell.T_world_robot, cell.scanner.T_world_scanner]
    Ts += [box.T_world_bin for box in cell.bins]
    Ts += [fixture.T_world_fixture for fixture in cell.fixtures]
    Ts += [region.T_bin_region for box in cell.bins for region in box.regions]
    Ts += [T for arm in cell.arms for T in _places(arm)]
    Ts += [tool.T_flange_tcp for arm in cell.arms for tool in (arm.tool, *arm.tools)]
    rows = [T.homogeneous.ravel() for T in Ts] + [np.asarray(arm.home) for arm in cell.arms]
    record = cell.scanner.calibration
    errors = (record.rms, record.position_error, record.angle_error) if record else ()
    stated = [0.0 if error is None else error for error in errors]
    unsure = np.zeros(0) if record is None or record.covariance is None else record.covariance
    sizes = [np.asarray(box.size) for box in cell.bins]
    return np.concatenate([*rows, *sizes, stated, unsure.ravel()])


def _edit(document: Any, old: Cell, new: Cell) -> None:
    _edit_parts(document, old, new)
    edit_pose(document["robot"], old.T_world_robot, new.T_world_robot)
    boxes = document["bin"] if isinstance(document["bin"], list) else [document["bin"]]
    for box, was, now in zip(boxes, old.bins, new.bins, strict=True):
        edit_pose(box, was.T_world_bin, now.T_world_bin)
        if was.has_walls != now.has_walls:
            box["walls"] = now.has_walls
        if not np.array_equal(was.size, now.size):
            box["size_mm"] = millimetres(now.size)
        regions = zip(box.get("region", []), was.regions, now.regions, strict=True)
        for table, region, moved in regions:
            edit_pose(table, region.T_bin_region, moved.T_bin_region)
    carrier, other_carrier = old.scanner.on_arm, new.scanner.on_arm
    if carrier is None or other_carrier is None:
        edit_pose(document["scanner"], old.scanner.T_world_scanner, new.scanner.T_world_scanner)
    else:
        T, U = carrier.T_flange_scanner, other_carrier.T_flange_scanner
        edit_pose(document["scanner"]["on_arm"], T, U)
        if not np.array_equal(T.homogeneous, U.homogeneous):
            _keep_postures(document["scanner"]["on_arm"], new.arm(other_carrier.arm), other_carrier)
    for key in ("unit", "cloud_axes"):
        if getattr(old.scanner, key) != getattr(new.scanner, key):
            document["scanner"][key] = getattr(new.scanner, key)
    for key in ("near", "far"):
        if getattr(old.scanner, key) != getattr(new.scanner, key):
            document["scanner"][f"{key}_mm"] = short(getattr(new.scanner, key) * 1000, 3)
    _edit_policy(document, old.policy, new.policy)
    record = new.scanner.calibration
    if record is None:
        document["scanner"].pop("calibration", None)
    elif old.scanner.calibration is None or digest_of(record) != digest_of(old.scanner.calibration):
        document["scanner"]["calibration"] = record_table(record)
    for table, fixture, other in zip(
        document.get("fixture", []), old.fixtures, new.fixtures, strict=True
    ):
        edit_pose(table, fixture.T_world_fixture, other.T_world_fixture)
    for table, arm, other in zip(document["arm"], old.arms, new.arms, strict=True):
        if not np.array_equal(arm.home, other.home):
            table["home_deg"] = shorts(np.rad2deg(to_controller(other, other.home)))
        _edit_places(table, arm, other)


def _keep_postures(table: Any, arm: Arm, carrier: ArmScanner) -> None:
    """State views by joints, where the scanner's pose states them and would now move the arm."""
    views = table["view"] if isinstance(table["view"], list) else [table["view"]]
    for view, posture in zip(views, carrier.views, strict=True):
        if view.pop("position_mm", None) is not None or "rpy_deg" in view:
            view.pop("rpy_deg", None)
            view["joints_deg"] = shorts(np.rad2deg(to_controller(arm, posture.q)))


def has_fewer_pose_views(before: bytes, after: bytes) -> bool:
    """Whether a saved cell file states views by joints that it stated by the scanner's pose.

    Args:
        before: text of the cell file before it was saved.
        after: its text now.
    """
    return _count_pose_views(after) < _count_pose_views(before)


def _count_pose_views(text: bytes) -> int:
    view = tomllib.loads(text.decode()).get("scanner", {}).get("on_arm", {}).get("view", [])
    return sum("joints_deg" not in each for each in (view if isinstance(view, list) else [view]))


def _edit_places(table: Any, old: Arm, new: Arm) -> None:
    """Write the places of an arm into its table: poses of hands may come and go, parts' move."""
    same = [T.homogeneous.tolist() for T in _places(old)] == [
        T.homogeneous.tolist() for T in _places(new)
    ]
    tables = table.get("place", [])
    if same or any("grid" in place for place in tables):
        return  # places of a grid are changed in the file: the trial will tell
    of_part = [place for place in tables if OF_PART[0] in place]
    for place, part_place, other in zip(of_part, old.part_places, new.part_places, strict=False):
        edit_pose(place, part_place.T_world_part, other.T_world_part, OF_PART)
    if len(old.Ts_world_place) == len(new.Ts_world_place):
        of_tool = [place for place in tables if OF_PART[0] not in place]
        for place, T, U in zip(of_tool, old.Ts_world_place, new.Ts_world_place, strict=True):
            edit_pose(place, T, U)
        return
    places = tomlkit.aot()
    names = names_of(len(new.Ts_world_place), new.place_names)
    for T, name in zip(new.Ts_world_place, names, strict=True):
        place = tomlkit.table()
        if name:
            place["name"] = name
        places.append(edit_pose(place, pin.SE3.Identity(), T))
    for place in of_part:
        places.append(place)
    table["place"] = places


def _places(arm: Arm) -> tuple[pin.SE3, ...]:
    """All poses that an arm's places are stated by."""
    return (*arm.Ts_world_place, *(place.T_world_part for place in arm.part_places))


def _moved_as(
    places: tuple[PartPlace, ...], others: tuple[PartPlace, ...]
) -> tuple[PartPlace, ...]:
    """The places, each where that of the others is, as far as there are as many."""
    if len(places) != len(others):
        return places
    return tuple(
        replace(place, T_world_part=other.T_world_part)
        for place, other in zip(places, others, strict=True)
    )


def _edit_policy(document: Any, old: Policy, new: Policy) -> None:
    """Write what the nearest fix of a grasp may change."""
    changed: dict[str, Any] = {}
    if old.lifts != new.lifts:
        changed["lifts"] = list(new.lifts)
        if new.as_needed and "emptying" not in document.get("policy", {}):
            changed["emptying"] = "as-needed"
    if old.near_margin != new.near_margin:
        changed["near_margin_mm"] = shorts([new.near_margin * 1000])[0]
    if changed:
        document.setdefault("policy", tomlkit.table()).update(changed)


def _edit_parts(document: Any, old: Cell, new: Cell) -> None:
    """Name new parts after those that stay, which keep the words they are named with."""
    was, now = [part.name for part in old.parts], [part.name for part in new.parts]
    if was != now:
        named = dict(zip(was, document["parts"], strict=True))
        document["parts"] = [str(named.get(name, name)) for name in now]
