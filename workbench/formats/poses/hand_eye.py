"""Hand-eye calibrations of other programs: pairs of poses read, the scanner's pose written.

Read are CSV, YAML of OpenCV's FileStorage (`T1_0`, `T2_0`, ... as handeye_calib_camodocal has
them), of MoveIt Calibration (`effector_wrt_world`, `object_wrt_sensor`) and of easy_handeye
(`robot`, `tracking`), and a folder of Zivid's (`robot_pose_1.yaml` beside
`checkerboard_pose_in_camera_frame_1.yaml`).
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, cast

import numpy as np
import pinocchio as pin
import yaml

from workbench.formats.files.whole_files import is_folder, read_whole, write_whole
from workbench.formats.poses.conventions import PoseConvention
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats, pose_from_matrix

LARGEST_FILE = 4_000_000
"""[bytes] Of a file of pairs."""

FARTHEST_POINT = 20.0
"""[m] No flange and no target is further away: such numbers are millimetres."""

NEAREST = 0.01
"""[m] No camera sees a target so near: such numbers are metres."""

Style = Literal["opencv", "ros", "zivid"]

PAIRS = (("effector_wrt_world", "object_wrt_sensor"), ("robot", "tracking"))
ZIVID = ("robot_pose_*.yaml", "robot_pose_", "checkerboard_pose_in_camera_frame_")


@dataclass(frozen=True, slots=True, eq=False)
class PosePair:
    """Where the flange was, in the robot's base, and where the camera saw the target."""

    name: str
    T_base_flange: pin.SE3
    T_camera_target: pin.SE3


def read_pairs(
    path: Path,
    *,
    in_hand: bool = False,
    unit: float = 1.0,
    written: PoseConvention | None = None,
) -> tuple[PosePair, ...]:
    """The pairs in a file or folder.

    Args:
        path: CSV: a row for each pair, of two poses as x, y, z and the quaternion x, y, z, w, or as
            matrices row by row; or YAML, or a folder, as above.
        in_hand: whether the robot holds the camera; easy_handeye writes the other poses inverted.
        unit: of lengths [m], where the format has none of its own.
        written: how the flange's pose is written in a CSV file, as the pendant shows it; the
            target's, too, where it has as many numbers.

    Raises:
        FileError: there is no such file, or it is none of these.
        InputError: a pose in it is none; the message names it.
    """
    if is_folder(path):
        pairs = list(_zivid_pairs(path))
    elif path.suffix.lower() in (".yaml", ".yml"):
        pairs = list(_yaml_pairs(path, _load(path), in_hand=in_hand, unit=unit))
    else:
        pairs = list(_csv_pairs(path, unit, written))
    if not pairs:
        raise FileError(path, "no pair of a flange pose and a target pose was found")
    for pair in pairs:
        for T in (pair.T_base_flange, pair.T_camera_target):
            if np.linalg.norm(T.translation) > FARTHEST_POINT:
                raise InputError(
                    f"{path}: {pair.name} lies {np.linalg.norm(T.translation):.0f} m away; are "
                    "its lengths millimetres? Then state --unit mm"
                )
    return tuple(pairs)


def _csv_pairs(path: Path, unit: float, written: PoseConvention | None) -> Iterator[PosePair]:
    content = read_whole(path, LARGEST_FILE).decode("utf-8-sig", errors="replace")
    first = 0 if written is None else len(written.names)
    wanted = (14, 24, 32) if not first else (2 * first, first + 7, first + 12, first + 16)
    is_begun = False
    for line, row in enumerate(content.splitlines(), start=1):
        words = [word for word in re.split(r"[\s,;]+", row.strip()) if word]
        if not words or words[0].startswith("#"):
            continue
        try:
            values = [float(word) for word in words]
        except ValueError:
            if is_begun:
                raise FileError(path, f"line {line}: {row.strip()[:60]!r} is no number") from None
            continue  # a heading
        is_begun = True
        if len(values) not in wanted:
            raise FileError(
                path,
                f"line {line}: {len(values)} numbers; a pair has "
                f"{', '.join(map(str, wanted[:-1]))} or {wanted[-1]}",
            )
        half = first or len(values) // 2
        try:
            flange = _pose(values[:half], unit) if written is None else written.pose(values[:half])
            same = written is not None and len(values) == 2 * half
            rest = values[half:]
            target = written.pose(rest) if written and same else _pose(rest, unit)
            if same and np.linalg.norm(target.translation) < NEAREST:
                far = np.linalg.norm(target.translation) * 1000
                raise InputError(
                    f"the target is {far:.3g} mm from the camera: as many numbers as the pendant "
                    "shows are in its form, millimetres; give another form as a matrix"
                )
        except InputError as error:
            raise InputError(f"{path}, line {line}: {error}") from None
        yield PosePair(f"line {line}", flange, target)


def _pose(values: Sequence[float], unit: float) -> pin.SE3:
    """A pose of 7 numbers (x, y, z, quaternion x, y, z, w), or of 12 or 16 row by row."""
    if len(values) != 7:
        T = pose_from_matrix(np.reshape(values, (-1, 4)))
        return pin.SE3(T.rotation, T.translation * unit)
    x, y, z, w = values[3:]
    length = float(np.linalg.norm(values[3:]))
    if not abs(length - 1) < 0.01 or not np.all(np.isfinite(values)):
        raise InputError(f"the quaternion {x:g}, {y:g}, {z:g}, {w:g} has the length {length:.3f}")
    turn = pin.Quaternion(w / length, x / length, y / length, z / length)
    return pin.SE3(turn.matrix(), np.array(values[:3]) * unit)


