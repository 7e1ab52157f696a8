"""Poses of parts from files: our JSON in metres, or HALCON's `write_tuple` text in millimetres."""

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.files.json_keys import json_text, parse_json
from workbench.formats.files.toml_keys import MISSING, Table, quote
from workbench.formats.files.whole_files import MB, read_whole, write_whole
from workbench.model.digest import canonical
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats, pose_from_matrix
from workbench.model.recipes.joint import PlacingError
from workbench.model.scan import Detection

POSES_FORMAT = "workbench-poses/1"

LARGEST_FILE = 4 * MB
MOST_PARTS = 1000
FARTHEST_PART = 20.0
"""[m] A part further away than this was given in other units."""

EXACT = 1e-6
"""A matrix this close to a rotation keeps its digits, so that digests survive a file."""

LARGEST_COVARIANCE = 1e6
"""[m2, rad2] Largest number in a covariance; a larger one is a mistake."""

LONGEST_NAME = 200
"""Largest number of characters of a name in a file."""

NUMBERS_A_PART = 12
LONGEST_NUMBER = 60
_COUNT = re.compile(r"[0-9]{1,12}")
_WHOLE = re.compile(r"[+-]?[0-9]+")
_REAL = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


def read_poses(path: str | Path, part: str) -> tuple[Detection, ...]:
    """Detections from a file; see `parse_poses`.

    Raises:
        FileError: it cannot be read, or as `parse_poses` has it.
    """
    return parse_poses(Path(path), read_whole(Path(path), LARGEST_FILE), part)


def parse_poses(path: Path, content: bytes, part: str) -> tuple[Detection, ...]:
    """Detections from a file of either kind, distinguished by content.

    Args:
        path: of the file, for messages.
        content: our JSON (format `workbench-poses/1`, begins with a brace), or the text that
            HALCON's `write_tuple` makes: the count of numbers, then a line `type value` for
            each (type 1: integer, 2: real); twelve numbers a part, the rows of [R | t] of
            the part in the world frame, millimetres.
        part: name of the part that the poses of a HALCON file are of.  Our JSON names the
            part of each pose itself.

    Raises:
        FileError: names the line or key that is wrong, its value and what was expected.
    """
    if content.removeprefix(b"\xef\xbb\xbf").lstrip()[:1] == b"{":
        return _from_json(parse_json(path, content, POSES_FORMAT))
    numbers = _halcon_numbers(path, content)
    matrices = numbers.reshape(-1, 3, 4)
    matrices[:, :, 3] /= 1000
    return tuple(
        Detection(part, checked_pose(path, f"pose {number}", matrix))
        for number, matrix in enumerate(matrices, start=1)
    )


def write_poses(path: str | Path, detections: Sequence[Detection]) -> None:
    """Write detections as our JSON; reading them back gives the same digests.

    Raises:
        FileError: the file cannot be written, or a score is not a finite number.
    """
    content = {"format": POSES_FORMAT, "detections": [canonical(found) for found in detections]}
    write_whole(Path(path), json_text(Path(path), content))


def read_detection(table: Table, *, complete: bool) -> Detection:
    """One detection as an object of its fields.

    Args:
        table: the object.
        complete: every field must be given; otherwise only part and pose must, and it is a part
            that was found: none that a plan has put somewhere.
    """

    def optional(key: str) -> float | None:
        if table.is_null(key) or not (complete or table.has(key)):
            return None
        return table.number(key)

    def later(key: str) -> float | None:
        return table.number(key, low=0.0, high=1.0) if table.has(key) else None

    full, known = (MISSING, MISSING) if complete else (1.0, True)
    detection = Detection(
        part=name_in(table, "part"),
        T_world_part=read_pose_rows(table, "T_world_part"),
        score=table.number("score", full),
        visible=table.number("visible", full),
        gap=optional("gap"),
        residual=optional("residual"),
        roll_known=table.flag("roll_known", known),
        covariance=read_covariance(table) if table.has("covariance") else None,
        probability=later("probability"),
        roll_axis=_roll_axis(table) if table.has("roll_axis") else None,
        T_world_found=read_pose_rows(table, "T_world_found")
        if complete and table.has("T_world_found")
        else None,
        by_colour=table.flag("by_colour") if table.has("by_colour") else None,
        placing=_placing(table) if complete and table.has("placing") else None,
        T_world_seen=read_pose_rows(table, "T_world_seen")
        if complete and table.has("T_world_seen")
        else None,
    )
    table.finish()
    return detection


def name_in(table: Table, key: str) -> str:
    """What something is called: messages say it again, and none is a page long.

    Raises:
        FileError: it is too long, or as `Table.text` has it.
    """
    name = table.text(key)
    if len(name) > LONGEST_NAME:
        raise table.error(key, f"has {len(name)} characters, a name at most {LONGEST_NAME}")
    return name


