"""What Photoneo's scanners say in PLY files after the points: size of the image, and the camera.

They write elements `camera` (where the camera is in the frame of the points, and its axes) and
`phoxi_frame_params` (columns and rows), one row each.  There is more, such as the camera's matrix,
which points in space have no need of.  Source: files that PhoXi Control wrote, in public data sets.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.clouds.ply_header import LIST, PlyElement, PlyHeader
from workbench.formats.files.text_rows import read_rows
from workbench.model.errors import FileError
from workbench.model.geometry import Floats

CAMERA, FRAME = "camera", "phoxi_frame_params"
VIEW = ("view_px", "view_py", "view_pz")
AXIS_NAMES = tuple(f"{axis}_axis{word}" for axis in "xyz" for word in "xyz")
SIZE = ("frame_width", "frame_height")

SQUARE = 1e-3
"""By so much the axes may be off a rotation: single precision, written as text."""


@dataclass(frozen=True, slots=True, eq=False)
class PhotoneoCamera:
    """The camera at `place` (3,), in the file's unit, with axes `R` (3, 3) in columns.

    `resolution` is that of the image (columns, rows), None where not every pixel is in the file.
    """

    place: Floats
    R: Floats
    resolution: tuple[int, int] | None

    def move_to_camera(self, points: Floats) -> Floats:
        """Points (n, 3) from the camera, in the file's unit; (0, 0, 0), not measured, stays."""
        measured = np.isfinite(points).all(axis=1, keepdims=True)
        measured &= points.any(axis=1, keepdims=True)
        return np.where(measured, (points - self.place) @ self.R, points)


def camera_of(path: Path, content: bytes, header: PlyHeader) -> PhotoneoCamera | None:
    """The camera that a Photoneo file describes; None for files of other makers.

    Raises:
        FileError: the file is cut off, or its numbers describe no possible camera.
    """
    by_name = {element.name: element for element in header.after}
    if not {CAMERA, FRAME} <= by_name.keys():
        return None
    rows = {name: _row(path, content, header, by_name[name]) for name in (CAMERA, FRAME)}
    missing = [name for name in (*VIEW, *AXIS_NAMES) if name not in rows[CAMERA]]
    missing += [name for name in SIZE if name not in rows[FRAME]]
    if missing:
        raise FileError(path, f"its elements {CAMERA} and {FRAME} have no property {missing[0]}")
    place = np.array([rows[CAMERA][name] for name in VIEW])
    R = np.array([rows[CAMERA][name] for name in AXIS_NAMES]).reshape(3, 3).T
    is_rotation = np.allclose(R.T @ R, np.eye(3), atol=SQUARE) and np.linalg.det(R) > 0
    if not (np.isfinite(place).all() and is_rotation):
        raise FileError(path, f"element {CAMERA}: place and axes of a camera are expected")
    columns, lines = (int(rows[FRAME][name]) for name in SIZE)
    is_whole = columns * lines == header.count
    return PhotoneoCamera(place, R, (columns, lines) if is_whole else None)


def _row(path: Path, content: bytes, header: PlyHeader, element: PlyElement) -> dict[str, float]:
    """The one row of an element after the vertices, by the names of its properties."""
    if element.count != 1 or any(kind == LIST for _, kind in element.properties):
        raise FileError(path, f"element {element.name}: one row without lists is expected")
    before = header.after[: header.after.index(element)]
    names = [name for name, _ in element.properties]
    if header.encoding == "ascii":
        skip = header.skip_lines + header.count + sum(earlier.count for earlier in before)
        values = read_rows(
            path, content, header.end, columns=range(len(names)), count=1, skip=skip
        )[0].tolist()
    else:
        order = "<" if header.encoding == "binary_little_endian" else ">"
        start = header.end + header.skip_bytes + header.count * header.size(path)
        start += sum(earlier.count * earlier.size(path) for earlier in before)
        layout = np.dtype([(name, order + kind) for name, kind in element.properties])
        if len(content) < start + layout.itemsize:
            raise FileError(path, f"is cut off: its element {element.name} is not whole")
        values = np.frombuffer(content, layout, 1, start)[0].tolist()
    return dict(zip(names, map(float, values), strict=True))
