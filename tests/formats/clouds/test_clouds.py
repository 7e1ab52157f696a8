from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from mutations import mutated, only_file_errors

from workbench.formats.clouds.scans import read_cloud, write_cloud
from workbench.model.errors import FileError
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.scan import Scan

T = pose_from_rpy([0.4, 0.0, 0.9], (np.pi, 0, 0))
POINTS = np.array([[0.1, 0.2, 0.8], [-0.1, 0.05, 0.9], [0.0, 0.0, 1.0]])
ENCODINGS = ("ascii", "binary_little_endian", "binary_big_endian")


def ply(
    points: Floats,
    encoding: str = "ascii",
    *,
    kind: str = "float",
    extra: bool = False,
    count: int | str | None = None,
    notes: tuple[str, ...] = (),
    before: tuple[str, ...] = (),
    line_end: str = "\n",
) -> bytes:
    """A PLY file as other programs write it; `extra` puts colours and normals around xyz."""
    order = ">" if encoding.endswith("big_endian") else "<"
    number = order + ("f4" if kind == "float" else "f8")
    fields = [("x", number), ("y", number), ("z", number)]
    if extra:
        fields = [("red", "u1"), *fields, ("nx", order + "f4"), ("quality", order + "i2")]
    names = {"u1": "uchar", "i2": "short", "f4": "float", "f8": "double"}
    header = [
        "ply",
        f"format {encoding} 1.0",
        "comment made by Müller",
        *(f"obj_info {note}" for note in notes),
        *before,
        f"element vertex {len(points) if count is None else count}",
        *(f"property {names[kind[-2:]]} {name}" for name, kind in fields),
        "element face 0",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    rows = np.zeros(len(points), dtype=fields)
    for column, name in enumerate("xyz"):
        rows[name] = points[:, column]
    body = (
        line_end.join(" ".join(str(value) for value in row) for row in rows.tolist()).encode()
        + line_end.encode()
        if encoding == "ascii"
        else rows.tobytes()
    )
    return (line_end.join(header) + line_end).encode("utf-8") + body


def read(tmp_path: Path, content: bytes, **options: Any) -> Scan:
    (tmp_path / "scan.ply").write_bytes(content)
    return read_cloud(tmp_path / "scan.ply", T, **options)


@pytest.mark.parametrize("line_end", ["\n", "\r\n"])
@pytest.mark.parametrize("extra", [False, True])
@pytest.mark.parametrize("kind", ["float", "double"])
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_clouds_of_every_encoding_are_read(
    tmp_path: Path, encoding: str, kind: str, extra: bool, line_end: str
) -> None:
    scan = read(tmp_path, ply(POINTS, encoding, kind=kind, extra=extra, line_end=line_end))
    np.testing.assert_allclose(scan.points, POINTS, rtol=1e-6)
    assert scan.T_world_scanner == T
    assert scan.source == "scan.ply"
    assert scan.pixels is None and scan.resolution is None


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_an_element_ahead_of_the_vertices_is_passed_over(tmp_path: Path, encoding: str) -> None:
    content = ply(POINTS, encoding, before=("element camera 1", "property float f"))
    head, _, body = content.partition(b"end_header\n")
    camera = b"1.5\n" if encoding == "ascii" else b"abcd"
    scan = read(tmp_path, head + b"end_header\n" + camera + body)
    np.testing.assert_allclose(scan.points, POINTS, rtol=1e-6)


def test_blank_lines_between_points_do_not_count(tmp_path: Path) -> None:
    content = ply(POINTS).replace(b"\n", b"\n\n  \n").replace(b"\n\n  \n", b"\n", 9)
    np.testing.assert_allclose(read(tmp_path, content).points, POINTS, rtol=1e-6)


def test_millimetres_become_metres(tmp_path: Path) -> None:
    scan = read(tmp_path, ply(POINTS * 1000), unit="mm")
    np.testing.assert_allclose(scan.points, POINTS, rtol=1e-6)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("nothing", [[np.nan] * 3, [0, np.inf, 1], [-np.inf, 0, 0], [0, -0.0, 0]])
def test_points_without_a_measurement_are_dropped(
    tmp_path: Path, nothing: list[float], encoding: str
) -> None:
    scan = read(tmp_path, ply(np.array([nothing, *POINTS, nothing]), encoding))
    np.testing.assert_allclose(scan.points, POINTS, rtol=1e-6)


def test_one_point_for_each_pixel_is_an_organised_cloud(tmp_path: Path) -> None:
    points = np.array([POINTS[0], [np.nan] * 3, POINTS[1], POINTS[2]])
    scan = read(tmp_path, ply(points, notes=("resolution 2 2",)))
    assert scan.resolution == (2, 2)
    assert scan.pixels is not None and scan.pixels.tolist() == [0, 2, 3]


def test_a_scan_comes_back_as_the_same_scan(tmp_path: Path) -> None:
    scan = Scan(POINTS / 3, T, "simulated", np.array([5, 6, 11]), (4, 3))
    write_cloud(tmp_path / "scan.ply", scan)
    assert read_cloud(tmp_path / "scan.ply", T).digest == scan.digest


BAD = {
    "empty file": (b"", "is neither a PLY nor a PCD file"),
    "not PLY": (b"solid cube\n" * 10, "is neither a PLY nor a PCD file"),
    "picture": (b"\x89PNG\r\n\x1a\n" + bytes(200), "is neither a PLY nor a PCD file"),
    "header without end": (b"ply\nformat ascii 1.0\n" + b"comment\n" * 90_000, "no line `end_head"),
    "unknown format": (ply(POINTS, "binary_middle_endian"), "line 2: .* has no place"),
    "no format": (ply(POINTS).replace(b"format ascii 1.0\n", b""), "names no format"),
    "no vertices": (ply(POINTS).replace(b"element vertex", b"element edge"), "one element vertex"),
    "no z": (ply(POINTS).replace(b"float z", b"float w"), "have no property z"),
    "x twice": (ply(POINTS).replace(b"float y", b"float x\nproperty float y"), "'x' is declared"),
    "unknown type": (ply(POINTS).replace(b"float y", b"real y"), "line 6: 'property real y'"),
    "list": (ply(POINTS).replace(b"float y", b"list uchar int y"), "'y': vertices with lists"),
    "list ahead": (
        ply(POINTS, "binary_little_endian", before=("element f 1", "property list int int i")),
        "element 'f': lists ahead",
    ),
    "negative count": (ply(POINTS, count=-3), "'element vertex -3' has no place"),
    "no points": (ply(POINTS[:0]), "empty cloud: it declares 0 points"),
    "not measured": (ply(POINTS * np.nan), "empty cloud: none of its 3 points"),
    "word": (
        ply(POINTS, kind="double").replace(b"0.9", b"far"),
        "a point is not a row of numbers: .*'far'",
    ),
    "missing number": (ply(POINTS).replace(b"0.0 1.0\n", b"1.0\n"), "a point is not a row"),
    "metres for millimetres": (ply(POINTS * 1000), "in another unit"),
    "unreadable resolution": (ply(POINTS, notes=("resolution 640x480",)), "'resolution 640x480'"),
    "absurd resolution": (ply(POINTS, notes=("resolution 999999 999999",)), "no size of an image"),
    "no pixels": (ply(POINTS, notes=("resolution 4 3",)), "resolution of 4 x 3, no property pixel"),
}


@pytest.mark.parametrize("bad", BAD)
def test_a_bad_cloud_is_refused_with_the_reason(tmp_path: Path, bad: str) -> None:
    content, message = BAD[bad]
    with pytest.raises(FileError, match=message):
        read(tmp_path, content)


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_cloud_that_is_cut_off_is_refused(tmp_path: Path, encoding: str) -> None:
    content = ply(POINTS, encoding)
    end = content.index(b"end_header\n") + len(b"end_header\n")
    for length in (end, end + 1, len(content) - 8):
        with pytest.raises(FileError, match=r"declares 3 points and holds|not a row of numbers"):
            read(tmp_path, content[:length])


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize("count", [4, 9_999_999, 10**9, 10**17, 10**30])
def test_a_declared_count_alone_takes_no_memory(tmp_path: Path, encoding: str, count: int) -> None:
    with pytest.raises(FileError, match=r"declares|has no place"):
        read(tmp_path, ply(POINTS, encoding, count=count))


@pytest.mark.parametrize("encoding", ENCODINGS)
def test_a_count_ahead_of_the_vertices_takes_no_memory(tmp_path: Path, encoding: str) -> None:
    for before in ("property double f", "comment nothing"):
        many = [f"element camera-{k} {10**17}" for k in range(100)]
        content = ply(POINTS, encoding, before=(*many, before))
        try:
            read(tmp_path, content)
        except FileError as error:
            assert "is cut off" in str(error)
        else:
            assert before.startswith("comment") and encoding != "ascii"


@pytest.mark.parametrize(("pixel", "message"), [(12, "12 is not a whole"), (-1, "-1 is not")])
def test_a_pixel_outside_the_image_is_refused(tmp_path: Path, pixel: int, message: str) -> None:
    write_cloud(tmp_path / "scan.ply", Scan(POINTS, T, "s", np.array([5, 6, pixel]), (4, 3)))
    with pytest.raises(FileError, match=message):
        read_cloud(tmp_path / "scan.ply", T)


def test_a_pixel_seen_twice_is_refused(tmp_path: Path) -> None:
    write_cloud(tmp_path / "scan.ply", Scan(POINTS, T, "s", np.array([5, 6, 5]), (4, 3)))
    with pytest.raises(FileError, match="two points claim the same pixel"):
        read_cloud(tmp_path / "scan.ply", T)


def test_an_unknown_unit_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="unit 'cm' is not one of mm, m, inch"):
        read(tmp_path, ply(POINTS), unit="cm")