def _placing(table: Table) -> PlacingError:
    error = table.table("placing")
    read = PlacingError(error.rows("by_scanner", 6), read_covariance(error))
    if read.by_scanner.shape != (6, 6) or np.abs(read.by_scanner).max() > LARGEST_COVARIANCE:
        raise error.error(
            "by_scanner", f"is not six rows of six, at most {LARGEST_COVARIANCE:g} each"
        )
    error.finish()
    return read


def read_covariance(table: Table) -> Floats:
    """Six rows of six numbers (6, 6) [m, rad] that can be a covariance."""
    rows = table.rows("covariance", 6)
    if np.abs(rows).max(initial=0.0) > LARGEST_COVARIANCE:
        raise table.error(
            "covariance", f"reaches {np.abs(rows).max():.3g}, at most {LARGEST_COVARIANCE:g}"
        )
    small = 1e-9 * float(np.abs(rows).max(initial=0.0))
    is_one = rows.shape == (6, 6) and np.abs(rows - rows.T).max() <= small
    if not is_one or np.linalg.eigvalsh(rows).min() < -small:
        raise table.error(
            "covariance", "is no covariance: six rows of six, symmetric, none negative"
        )
    return rows


def _roll_axis(table: Table) -> Floats:
    """A point [m] and a unit direction, shape (2, 3)."""
    rows = table.rows("roll_axis", 3)
    if rows.shape != (2, 3) or abs(float(np.linalg.norm(rows[1])) - 1.0) > EXACT:
        raise table.error("roll_axis", "is no axis: a point [m] and a direction of length 1")
    return rows


def read_pose_rows(table: Table, key: str) -> pin.SE3:
    """A pose from the three or four rows of its matrix, metres."""
    return checked_pose(table.path, f"key {table.place}{key}", table.rows(key, 4))


def checked_pose(path: Path, where: str, matrix: Floats) -> pin.SE3:
    """A pose from a matrix (3, 4) or (4, 4) [m], of a plausible distance.

    Raises:
        FileError: starts with `where`.
    """
    try:
        T = pose_from_matrix(matrix)
    except InputError as error:
        raise FileError(path, f"{where}: {error}") from None
    away = float(np.abs(T.translation).max())
    if away > FARTHEST_PART:
        raise FileError(
            path,
            f"{where}: is {away:.4g} m away, expected at most {FARTHEST_PART:g} m; JSON is in "
            "metres, HALCON text in millimetres",
        )
    if np.abs(T.rotation - matrix[:3, :3]).max() <= EXACT:
        return pin.SE3(np.array(matrix[:3, :3]), np.array(matrix[:3, 3]))
    return T


def _from_json(table: Table) -> tuple[Detection, ...]:
    entries = list(table.tables("detections", MISSING))
    table.finish()
    if len(entries) > MOST_PARTS:
        raise table.error("detections", f"{len(entries)} are given, at most {MOST_PARTS} are read")
    return tuple(read_detection(entry, complete=False) for entry in entries)


def _halcon_numbers(path: Path, content: bytes) -> Floats:
    """All numbers of a HALCON tuple file, checked one by one, shape (12 * parts,)."""
    try:
        lines = content.decode("ascii").rstrip().splitlines()
    except UnicodeDecodeError:
        raise FileError(path, "is neither JSON nor a HALCON tuple: it is not a text") from None
    if not lines:
        raise FileError(path, "is empty; the first line must be the count of numbers")
    first = lines[0].strip()
    if not _COUNT.fullmatch(first):
        raise FileError(
            path,
            f"is neither JSON nor a HALCON tuple: line 1 must be the count of numbers, not "
            f"{quote(first)}",
        )
    count = int(first)
    if count % NUMBERS_A_PART or count > MOST_PARTS * NUMBERS_A_PART:
        raise FileError(
            path,
            f"line 1: a count of {count} numbers; expected a multiple of {NUMBERS_A_PART} up "
            f"to {MOST_PARTS * NUMBERS_A_PART} (12 numbers a part)",
        )
    if len(lines) - 1 != count:
        raise FileError(path, f"line 1 promises {count} numbers, {len(lines) - 1} lines follow")
    return np.array([_number(path, at, line) for at, line in enumerate(lines[1:], start=2)])


def _number(path: Path, at: int, line: str) -> float:
    kind, _, text = line.strip().partition(" ")
    text = text.strip()
    pattern = {"1": _WHOLE, "2": _REAL}.get(kind)
    if pattern is None:
        raise FileError(
            path,
            f"line {at}: {quote(line)} must be `1 integer` or `2 real`; texts (types 3 and 4) "
            "are not poses",
        )
    if len(text) > LONGEST_NUMBER or not pattern.fullmatch(text) or not np.isfinite(float(text)):
        expected = "an integer" if kind == "1" else "a finite real number"
        raise FileError(path, f"line {at}: {quote(text)} is not {expected}")
    return float(text)
