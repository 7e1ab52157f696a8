"""Several scanners as one: all points in one world, parts that only one sees, one that fails."""

import time
from dataclasses import replace
from datetime import UTC, datetime

import numpy as np
import pytest
from scanner_calls import SCAN, cell_with
from waiting import PATIENCE

from workbench.devices.scanners.merged import MergedScanner
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import write_cloud
from workbench.model.cell import CalibrationRecord, Cell
from workbench.model.errors import FileError, JobCancelled, LinkError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Scan
from workbench.perception.built_in import PointPairs
from workbench.perception.simulation.piles import pile_of
from workbench.plugins.options import NoOptions
from workbench.plugins.progress import never, silent
from workbench.plugins.scanner import ScanRequest, scanner_of
from workbench.testing import check_scanner

SEED, PARTS = 1, 6

WHOLE = """[scanner]
position_mm = [410, 0, 895]
rpy_deg = [180, 0, 90]
field_of_view_deg = 26
near_mm = 500
far_mm = 1300
source = "merged"
address = "views"
[scanner.options]
views = "{views}"
"""

SIMULATED = """[scanner]
position_mm = [410, {y}, 895]
rpy_deg = [{roll}, 0, 90]
resolution = [400, 480]
field_of_view_deg = {wide}
near_mm = 500
far_mm = 1300
"""

OF_A_FOLDER = """[scanner]
position_mm = [{x}, 0, 900]
rpy_deg = [180, 0, {yaw}]
field_of_view_deg = 40
source = "folder"
address = "{name}"
patience_s = {patience}
{more}
"""


def calibrated(days: float) -> str:
    at = datetime.fromtimestamp(time.time() - days * 86_400, UTC).isoformat()
    return f'[scanner.calibration]\nat = "{at}"\nby = "Ada"\nposes = 8\nrms_mm = 0.1\n'


@pytest.fixture
def merged(tmp_path):
    """A cell whose scanner is made of the views in these files."""
    (tmp_path / "views").mkdir()

    def make(names: str = "", **views: str) -> Cell:
        for name, text in views.items():
            (tmp_path / "views" / f"{name}.toml").write_text(text)
        names = names or ", ".join(f"{name}.toml" for name in views)
        return read_cell(cell_with(tmp_path, WHOLE.format(views=names)))

    return make


@pytest.fixture
def halves(merged):
    """Two simulated scanners over the ends of the bin: each sees one of them, not the other."""
    return merged(
        left=SIMULATED.format(y=95, roll=180, wide=9),
        right=SIMULATED.format(y=-95, roll=180, wide=9),
    )


def found(scan: Scan, cell: Cell) -> list[np.ndarray]:
    """Where parts are found, in the world [m]."""
    result = PointPairs(NoOptions()).find(
        scan, cell, seed=1, detail=1.0, report=silent, cancelled=never
    )
    return [one.T_world_part.translation for one in result.detections]


def holds(places: list[np.ndarray], place: np.ndarray) -> bool:
    return any(np.linalg.norm(one - place) < 0.002 for one in places)


@pytest.mark.extensive
def test_parts_that_only_one_scanner_sees_are_found_in_all_scans_together(halves, tmp_path):
    truth = [one.T_world_part.translation for one in pile_of(halves, "", PARTS, seed=SEED)]
    request = ScanRequest(SEED, PARTS)
    whole = scanner_of(halves).scan(request, silent, never)
    assert (whole.pixels, whole.resolution) == (None, None), "there is no image of both"
    places = [found(whole, halves)]
    for name in ("left", "right"):
        alone = read_cell(cell_with(tmp_path, (tmp_path / "views" / f"{name}.toml").read_text()))
        places.append(found(scanner_of(alone).scan(request, silent, never), alone))
    together, left, right = ([holds(those, one) for one in truth] for those in places)
    assert all(together) and len(places[0]) == PARTS
    assert any(a and not b for a, b in zip(left, right, strict=True))
    assert any(b and not a for a, b in zip(left, right, strict=True))
    assert not all(a or b for a, b in zip(left, right, strict=True)), "nothing is won by both"


def test_it_keeps_the_promises_of_its_seam(halves):
    scan = check_scanner(MergedScanner, halves)
    assert "of left.toml" in scan.source and "of right.toml" in scan.source


@pytest.fixture
def folders(merged, tmp_path):
    """Two scanners that write files, hanging and turned otherwise."""

    def make(more: str = calibrated(3), patience: float = PATIENCE) -> Cell:
        for name in ("a", "b"):
            (tmp_path / "views" / name).mkdir(exist_ok=True)
        first = OF_A_FOLDER.format(name="a", x=300, yaw=90, patience=PATIENCE, more=calibrated(3))
        other = OF_A_FOLDER.format(name="b", x=500, yaw=-45, patience=patience, more=more)
        return merged(a=first, b=other)

    return make


