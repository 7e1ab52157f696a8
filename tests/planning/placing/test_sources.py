"""What scanner and search leave open of where a part lies."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import on_arm_cell

from workbench.formats.cells.reading import read_cell
from workbench.model.calibration import CalibrationRecord
from workbench.model.derived.scanner_poses import flange_at_view, turn_covariance
from workbench.model.scan import Detection
from workbench.planning.placing.sources import (
    CALIBRATION,
    LOCALIZATION,
    calibration_error,
    localization_error,
)


def lying():
    return Detection("part", pin.SE3(np.eye(3), np.array([0.4, 0.1, 0.0])))


def with_record(**errors):
    mount = read_cell("yumi").scanner
    return replace(mount, calibration=CalibrationRecord(0.0, "Ada", 8, 1e-4, **errors))


def test_a_calibration_moves_all_parts_as_one_body():
    """Judged by moving the scanner by many small errors."""
    place, turn = 4e-4, 2e-3
    mount = with_record(position_error=place, angle_error=turn)
    rng = np.random.default_rng(0)
    T, T_world_scanner = lying().T_world_part, mount.T_world_scanner
    off = []
    for _ in range(20_000):
        moved = T_world_scanner * pin.SE3(
            pin.exp3(turn * rng.standard_normal(3)), place * rng.standard_normal(3)
        )
        found = moved * T_world_scanner.inverse() * T
        shift = found.translation - T.translation
        off.append(np.concatenate([shift, pin.log3(found.rotation @ T.rotation.T)]))
    measured = np.cov(np.array(off).T)
    said = calibration_error(mount, lying())
    assert np.allclose(measured, said, atol=0.03 * np.abs(said).max())
    assert np.allclose(np.diag(measured), np.diag(said), rtol=0.05)


def test_what_a_calibration_knows_of_place_and_direction_together_counts():
    """A scanner that may only have turned about the part moves none, however unsure its place."""
    mount = with_record(position_error=1e-3, angle_error=1e-3)
    away = lying().T_world_part.translation - mount.T_world_scanner.translation
    turn = np.array([2e-3, 0.0, 0.0])
    both = np.concatenate([-np.cross(turn, away), turn])
    record = replace(mount.calibration, covariance=np.outer(both, both))
    said = calibration_error(replace(mount, calibration=record), lying())
    assert np.allclose(said[:3, :3], 0.0, atol=1e-15)
    assert said[3, 3] == pytest.approx(4e-6)
    alone = replace(record, covariance=np.diag([1e-6] * 3 + [0.0] * 3))
    said = calibration_error(replace(mount, calibration=alone), lying())
    assert np.allclose(said, np.diag([1e-6] * 3 + [0.0] * 3))


def test_a_cell_that_does_not_say_how_sure_its_calibration_is_takes_what_is_usual():
    usual = with_record(position_error=CALIBRATION[0], angle_error=CALIBRATION[1])
    for mount in (read_cell("yumi").scanner, with_record()):
        assert np.array_equal(calibration_error(mount, lying()), calibration_error(usual, lying()))


def test_a_pose_says_itself_how_sure_it_is_or_is_taken_as_usual():
    known = np.diag(np.arange(1.0, 7.0))
    assert np.array_equal(localization_error(replace(lying(), covariance=known)), known)
    assert np.sqrt(np.diag(localization_error(lying()))) == pytest.approx(
        [LOCALIZATION[0]] * 3 + [LOCALIZATION[1]] * 3
    )


def test_a_scanner_on_an_arm_is_as_sure_at_its_view_whatever_the_axes_of_the_record():
    cell = on_arm_cell()
    sure = np.diag(np.square([1e-4, 2e-4, 3e-4, 1e-3, 2e-3, 3e-3]))
    record = CalibrationRecord(0.0, "Ada", 8, 1e-4, covariance=sure)
    carried = replace(cell.scanner, calibration=record)
    R = flange_at_view(cell.scanner).rotation
    stands = replace(
        carried, on_arm=None, calibration=replace(record, covariance=turn_covariance(sure, R))
    )
    told = calibration_error(carried, lying())
    assert np.allclose(told, calibration_error(stands, lying()))
    assert not np.allclose(told, calibration_error(replace(carried, on_arm=None), lying()))
