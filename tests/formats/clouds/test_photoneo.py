"""PLY files as Photoneo's scanners write them: what comes after the points is read as well."""

from pathlib import Path

import numpy as np
import pytest

from workbench.formats.clouds.scans import read_cloud, read_scan
from workbench.model.cell import ScannerMount
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy

T = pose_from_rpy((0.4, 0.0, 0.9), (np.pi, 0, 0))
T_file_camera = pose_from_rpy((250.0, -80.0, 910.0), (2.9, 0.2, -1.1))
COLUMNS, ROWS = 8, 6
ENCODINGS = ("ascii", "binary_little_endian", "binary_big_endian")

ELEMENTS = {
    "camera": [f"float view_p{axis}" for axis in "xyz"]
    + [f"float {axis}_axis{word}" for axis in "xyz" for word in "xyz"],
    "phoxi_frame_params": [
        *("uint32 frame_width", "uint32 frame_height", "uint32 frame_index"),
        *("float frame_start_time", "float frame_duration"),
        *("float frame_computation_duration", "float frame_transfer_duration"),
        "int32 total_scan_count",
    ],
    "camera_matrix": [f"float cm{k}" for k in range(9)],
    "distortion_matrix": [f"float dm{k}" for k in range(14)],
    "camera_resolution": ["float width", "float height"],
    "frame_binning": ["float horizontal", "float vertical"],
}
KINDS = {"float": "f4", "uint32": "u4", "int32": "i4"}


def seen() -> np.ndarray:
    """Points (n, 3) [mm] from the camera, some of them not measured."""
    points = np.random.default_rng(4).uniform((-150, -100, 700), (150, 100, 900), (48, 3))
    points[::5] = 0.0
    return points


def photoneo(points: np.ndarray, encoding: str = "ascii", **changed: list[float]) -> bytes:
    """The file of points (n, 3) [mm] in the camera's frame, told in a frame beside it."""
    order = ">" if encoding.endswith("big_endian") else "<"
    R, p = T_file_camera.rotation, T_file_camera.translation
    placed = np.where(points.any(axis=1)[:, None], points @ R.T + p, points)
    vertices = np.zeros(len(points), [(f, order + "f4") for f in ("x", "y", "z", "Texture32")])
    for column, name in enumerate("xyz"):
        vertices[name] = placed[:, column]
    values = {
        "camera": [*p, *R.T.ravel()],
        "phoxi_frame_params": [COLUMNS, ROWS, 12, 1.5, 0.4, 0.3, 0.02, 9],
        "camera_matrix": [2300.0, 0, 4, 0, 2300.0, 3, 0, 0, 1],
        "distortion_matrix": [0.0] * 14,
        "camera_resolution": [COLUMNS, ROWS],
        "frame_binning": [1, 1],
        **changed,
    }
    header = ["ply", f"format {encoding} 1.0", f"element vertex {len(points)}"]
    header += [f"property float {name}" for name in vertices.dtype.names or ()]
    body = [" ".join(map(repr, row)) for row in vertices.tolist()]
    binary = vertices.tobytes()
    for name, given in values.items():
        header.append(f"element {name} 1")
        header += [f"property {one}" for one in ELEMENTS[name]]
        kinds = [KINDS[one.split()[0]] for one in ELEMENTS[name]]
        row = np.zeros(1, [(f"f{k}", order + kind) for k, kind in enumerate(kinds)])
        row[0] = tuple(given)
        binary += row.tobytes()
        body.append(" ".join(map(repr, row.tolist()[0])))
    text = "\n".join([*header, "end_header", ""]).encode()
    return text + ("\n".join([*body, ""]).encode() if encoding == "ascii" else binary)


def written(folder: Path, content: bytes) -> Path:
    (folder / "phoxi.ply").write_bytes(content)
    return folder / "phoxi.ply"


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_points_are_seen_from_the_camera_that_the_file_tells(tmp_path, encoding):
    points = seen()
    scan = read_cloud(written(tmp_path, photoneo(points, encoding)), T, unit="mm")
    measured = np.flatnonzero(points.any(axis=1))
    np.testing.assert_allclose(scan.points, points[measured] / 1000, atol=1e-6)
    assert scan.resolution == (COLUMNS, ROWS)
    np.testing.assert_array_equal(scan.pixels, measured)
    assert scan.T_world_scanner.isApprox(T)


def test_a_scanner_takes_such_a_file_whatever_frame_was_chosen_in_its_program(tmp_path):
    mount = ScannerMount(T, unit="mm", near=0.5, far=1.2)
    scan = read_scan(written(tmp_path, photoneo(seen())), mount)
    assert (scan.points[:, 2] > 0.69).all()


def test_without_every_pixel_there_is_no_image(tmp_path):
    points = seen()
    points = points[points.any(axis=1)]
    scan = read_cloud(written(tmp_path, photoneo(points)), T, unit="mm")
    np.testing.assert_allclose(scan.points, points / 1000, atol=1e-6)
    assert scan.resolution is None and scan.pixels is None


def test_a_camera_of_other_programs_moves_nothing(tmp_path):
    content = photoneo(seen()).replace(b"element phoxi_frame_params 1", b"element frame 1")
    scan = read_cloud(written(tmp_path, content), T, unit="mm")
    assert abs(scan.points - seen()[seen().any(axis=1)] / 1000).max() > 0.1
    assert scan.resolution is None


MIRRORED = [0.0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, -1]


@pytest.mark.parametrize(
    ("content", "told"),
    [
        (photoneo(seen(), camera=MIRRORED), "element camera: place and axes of a camera"),
        (photoneo(seen(), camera=[np.nan] * 3 + MIRRORED[3:]), "element camera: place and axes"),
        (photoneo(seen()).replace(b"view_px", b"view_qx"), "have no property view_px"),
        (photoneo(seen()).replace(b"frame_width", b"frame_wide"), "have no property frame_width"),
        (photoneo(seen()).replace(b"element camera 1", b"element camera 2"), "camera: one row"),
        (photoneo(seen(), ENCODINGS[1])[:-150], "is cut off: its element camera is not whole"),
        (
            photoneo(seen()).replace(b"float x_axisx", b"list uchar int x_axisx"),
            "element camera: one row without lists",
        ),
    ],
)
def test_a_file_that_tells_no_camera_is_refused(tmp_path, content, told):
    with pytest.raises(FileError, match=told):
        read_cloud(written(tmp_path, content), T, unit="mm")


def test_any_file_that_is_cut_off_is_refused_or_read_without_what_is_not_needed(tmp_path):
    whole = photoneo(seen(), ENCODINGS[1])
    needed = len(whole) - 4 * (9 + 14 + 2 + 2)
    for length in range(len(whole) - 400, len(whole)):
        path = written(tmp_path, whole[:length])
        if length >= needed:
            assert read_cloud(path, T, unit="mm").resolution == (COLUMNS, ROWS)
        else:
            with pytest.raises(FileError, match="cut off"):
                read_cloud(path, T, unit="mm")
