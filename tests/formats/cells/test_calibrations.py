"""The record of a calibration in a cell file, and the folder of scans with joint values."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import on_arm_cell
from shipped import shipped

from workbench.formats.cells.calibrations import (
    CALIBRATION_FILE,
    ScannedPose,
    read_scanned_poses,
    write_scanned_poses,
)
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.gui.shared.movable_frames import SCANNER, move_frame
from workbench.model.calibration import BallPlate, CalibrationRecord
from workbench.model.derived.scanner_poses import with_scanner_at
from workbench.model.digest import canonical, digest_of
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.robot import AxisMapping

SHIPPED = shipped("yumi")
ARM = SHIPPED.arms[0]


def calibrated(cell, at=1_790_000_000.0, by="Anna"):
    T = pose_from_rpy((0.402, 0.012, 0.88), (3.1, 0.01, 1.5))
    record = CalibrationRecord(at, by, 8, 0.000123)
    return replace(cell, scanner=replace(cell.scanner, T_world_scanner=T, calibration=record))


def test_a_calibration_is_written_into_the_cell_file_and_comments_stay(cell_file):
    before = cell_file.read_text()
    save_cell(cell_file, calibrated(read_cell(cell_file)))
    text, record = cell_file.read_text(), read_cell(cell_file).scanner.calibration
    assert (record.at, record.by, record.poses) == (1_790_000_000.0, "Anna", 8)
    assert record.rms == pytest.approx(0.000123)
    assert 'at = "2026-09-21T14:13:20Z"' in text
    comments = [line for line in before.splitlines() if line.startswith("#")]
    assert all(comment in text for comment in comments)
    again = calibrated(read_cell(cell_file), by="Ben")
    save_cell(cell_file, again)
    assert read_cell(cell_file).scanner.calibration.by == "Ben"
    assert cell_file.read_text().count("[scanner.calibration]") == 1


def test_how_sure_a_calibration_is_stays_with_the_cell_where_it_is_known(cell_file):
    cell = calibrated(read_cell(cell_file))
    record = replace(cell.scanner.calibration, position_error=0.00042, angle_error=0.0003)
    save_cell(cell_file, replace(cell, scanner=replace(cell.scanner, calibration=record)))
    kept = read_cell(cell_file).scanner.calibration
    assert kept.position_error == pytest.approx(0.00042)
    assert kept.angle_error == pytest.approx(0.0003, rel=1e-3)
    save_cell(cell_file, calibrated(read_cell(cell_file), by="Ben"))
    kept = read_cell(cell_file).scanner.calibration
    assert (kept.position_error, kept.angle_error) == (None, None)
    assert "sure_" not in cell_file.read_text()


def test_a_record_without_them_has_the_digest_that_it_always_had():
    record = CalibrationRecord(0.0, "Ada", 8, 0.0001)
    said = canonical(record)
    assert "position_error" not in str(said) and "angle_error" not in str(said)
    assert digest_of(record) != digest_of(replace(record, position_error=0.001))


def test_a_scanner_moved_by_hand_is_not_calibrated_any_more(cell_file):
    save_cell(cell_file, calibrated(read_cell(cell_file)))
    cell = read_cell(cell_file)
    save_cell(cell_file, move_frame(cell, SCANNER, pose_from_rpy((0.4, 0, 0.9), (3.1, 0, 1.5))))
    assert read_cell(cell_file).scanner.calibration is None
    assert "calibration]" not in cell_file.read_text()


@pytest.mark.parametrize(
    ("record", "problem"),
    [
        ('at = "yesterday"\nby = "A"\nposes = 8\nrms_mm = 0.1', "is no time such as"),
        ('at = "2026-01-01"\nby = ""\nposes = 8\nrms_mm = 0.1', "by: is an empty text"),
        ('at = "2026-01-01"\nby = "A"\nposes = 0\nrms_mm = 0.1', "poses"),
        ('at = "2026-01-01"\nby = "A"\nposes = 8', "rms_mm: is missing"),
        ('at = "2026-01-01"\nby = "A"\nposes = 8\nrms_mm = 0.1\nwho = 1', "who: is not known"),
    ],
)
def test_a_wrong_record_is_refused_with_its_place(cell_file, record, problem):
    cell_file.write_text(cell_file.read_text() + f"\n[scanner.calibration]\n{record}\n")
    with pytest.raises(FileError, match=problem):
        read_cell(cell_file)


def test_a_folder_of_poses_comes_from_the_cell_file(cell_file):
    text = cell_file.read_text()
    cell_file.write_text(text + '\n[detections]\nsource = "folder"\npath = "poses"\n')
    assert read_cell(cell_file).poses_folder.path == str(cell_file.parent / "poses")
    cell_file.write_text(text + '\n[detections]\npath = "poses"\npart = "nut"\n')
    with pytest.raises(FileError, match=r"detections.part: is not one of keyed_cylinder"):
        read_cell(cell_file)
    cell_file.write_text(text + '\n[detections]\nsource = "mail"\npath = "poses"\n')
    with pytest.raises(FileError, match="'mail' is not one of folder"):
        read_cell(cell_file)


def scans(folder, count=3):
    rng = np.random.default_rng(0)
    poses = []
    for number in range(count):
        scan = folder / f"{number}.ply"
        scan.write_bytes(b"ply")
        poses.append(ScannedPose(scan, np.asarray(ARM.home) + rng.uniform(-0.2, 0.2, 7)))
    return poses


def test_joint_values_come_back_in_chain_order(tmp_path):
    poses, plate = scans(tmp_path), BallPlate(0.01, np.array([0.05, 0.07, 0.09]))
    write_scanned_poses(tmp_path, SHIPPED, ARM, plate, poses)
    found = read_scanned_poses(tmp_path, SHIPPED)
    assert (found.arm, found.unit) == ("right", "m")
    assert found.plate.radius == plate.radius and np.allclose(found.plate.sides, plate.sides)
    for one, other in zip(found.poses, poses, strict=True):
        assert one.scan == other.scan
        assert np.allclose(one.q, other.q, atol=1e-6)


def test_joint_values_are_those_that_a_controller_with_coupled_axes_shows(tmp_path):
    coupling = np.eye(7)
    coupling[2, 1] = -1.0
    arm = replace(ARM, mapping=AxisMapping(coupling, np.zeros(7)))
    cell = replace(SHIPPED, arms=(arm, *SHIPPED.arms[1:]))
    (pose, *_) = scans(tmp_path)
    write_scanned_poses(tmp_path, cell, arm, BallPlate(), [pose])
    (line,) = [
        one for one in (tmp_path / CALIBRATION_FILE).read_text().splitlines() if "joints_deg" in one
    ]
    shown = [float(word) for word in line.partition("[")[2].rstrip("]").split(",")]
    axes = np.rad2deg(arm.to_axes(pose.q))
    assert np.allclose(shown[2], axes[2] - axes[1], atol=1e-3)
    (found,) = read_scanned_poses(tmp_path, cell).poses
    assert np.allclose(found.q, pose.q, atol=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('format = "workbench-calibration/1"', 'format = "other"', "format"),
        ('arm = "right"', 'arm = "middle"', "arm: 'middle' is not one of right, left"),
        ('unit = "m"', 'unit = "yard"', "unit"),
        ("ball_mm = 30", "ball_mm = -3", r"plate.ball_mm"),
        ("sides_mm = [80, 100, 120]", "sides_mm = [80, 80, 120]", "plate.sides_mm: .*differ"),
        ('scan = "0.ply"', 'scan = "9.ply"', r"pose\[1\].scan: there is no file '9.ply'"),
        ('scan = "0.ply"\njoints_deg = [', 'scan = "0.ply"\njoints_deg = [1, ', "7 numbers"),
        ('scan = "0.ply"\njoints_deg = [', 'scan = "0.ply"\nangles = [', "joints_deg: is missing"),
    ],
)
def test_a_wrong_folder_is_refused_with_file_and_key(tmp_path, old, new, problem):
    write_scanned_poses(tmp_path, SHIPPED, ARM, BallPlate(), scans(tmp_path))
    text = (tmp_path / CALIBRATION_FILE).read_text()
    assert old in text
    (tmp_path / CALIBRATION_FILE).write_text(text.replace(old, new))
    with pytest.raises(FileError, match=problem) as refused:
        read_scanned_poses(tmp_path, SHIPPED)
    assert CALIBRATION_FILE in str(refused.value)


def test_an_arm_that_cannot_stand_there_is_refused(tmp_path):
    (pose, *_) = scans(tmp_path)
    write_scanned_poses(
        tmp_path, SHIPPED, ARM, BallPlate(), [ScannedPose(pose.scan, np.full(7, 6.0))]
    )
    with pytest.raises(FileError, match="outside the limits of the right arm"):
        read_scanned_poses(tmp_path, SHIPPED)


def test_no_folder_and_no_poses_are_refused(tmp_path):
    with pytest.raises(InputError, match=CALIBRATION_FILE):
        read_scanned_poses(tmp_path / "nowhere", SHIPPED)
    write_scanned_poses(tmp_path, SHIPPED, ARM, BallPlate(), [])
    with pytest.raises(FileError, match="1 to 60 poses are expected, 0 are given"):
        read_scanned_poses(tmp_path, SHIPPED)


def test_the_covariance_stays_with_the_cell_and_one_that_is_none_is_refused(cell_file):
    cell = calibrated(read_cell(cell_file))
    half = np.random.default_rng(0).normal(0, [3e-4] * 3 + [5e-4] * 3, (20, 6))
    covariance = np.cov(half.T)
    record = replace(cell.scanner.calibration, covariance=covariance)
    save_cell(cell_file, replace(cell, scanner=replace(cell.scanner, calibration=record)))
    kept = read_cell(cell_file).scanner.calibration.covariance
    assert np.allclose(kept, covariance, rtol=1e-6, atol=0)
    assert digest_of(record) != digest_of(cell.scanner.calibration)
    first = str(float(f"{covariance[0, 0] * 1e6:.9g}"))
    text = cell_file.read_text()
    assert first in text
    cell_file.write_text(text.replace(first, f"-{first}"))
    with pytest.raises(FileError, match=r"scanner.calibration.covariance: is none: along some"):
        read_cell(cell_file)


def test_a_plate_that_stands_is_of_the_arm_with_the_scanner_alone(tmp_path):
    cell = on_arm_cell()
    left = replace(cell.arm("left"), home=np.asarray(ARM.home))
    (pose, *_) = scans(tmp_path)
    write_scanned_poses(tmp_path, cell, left, BallPlate(), [pose])
    text = (tmp_path / CALIBRATION_FILE).read_text()
    assert "stands = true" in text and read_scanned_poses(tmp_path, cell).arm == "left"
    with pytest.raises(FileError, match=r"plate.stands: the scanner of this cell stands"):
        read_scanned_poses(tmp_path, SHIPPED)
    (tmp_path / CALIBRATION_FILE).write_text(text.replace("stands = true", "stands = false"))
    with pytest.raises(FileError, match=r"plate.stands: an arm carries the scanner"):
        read_scanned_poses(tmp_path, cell)
    (tmp_path / CALIBRATION_FILE).write_text(text.replace('arm = "left"', 'arm = "right"'))
    with pytest.raises(FileError, match="arm: 'right' is not one of left"):
        read_scanned_poses(tmp_path, cell)


@pytest.mark.parametrize("robot", ["yumi", "tx2_90"])
def test_a_calibrated_scanner_on_an_arm_is_written_and_its_views_stay(tmp_path, robot):
    shutil.copytree(find("robots", robot), tmp_path / robot)
    file = tmp_path / robot / "on_arm.toml"
    cell = read_cell(file)
    moved = with_scanner_at(cell, cell.scanner.T_world_scanner * pose_from_rpy((0.01, 0, 0.02)))
    record = CalibrationRecord(1_000.0, "Ada", 8, 1e-4, 2e-4, 1e-3, np.diag([1e-8] * 6))
    save_cell(file, replace(moved, scanner=replace(moved.scanner, calibration=record)))
    again = read_cell(file)
    there, want = again.scanner.on_arm, moved.scanner.on_arm
    assert np.abs(there.T_flange_scanner.homogeneous - want.T_flange_scanner.homogeneous).max() < (
        1e-6
    )
    assert again.scanner.calibration.by == "Ada"
    assert np.allclose(again.scanner.calibration.covariance, record.covariance)
    for one, other in zip(there.views, cell.scanner.on_arm.views, strict=True):
        assert np.array_equal(one.q, other.q)
    assert np.array_equal(again.arm(there.arm).home, cell.arm(there.arm).home)