coordinates = st.floats(-50, 50).filter(lambda x: abs(x) > 0.01)


@settings(
    deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture]
)
@given(
    points=arrays.arrays(float, st.tuples(st.integers(1, 12), st.just(3)), elements=coordinates),
    organised=st.booleans(),
    turn=st.tuples(*[st.floats(-3, 3)] * 3),
)
def test_any_scan_survives_its_file(
    tmp_path: Path, points: Floats, organised: bool, turn: tuple[float, float, float]
) -> None:
    T_world_scanner: pin.SE3 = pose_from_rpy(turn, turn)
    pixels = np.arange(len(points))[::-1] * 2
    scan = Scan(
        points,
        T_world_scanner,
        "drawn",
        pixels if organised else None,
        (6, 4) if organised else None,
    )
    write_cloud(tmp_path / "scan.ply", scan)
    assert read_cloud(tmp_path / "scan.ply", T_world_scanner).digest == scan.digest


@settings(
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    max_examples=400,
)
@given(data=st.data())
def test_only_file_errors_come_out_of_broken_clouds(tmp_path: Path, data: st.DataObject) -> None:
    encoding = data.draw(st.sampled_from(ENCODINGS))
    notes = data.draw(st.sampled_from([(), ("resolution 3 1",)]))
    content = data.draw(mutated(ply(POINTS, encoding, extra=True, notes=notes)))
    only_file_errors(tmp_path / "scan.ply", content, lambda path: read_cloud(path, T))