class _Loader(yaml.SafeLoader):
    """YAML without aliases, by which a small file could become a huge one."""

    def compose_node(self, parent: Any, index: Any) -> Any:
        if self.check_event(yaml.AliasEvent):
            raise yaml.YAMLError("an alias is not allowed")
        return super().compose_node(parent, index)


def _matrix(loader: yaml.SafeLoader, node: yaml.Node) -> Any:
    return loader.construct_mapping(cast(yaml.MappingNode, node), deep=True).get("data")


_Loader.add_constructor("tag:yaml.org,2002:opencv-matrix", _matrix)


def _load(path: Path) -> Any:
    content = read_whole(path, LARGEST_FILE).decode("utf-8-sig", errors="replace")
    # OpenCV begins its files with a directive that YAML does not have.
    content = re.sub(r"\A%YAML:1\.0\s*\n(---\s*\n)?", "", content)
    try:
        return yaml.load(content, Loader=_Loader)
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        says = " ".join(str(error).split())
        raise FileError(path, f"no YAML that can be read: {says[:200]}") from None


def _yaml_pairs(path: Path, found: Any, *, in_hand: bool, unit: float) -> Iterator[PosePair]:
    if isinstance(found, Mapping):
        table = cast(Mapping[str, Any], found)
        numbers = sorted(int(key[3:]) for key in table if re.fullmatch(r"T1_\d{1,6}", str(key)))
        for number in numbers:
            yield PosePair(
                f"pair {number}",
                _yaml_pose(path, f"T1_{number}", table[f"T1_{number}"], unit),
                _yaml_pose(path, f"T2_{number}", table.get(f"T2_{number}"), unit),
            )
        if numbers:
            return
        found = table.get("samples")
    if not isinstance(found, list):
        return
    for number, entry in enumerate(cast(list[Any], found), start=1):
        keys = next(
            (keys for keys in PAIRS if isinstance(entry, Mapping) and keys[0] in entry), None
        )
        if keys is None:
            return
        first, second = (
            _yaml_pose(path, f"pair {number}, {key}", entry.get(key), unit) for key in keys
        )
        # easy_handeye solves one equation for both, and turns one of the two round instead.
        is_inverted = keys[0] == "robot" and not in_hand
        yield PosePair(f"pair {number}", first.inverse() if is_inverted else first, second)


def _yaml_pose(path: Path, name: str, value: Any, unit: float) -> pin.SE3:
    try:
        if isinstance(value, Mapping):
            table = cast(Mapping[str, Any], value)
            xyz, turn = (
                [float(part[axis]) for axis in axes]
                for part, axes in zip(
                    (table["translation"], table["rotation"]), ("xyz", "xyzw"), strict=True
                )
            )
            return _pose([*xyz, *turn], unit)
        values = np.asarray(value, np.float64).ravel()
        if values.size not in (12, 16):
            raise InputError(f"a matrix has 12 or 16 numbers, not {values.size}")
        return _pose(values.tolist(), unit)
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: {name} is no pose: {str(error) or 'it is missing'}") from None
    except InputError as error:
        raise InputError(f"{path}: {name} is no pose: {error}") from None


def _zivid_pairs(folder: Path) -> Iterator[PosePair]:
    pattern, robot, target = ZIVID
    for file in sorted(folder.glob(pattern)):
        other = folder / file.name.replace(robot, target)
        # Poses of which the board was not seen have no second file.
        if other.is_file():
            yield PosePair(file.stem, _zivid_pose(file), _zivid_pose(other))


def _zivid_pose(path: Path) -> pin.SE3:
    found = _load(path)
    matrix = found.get("FloatMatrix") if isinstance(found, Mapping) else None
    if not isinstance(matrix, Mapping):
        raise FileError(path, "has no FloatMatrix, as pose files of Zivid have")
    return _yaml_pose(path, "FloatMatrix", cast(Mapping[str, Any], matrix).get("Data"), 0.001)


def write_scanner_pose(path: Path, T: pin.SE3, style: Style, *, in_hand: bool) -> None:
    """Write where the scanner is, in the flange or in the robot's base, for another program.

    Args:
        path: of the YAML file.
        T: `T_flange_scanner` where the robot holds it, otherwise `T_base_scanner`.
        style: OpenCV's FileStorage [m], ROS with easy_handeye's names [m], or Zivid's [mm].
        in_hand: whether the robot holds it.

    Raises:
        FileError: it cannot be written.
    """
    matrix = T.homogeneous
    match style:
        case "opencv":
            name = "T_flange_scanner" if in_hand else "T_base_scanner"
            rows = f"{name}: !!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: d\n"
            text = f"%YAML:1.0\n---\n{rows}   data: [ {_join_values(matrix.ravel())} ]\n"
        case "ros":
            kind = "eye_in_hand" if in_hand else "eye_on_base"
            x, y, z = T.translation
            qx, qy, qz, qw = pin.Quaternion(T.rotation).coeffs()
            text = yaml.safe_dump(
                {
                    "parameters": {"calibration_type": kind},
                    "transform": {
                        "translation": _name_values(x=x, y=y, z=z),
                        "rotation": _name_values(x=qx, y=qy, z=qz, w=qw),
                    },
                },
                sort_keys=False,
            )
        case "zivid":
            matrix = matrix * np.array([[1, 1, 1, 1000]])
            matrix[3, 3] = 1.0
            rows = ",\n".join(f"            [{_join_values(row)}]" for row in matrix)
            head = "__version__:\n    serializer: 1\n    data: 1\nFloatMatrix:\n    Data:\n"
            text = f"{head}        [\n{rows}\n        ]\n"
    write_whole(path, text.encode())


def _join_values(values: Floats) -> str:
    return ", ".join(f"{value + 0.0:.12g}" for value in values)


def _name_values(**values: float) -> dict[str, float]:
    return {name: float(f"{value + 0.0:.12g}") for name, value in values.items()}
