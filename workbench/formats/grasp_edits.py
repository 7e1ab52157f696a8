"""Grasps added to a `grasps.toml` that people write: what stands there stays as it is."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from tomlkit.exceptions import TOMLKitError

from workbench.formats.parts import read_grasps
from workbench.formats.toml_keys import LARGEST_FILE
from workbench.formats.whole_files import read_whole, write_whole
from workbench.model.errors import FileError
from workbench.model.geometry import Floats
from workbench.model.part import Grasp


def add_grasps(path: Path, grasps: Iterable[Grasp]) -> tuple[str, ...]:
    """Write grasps behind those of a file, which is made when it is not there.

    Returns:
        Their names in the file: one that is taken gets a number behind it.

    Raises:
        FileError: the file cannot be read, or holds what it should not; it is left as it is.
    """
    text, taken = "", set[str]()
    if path.exists():
        taken = {grasp.name for grasp in read_grasps(path).grasps}
        text = read_whole(path, LARGEST_FILE).decode("utf-8-sig")
    try:
        document: Any = tomlkit.parse(text)
    except TOMLKitError as error:
        raise FileError(path, f"is not valid TOML: {error}") from None
    tables = document.get("grasp")
    if tables is None:
        tables = tomlkit.aot()
        document["grasp"] = tables
    names: list[str] = []
    for grasp in grasps:
        name = unused(grasp.name, taken)
        taken.add(name)
        names.append(name)
        tables.append(_table(name, grasp))
    content = tomlkit.dumps(document).encode()
    # What cannot be read again is not written.
    trial = path.with_name(f".{path.name}.trial")
    try:
        write_whole(trial, content)
        read_grasps(trial)
    finally:
        trial.unlink(missing_ok=True)
    write_whole(path, content)
    return tuple(names)


def unused(name: str, taken: set[str]) -> str:
    """The name, with the first number behind it that makes it new."""
    number, found = 2, name
    while found in taken:
        found = f"{name}-{number}"
        number += 1
    return found


def _table(name: str, grasp: Grasp) -> Any:
    """A grasp as people write it: what is as usual is left out."""
    T = grasp.T_part_tcp
    table: Any = tomlkit.table()
    table["name"] = name
    table["position_mm"] = _numbers(T.translation * 1000, 3)
    # Six digits would no longer be square to each other.
    table["points_along"] = _numbers(T.rotation[:, 2], 9)
    table["closes_along"] = _numbers(T.rotation[:, 1], 9)
    table["opening_mm"] = _number(grasp.opening * 1000, 2)
    table["grip_mm"] = _number(grasp.grip * 1000, 2)
    if not np.allclose(grasp.approach, [0, 0, 1], atol=1e-9):
        table["approach"] = _numbers(grasp.approach, 9)
    table["approach_length_mm"] = _number(grasp.approach_length * 1000, 2)
    if grasp.retreat is not None:
        table["retreat"] = _numbers(grasp.retreat, 9)
        table["retreat_length_mm"] = _number(grasp.retreat_length * 1000, 2)
    if grasp.priority:
        table["priority"] = grasp.priority
    if not grasp.is_enabled:
        table["enabled"] = False
    if grasp.arms:
        table["arms"] = list(grasp.arms)
    if grasp.tool:
        table["tool"] = grasp.tool
    if grasp.free_rotation:
        table["free_rotation_deg"] = _number(np.rad2deg(grasp.free_rotation), 4)
    return table


def _numbers(values: Floats, digits: int) -> list[float | int]:
    return [_number(value, digits) for value in values]


def _number(value: float, digits: int) -> float | int:
    rounded = round(float(value), digits) + 0.0
    return int(rounded) if rounded.is_integer() else rounded
