"""A scan that nobody has prepared: turned, scaled, of other axes, of something else."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.calibration.first_scan import first_scan
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import CLOUD_AXES, read_scan, write_cloud
from workbench.model.calibration import CalibrationRecord
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import ALL_KINDS, Scan
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize

REAL = Path("../shared/data/real_scan/scene_milk_carton_clorox.pcd")


@pytest.fixture(scope="module", params=["yumi", "tx2_90"])
def cell(request) -> Cell:
    return read_cell(request.param)


@pytest.fixture(scope="module")
def scan(cell) -> Scan:
    return synthesize(cell, pile_of(cell, ALL_KINDS, 4, seed=7), seed=7)


def looked(path: Path, cell: Cell):
    return first_scan(path, path.read_bytes(), cell.scanner, cell.bin)


def off(cell: Cell, T: pin.SE3) -> tuple[float, float]:
    apart = cell.scanner.T_world_scanner.actInv(T)
    return float(np.linalg.norm(apart.translation)), float(np.linalg.norm(pin.log3(apart.rotation)))


@pytest.mark.extensive
@pytest.mark.parametrize("unit", ["m", "mm", "inch"])
@pytest.mark.parametrize("axes", CLOUD_AXES)
def test_unit_and_axes_are_found_and_read_right_from_then_on(cell, scan, tmp_path, unit, axes):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan, unit=unit, axes=axes)
    seen = looked(path, cell)
    assert (seen.mount.unit, seen.mount.cloud_axes) == (unit, axes)
    assert any("unit" in str(one) for one in seen.says) == (unit != "m")
    assert any("cloud_axes" in str(one) for one in seen.says) == (axes != "z_forward")
    again = read_scan(path, seen.mount)
    assert np.allclose(again.points, scan.points, atol=1e-9)


@pytest.mark.parametrize(
    ("position", "rpy"),
    [((0.15, -0.2, 0.1), (0.2, -0.1, 0.7)), ((0.5, 0.4, -0.1), (0.3, 0.3, -1.0))],
)
def test_the_scanner_is_found_where_nobody_has_calibrated_it(cell, scan, tmp_path, position, rpy):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan)
    T_wrong = cell.scanner.T_world_scanner * pose_from_rpy(position, rpy)
    believed = replace(cell, scanner=replace(cell.scanner, T_world_scanner=T_wrong))
    seen = looked(path, believed)
    distance, turn = off(cell, seen.mount.T_world_scanner)
    assert distance < 0.002 and turn < np.deg2rad(0.3)
    assert any("position_mm" in str(one) for one in seen.says)
    assert seen.noise == pytest.approx(cell.scanner.depth_noise, rel=0.2)

    record = CalibrationRecord(at=0.0, by="ada", rms=0.0, poses=8)
    measured = replace(believed, scanner=replace(believed.scanner, calibration=record))
    seen = looked(path, measured)
    assert digest_of(seen.mount.T_world_scanner) == digest_of(T_wrong), "what is measured stays"
    assert any("calibration old" in str(one) for one in seen.says)


def test_a_scan_that_fits_leaves_nothing_to_say(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan)
    seen = looked(path, cell)
    assert seen.says == () and seen.found.T_scanner_bin is not None
    assert off(cell, seen.mount.T_world_scanner)[0] < 0.002


def test_a_bin_of_another_size_is_measured(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan)
    for factors in ((1.5, 1.5, 1.0), (1.0, 1.0, 0.5), (0.7, 0.8, 2.0)):
        other = replace(cell.bin, size=np.asarray(cell.bin.size) * factors)
        seen = looked(path, replace(cell, bin=other))
        assert any("size_mm in [bin]" in str(one) for one in seen.says), seen.says
        assert np.allclose(seen.bin.size, cell.bin.size, atol=0.006)
        assert off(cell, seen.mount.T_world_scanner)[0] < 0.006


def test_a_rim_of_nearly_the_same_size_is_said(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan)
    other = replace(cell.bin, size=np.asarray(cell.bin.size) * (1.0, 1.08, 1.0))
    seen = looked(path, replace(cell, bin=other))
    assert any("size_mm" in str(one) for one in seen.says), seen.says


def test_without_walls_no_rim_says_where_the_scanner_hangs(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan)
    seen = looked(path, replace(cell, bin=replace(cell.bin, has_walls=False)))
    assert seen.found.T_scanner_bin is None and seen.shift == 0.0
    assert [one for one in seen.says if "has no walls" in str(one)]


def test_what_is_no_scan_of_the_cell_is_said(cell, tmp_path):
    path = tmp_path / "scan.ply"
    rng = np.random.default_rng(3)
    T = cell.scanner.T_world_scanner
    write_cloud(path, Scan(rng.uniform(-0.4, 0.4, (5000, 3)) + [0, 0, 0.9], T, "noise"))
    assert any("no bin" in str(one) or "a rim of" in str(one) for one in looked(path, cell).says)
    # Around the scanner, on all its sides: behind it as much as before it.
    ball = rng.normal(size=(5000, 3))
    ball *= 90.0 / np.linalg.norm(ball, axis=1, keepdims=True)
    write_cloud(path, Scan(ball, T, "ball"))
    with pytest.raises(InputError, match="is it a scan of this cell"):
        looked(path, cell)
    path.write_bytes(b"solid")
    with pytest.raises(FileError, match="neither a PLY nor a PCD"):
        looked(path, cell)


def test_a_cloud_behind_the_scanner_is_refused_with_the_key(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan, axes="z_back")
    with pytest.raises(FileError, match="cloud_axes"):
        read_scan(path, cell.scanner)


@pytest.mark.skipif(not REAL.is_file(), reason=f"{REAL} is not there")
def test_a_real_table_is_no_bin():
    seen = looked(REAL, read_cell("yumi"))
    assert (seen.mount.unit, seen.mount.cloud_axes) == ("m", "z_back"), "it looks along -z"
    assert seen.found.T_scanner_bin is None
    assert seen.noise == pytest.approx(0.0014, abs=0.0004)


def test_a_scanner_over_a_floor_without_a_rim_hangs_over_that_floor(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    T_bin_scanner = cell.bin.T_world_bin.actInv(scan.T_world_scanner)
    at = scan.points @ T_bin_scanner.rotation.T + T_bin_scanner.translation
    floor = (np.abs(at[:, :2]) < 0.45 * cell.bin.size[:2]).all(axis=1)
    write_cloud(path, Scan(scan.points[floor], scan.T_world_scanner, "no walls"), axes="z_back")
    wrong = cell.scanner.T_world_scanner * pin.SE3(np.eye(3), np.array([0.02, 0.01, 0.4]))
    mount = replace(cell.scanner, T_world_scanner=wrong, near=0.05, far=0.1, calibration=None)
    seen = looked(path, replace(cell, scanner=mount))
    assert seen.mount.near < T_bin_scanner.translation[2] < seen.mount.far, "the range is told, too"
    assert any("near_mm" in str(one) for one in seen.says)
    assert any("but a floor" in str(one) for one in seen.says)
    T_seen = seen.mount.T_world_scanner
    height = cell.bin.T_world_bin.actInv(T_seen).translation[2]
    assert abs(height - T_bin_scanner.translation[2]) < 0.01
    up = (T_seen.rotation @ cell.scanner.T_world_scanner.rotation.T)[2, 2]
    assert up > np.cos(np.deg2rad(2.0))


def in_bin(cell: Cell, scan: Scan) -> np.ndarray:
    """The points inside of the walls, in the bin's frame."""
    T_bin_scanner = cell.bin.T_world_bin.actInv(scan.T_world_scanner)
    at = scan.points @ T_bin_scanner.rotation.T + T_bin_scanner.translation
    return at[(np.abs(at[:, :2]) < 0.45 * cell.bin.size[:2]).all(axis=1)]


