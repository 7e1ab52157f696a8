"""Estimated poses as BOP's participants hand them in: one line of CSV for each, millimetres."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import MB, read_whole, write_whole
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import copy_pose, pose_from_matrix, put

HEADER = "scene_id,im_id,obj_id,score,R,t,time"
"""As of BOP 2019 (bop_toolkit_lib/inout.py, `load_bop_results`)."""

LARGEST_FILE = 256 * MB


@dataclass(frozen=True, slots=True, eq=False)
class PoseEstimate:
    """One object found in one image: its number, pose and score.

    `seconds` is what the whole image took, the same for all of its estimates; below zero: unknown.
    """

    scene: int
    image: int
    object: int
    score: float
    T_camera_object: pin.SE3
    seconds: float = -1.0

    def __post_init__(self) -> None:
        put(self, T_camera_object=copy_pose(self.T_camera_object))


def write_results(path: Path, estimates: Sequence[PoseEstimate]) -> None:
    """Write estimates as BOP reads them.

    Raises:
        FileError: the file cannot be written.
    """
    lines = [HEADER]
    for estimate in estimates:
        T = estimate.T_camera_object
        R = " ".join(map(repr, T.rotation.ravel().tolist()))
        t = " ".join(map(repr, (T.translation * 1000).tolist()))
        lines.append(
            f"{estimate.scene},{estimate.image},{estimate.object},{estimate.score!r},{R},{t},{estimate.seconds!r}"
        )
    write_whole(path, ("\n".join(lines) + "\n").encode())


def read_results(path: Path) -> list[PoseEstimate]:
    """Estimates in the order of the file; its first line may be the header or an estimate.

    Raises:
        FileError: names the line that is wrong.
    """
    try:
        lines = read_whole(path, LARGEST_FILE).decode("utf-8-sig").splitlines()
    except UnicodeDecodeError:
        raise FileError(path, "is not a text file in UTF-8") from None
    return [
        _estimate(path, number, line)
        for number, line in enumerate(lines, start=1)
        if line.strip() and not (number == 1 and line.strip() == HEADER)
    ]


def _estimate(path: Path, number: int, line: str) -> PoseEstimate:
    cells = line.split(",")
    if len(cells) != len(HEADER.split(",")):
        raise FileError(path, f"line {number}: {HEADER} are expected, {quote(line)} is given")
    try:
        scene, image, kind = (int(cell) for cell in cells[:3])
        score, seconds = float(cells[3]), float(cells[6])
        R = np.array([float(cell) for cell in cells[4].split()]).reshape(3, 3)
        t = np.array([float(cell) for cell in cells[5].split()]).reshape(3, 1) / 1000
        if not np.isfinite([score, seconds]).all():
            raise ValueError("score and time are finite numbers")
        T = pose_from_matrix(np.hstack([R, t]))
    except (ValueError, InputError) as error:
        raise FileError(path, f"line {number}: {quote(str(error))}") from None
    return PoseEstimate(scene, image, kind, score, T, seconds)