def test_points_are_where_the_poses_of_the_views_put_them(folders, tmp_path):
    cell, told = folders(), list[tuple[float, str]]()
    world = pose_from_rpy((0.4, 0, 0.9), (np.pi, 0, 0))
    Ts = [
        pose_from_rpy((0.3, 0, 0.9), (np.pi, 0, np.pi / 2)),
        pose_from_rpy((0.5, 0, 0.9), (np.pi, 0, -np.pi / 4)),
    ]
    points = SCAN.points @ world.rotation.T + world.translation
    halves = (points[:300], points[300:])
    wanted = dict(zip("ab", zip(Ts, halves, strict=True), strict=True))

    def report(done: float, note: str) -> None:
        told.append((done, note))
        name = note[0]
        if name in wanted:
            T, mine = wanted.pop(name)
            seen = (mine - T.translation) @ T.rotation
            write_cloud(tmp_path / "views" / name / f"{len(told)}.ply", Scan(seen, T, name))

    scan = scanner_of(cell).scan(ScanRequest(), report, never)
    assert scan.T_world_scanner.isApprox(cell.scanner.T_world_scanner)
    np.testing.assert_allclose(scan.points_world, points, atol=1e-9)
    assert scan.source == "merged: 300 of a.toml, 200 of b.toml"
    shares = [share for share, _ in told]
    assert shares == sorted(shares) and shares[-1] >= 0.5
    # Where the whole is looked at from moves no point.
    moved = tmp_path / "cell.toml"
    moved.write_text(moved.read_text().replace("[410, 0, 895]", "[350, 50, 1000]"))
    wanted.update(zip("ab", zip(Ts, halves, strict=True), strict=True))
    again = scanner_of(read_cell(moved)).scan(ScanRequest(), report, never)
    np.testing.assert_allclose(again.points_world, points, atol=1e-9)


def test_a_view_that_gives_no_scan_leaves_none(folders, tmp_path):
    def report(done: float, note: str) -> None:
        if note.startswith("a.toml"):
            write_cloud(tmp_path / "views" / "a" / f"{time.time()}.ply", SCAN)

    scanner = scanner_of(folders(patience=0.3))
    with pytest.raises(LinkError, match=r"view b.toml: no new PLY .* within 0.3 s"):
        scanner.scan(ScanRequest(), report, never)

    def broken(done: float, note: str) -> None:
        report(done, note)
        file = tmp_path / "views" / "b" / "scan.ply"
        if note.startswith("b.toml") and not file.exists():
            file.write_text("no cloud")

    with pytest.raises(LinkError, match=r"view b.toml: .*scan.ply: is neither a PLY nor"):
        scanner_of(folders()).scan(ScanRequest(), broken, never)


def test_a_person_can_end_it_while_any_view_is_waited_for(folders, tmp_path):
    over: list[bool] = []

    def report(done: float, note: str) -> None:
        if note.startswith("a.toml"):
            write_cloud(tmp_path / "views" / "a" / f"{time.time()}.ply", SCAN)
        if note.startswith("b.toml"):
            over.append(True)

    with pytest.raises(JobCancelled):
        scanner_of(folders()).scan(ScanRequest(), report, lambda: bool(over))


def test_a_view_whose_pose_nobody_has_measured_is_not_taken(folders):
    with pytest.raises(LinkError, match=r"view b.toml: its pose was never calibrated"):
        scanner_of(folders(more="")).scan(ScanRequest(), silent, never)
    old = f"calibration_days = 30\n{calibrated(40)}"
    with pytest.raises(LinkError, match=r"b.toml: calibrated 40 days ago; 30 are"):
        scanner_of(folders(more=old)).scan(ScanRequest(), silent, never)


def test_it_does_not_see_while_arms_move(tmp_path):
    text = WHOLE.format(views="a.toml").replace('"merged"', '"merged"\nwhile_moving = true')
    with pytest.raises(
        FileError, match=r"scanner.while_moving: a merged scanner sees from several"
    ):
        read_cell(cell_with(tmp_path, text))


def test_only_its_views_are_calibrated(folders, tmp_path):
    text = WHOLE.format(views="a.toml b.toml")
    folders()
    with pytest.raises(FileError, match=r"scanner.calibration: a merged scanner has none"):
        read_cell(cell_with(tmp_path, text + calibrated(1)))
    path = cell_with(tmp_path, text)
    cell = read_cell(path)
    record = CalibrationRecord(1.7e9, "Ada", 8, 0.0001)
    measured = replace(cell, scanner=replace(cell.scanner, calibration=record))
    with pytest.raises(FileError, match=r"not written: key scanner.calibration: a merged scanner"):
        save_cell(path, measured)
    assert read_cell(path).digest == cell.digest


VIEW = SIMULATED.format(y=95, roll=180, wide=9)


@pytest.mark.parametrize(
    ("names", "views", "told"),
    [
        ("a.toml", {"a": VIEW}, "views: 2 to 8 different files are expected, not 'a.toml'"),
        ("a.toml a.toml", {"a": VIEW}, "views: 2 to 8 different files"),
        ("a.toml b.toml", {"a": VIEW}, r"views/b.toml: .*No such file"),
        ("a.toml ../b.toml", {"a": VIEW}, "views: names of files in `address` are"),
        ("", {"a": VIEW, "b": WHOLE.format(views="a.toml b.toml")}, "b.toml.*a view is one"),
        ("", {"a": VIEW, "b": VIEW.replace("near_mm = 500", "near_mm = 0")}, "b.toml.*near_mm"),
        ("", {"a": VIEW, "b": 'name = "b"'}, "b.toml.*scanner"),
    ],
)
def test_views_that_are_none_are_refused_when_the_cell_is_read(merged, names, views, told):
    with pytest.raises(FileError, match=told):
        merged(names, **views)