def test_points_in_the_frame_of_the_cell_are_known_by_their_floor(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    # As a driver that knows of the robot writes it: z up, the floor 20 mm under its origin.
    at = np.array([0.5, 0.2, -0.02])
    write_cloud(path, Scan(in_bin(cell, scan) + at, scan.T_world_scanner, "z up"), unit="mm")
    seen = looked(path, replace(cell, scanner=replace(cell.scanner, calibration=None)))
    assert (seen.mount.unit, seen.mount.cloud_axes) == ("mm", "world")
    assert any('cloud_axes = "world"' in str(one) for one in seen.says)
    assert np.abs(seen.bin.T_world_bin.translation - at).max() < 0.02, "in the middle of what lies"
    assert seen.bin.T_world_bin.translation[2] == pytest.approx(at[2], abs=0.003)
    above = seen.bin.T_world_bin.actInv(seen.mount.T_world_scanner).translation
    assert above[2] == pytest.approx((cell.scanner.near + cell.scanner.far) / 2, abs=0.01)
    written = replace(cell, scanner=seen.mount, bin=seen.surface)
    assert looked(path, written).says == ()
    read = read_scan(path, seen.mount)
    T = read.T_world_scanner
    back = read.points @ T.rotation.T + T.translation
    assert np.allclose(back, in_bin(cell, scan) + at, atol=1e-9)


def test_a_bin_is_found_in_points_that_are_in_the_frame_of_the_cell(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    write_cloud(path, scan, axes="world")
    mount = replace(cell.scanner, cloud_axes="world", calibration=None)
    T_bin = cell.bin.T_world_bin * pose_from_rpy((0.03, -0.02, 0), (0, 0, 0.05))
    seen = looked(path, replace(cell, scanner=mount, bin=replace(cell.bin, T_world_bin=T_bin)))
    assert any("the bin appears" in str(one) for one in seen.says)
    assert seen.bin.T_world_bin.isApprox(cell.bin.T_world_bin, 3e-3)
    assert digest_of(seen.mount) == digest_of(mount), "the scanner is where it was"
    assert looked(path, replace(cell, scanner=seen.mount, bin=seen.bin)).says == ()


def test_a_cloud_with_its_origin_at_a_floor_that_leans_is_refused(cell, scan, tmp_path):
    path = tmp_path / "scan.ply"
    leaning = in_bin(cell, scan) @ pose_from_rpy((0, 0, 0), (0.12, 0, 0)).rotation.T
    write_cloud(path, Scan(leaning + [0.0, 0.0, 0.04], scan.T_world_scanner, "leaning"))
    mount = replace(cell.scanner, near=0.01, far=0.3, calibration=None)
    with pytest.raises(InputError, match="in the scanner's frame"):
        looked(path, replace(cell, scanner=mount))
