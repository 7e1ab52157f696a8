"""PCD files: what was written is read, broken ones are refused, nothing hangs or blows up."""

import struct
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mutations import mutated, only_file_errors
from stand_ins import COLUMNS, DATA, RECORDED, ROWS, make_recording, sources

from workbench.formats.clouds.scans import parse_cloud, read_cloud
from workbench.formats.meshes.reading import read_mesh
from workbench.model.errors import FileError

HERE = pin.SE3.Identity()
POINTS = np.random.default_rng(1).uniform(0.2, 0.8, (24, 3)).astype(np.float32)


def packed(data: bytes) -> bytes:
    """LZF by hand: runs of one byte as back references, everything else as it is."""
    out, at = bytearray(), 0
    while at < len(data):
        run = 1
        while at + run < len(data) and data[at + run] == data[at] and run < 260:
            run += 1
        if run >= 6:
            out += bytes([0, data[at]])
            length = run - 1 - 2
            if length < 7:
                out += bytes([length << 5, 0])
            else:
                out += bytes([7 << 5, length - 7, 0])
            at += run
        else:
            out += bytes([0, data[at]])
            at += 1
    return bytes(out)


def pcd(encoding: str, points=POINTS, width=None, height=1) -> bytes:
    width = len(points) if width is None else width
    head = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z rgb\n"
        "SIZE 4 4 4 4\nTYPE F F F U\nCOUNT 1 1 1 1\n"
        f"WIDTH {width}\nHEIGHT {height}\nVIEWPOINT 0 0 0 1 0 0 0\n"
        f"POINTS {width * height}\nDATA {encoding}\n"
    ).encode()
    rgb = np.zeros(len(points), np.uint32)
    if encoding == "ascii":
        rows = (" ".join(f"{v!r}" for v in p.tolist()) + " 0\n" for p in points)
        return head + "".join(rows).encode()
    if encoding == "binary":
        rows = np.zeros(len(points), [("p", "<f4", 3), ("c", "<u4")])
        rows["p"] = points
        return head + rows.tobytes()
    data = b"".join(np.ascontiguousarray(column).tobytes() for column in (*points.T, rgb))
    body = packed(data)
    return head + struct.pack("<II", len(body), len(data)) + body


def read(path: Path):
    return read_cloud(path, HERE)


encodings = pytest.mark.parametrize("encoding", ["ascii", "binary", "binary_compressed"])


@encodings
def test_what_was_written_is_read(encoding):
    scan = parse_cloud(Path("a.pcd"), pcd(encoding), HERE)
    np.testing.assert_allclose(scan.points, POINTS, rtol=1e-6)
    assert scan.resolution is None


@encodings
def test_an_organised_cloud_keeps_its_pixels(encoding):
    points = POINTS.copy()
    points[5] = np.nan
    scan = parse_cloud(Path("a.pcd"), pcd(encoding, points, 6, 4), HERE)
    assert scan.resolution == (6, 4)
    assert scan.pixels.tolist() == [k for k in range(24) if k != 5]


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        (b"WIDTH 24", b"WIDTH 9999999999", "WIDTH"),
        (b"WIDTH 24", b"WIDTH 999999999", "declares 999999999 points"),
        (b"WIDTH 24", b"WIDTH 48", "cut off"),
        (b"FIELDS x y z", b"FIELDS x y w", "x, y and z are expected"),
        (b"SIZE 4", b"SIZE 3", "is not known"),
        (b"TYPE F F F U", b"TYPE F F F", "4 letters"),
        (b"DATA binary", b"DATA zip", "ascii, binary"),
        (b"DATA", b"DUTA", "no line DATA"),
        (b"COUNT 1 1 1 1", b"COUNT 1 1 1", "COUNT"),
        (b"COUNT 1 1 1 1", b"COUNT 1 0 1 1", "x, y and z are expected"),
        (b"COUNT 1 1 1 1", b"COUNT 1 1 1 999999999", "COUNT 999999999: a field has at most"),
    ],
)
def test_a_broken_file_says_what_is_wrong(old, new, expected):
    content = pcd("binary")
    assert old in content
    with pytest.raises(FileError, match=expected):
        parse_cloud(Path("a.pcd"), content.replace(old, new, 1), HERE)


def test_a_file_without_a_point_is_cut_off():
    content = pcd("ascii").partition(b"DATA ascii\n")
    with pytest.raises(FileError, match="declares 24 points and holds 0"):
        parse_cloud(Path("a.pcd"), content[0] + content[1], HERE)


def test_a_part_taught_by_a_scan_has_no_corner_where_nothing_was_measured(tmp_path):
    points = np.vstack([POINTS + 5.0, np.zeros((1, 3)), [[np.nan] * 3]])
    (tmp_path / "part.pcd").write_bytes(pcd("binary", points))
    size = np.ptp(read_mesh(tmp_path / "part.pcd").points, axis=0)
    np.testing.assert_allclose(size, np.ptp(POINTS, axis=0), atol=1e-5)


@pytest.mark.parametrize("cut", [8, 20, 60])
def test_compressed_data_that_is_cut_or_bent_is_refused(cut, tmp_path):
    content = pcd("binary_compressed")
    with pytest.raises(FileError):
        parse_cloud(Path("a.pcd"), content[:-cut], HERE)
    bent = bytearray(content)
    bent[-cut] ^= 0xFF
    only_file_errors(tmp_path / "a.pcd", bytes(bent), read)


@settings(max_examples=200, deadline=None)
@given(data=st.data(), encoding=st.sampled_from(["ascii", "binary", "binary_compressed"]))
def test_no_file_is_too_strange(tmp_path_factory, data, encoding):
    content = data.draw(mutated(pcd(encoding)))
    path = tmp_path_factory.getbasetemp() / "strange.pcd"
    only_file_errors(path, b"# FIELDS\n" + content, read)


@pytest.mark.parametrize("source", sources("real_scan"))
def test_a_recording_by_other_programs_is_read(source, tmp_path):
    is_real = source == "real"
    expected = RECORDED if is_real else make_recording(tmp_path)
    folder = DATA / "real_scan" if is_real else tmp_path
    scene = read(folder / "scene_milk_carton_clorox.pcd")
    assert scene.resolution == (COLUMNS, ROWS) and len(scene.points) == expected.scene
    assert expected.scene < COLUMNS * ROWS
    # Neighbours in the picture are neighbours in space: pixels and points belong together.
    steps = np.linalg.norm(np.diff(scene.points, axis=0), axis=1)[np.diff(scene.pixels) == 1]
    assert np.median(steps) < 0.01
    model = read(folder / "milk.pcd")
    assert len(model.points) == expected.taught and model.resolution is None
