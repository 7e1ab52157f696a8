"""Sessions of some days, read again: what they say of the scanner since it was calibrated."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import at_view, on_arm_cell, with_lower_view
from line import Line

from workbench.app.calibration.drift_words import drift_words
from workbench.app.core.command import Entry
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import ROBOT_LINK, WORKER
from workbench.app.picking.facts import with_facts
from workbench.app.picking.pallets import at_rest
from workbench.app.picking.pipeline import plan_pick
from workbench.app.records.record import command_form, entry_record
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import open_journal
from workbench.app.records.sessions import cell_of, new_session
from workbench.app.review.scanner_drift import of_session, recorded_drift, refined_cell
from workbench.formats.cells.reading import read_cell
from workbench.model.calibration import CalibrationRecord
from workbench.model.derived.by_view import with_view
from workbench.model.derived.scanner_poses import calibration_covariance, with_scanner_at
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.calibration.drift import DAY
from workbench.perception.calibration.things import motion_of
from workbench.perception.simulation.synthesize import synthesize

DRIFT = np.array([0, 0, 0.001, 0.001, 0, 0])


@pytest.fixture(scope="module")
def cell():
    yumi = read_cell("yumi")
    record = CalibrationRecord(DAY, "Ada", 8, 2e-4, 5e-4, np.deg2rad(0.05))
    mount = replace(yumi.scanner, resolution=(160, 120), calibration=record)
    return replace(yumi, scanner=mount)


@pytest.fixture(scope="module")
def sessions(cell, tmp_path_factory):
    """One a day, from the calibration on; after five days somebody knocks at the mount."""
    root = tmp_path_factory.mktemp("sessions")
    for day in range(10):
        moved = motion_of(DRIFT * (day >= 5), cell.bin.T_world_bin.translation)
        there = replace(cell.scanner, T_world_scanner=moved * cell.scanner.T_world_scanner)
        scan = synthesize(replace(cell, scanner=there), (), seed=day)
        at = (day + 1.5) * DAY
        session = Days(cell, root, at)
        session.scan(at, replace(scan, T_world_scanner=cell.scanner.T_world_scanner))
        session.close()
    return root


class Days:
    """A session that is written as it goes, at times that are said."""

    def __init__(self, cell, root, at=1.5 * DAY):
        self.line = Line(cell)
        self.line.now = at
        self._journal = new_session(root, cell, at)
        self.folder, self.close = self._journal.folder, self._journal.close
        self.line.state = replace(self.line.state, number=1, saved=cell.digest)

    def do(self, command):
        command = with_facts(self.line.state, command)
        state = self.line.do(command)
        machines = {JobEnded: WORKER, LinkEnded: ROBOT_LINK}
        entry = Entry(state.number, self.line.now, machines.get(type(command), "ada"), command)
        record = entry_record(entry, command_form(command), state)
        self._journal.append(record.kind, record.body, record.files)

    def ended(self, result):
        self.do(JobEnded(self.line.state.job.number, result))

    def scan(self, at, scan):
        self.line.now = at
        self.do(TakeScan())
        self.ended(scan)
        return scan


def told(sessions, cell):
    folders = sorted(sessions.iterdir())
    return recorded_drift(folders, cell, lambda done, note: None)


@pytest.mark.extensive
def test_a_scanner_that_was_knocked_is_told_and_taken_over(cell, sessions):
    found = told(sessions, cell)
    assert (found.sessions, found.scans, found.problems) == (10, 10, ())
    assert found.drift.drifted == ("table",)
    assert not found.drift.is_bin_off
    says = " ".join(map(str, drift_words(cell, found.drift)))
    assert "the scanner has drifted since its calibration, as table shows" in says
    assert "only the bin shows x, y and rz" in says

    after = refined_cell(cell, found.drift, 20 * DAY, "Grace")
    truth = motion_of(DRIFT, cell.bin.T_world_bin.translation) * cell.scanner.T_world_scanner
    point = cell.bin.T_world_bin.translation
    off = after.scanner.T_world_scanner.act(truth.actInv(point)) - point
    assert np.abs(off).max() < 2e-4
    record = after.scanner.calibration
    assert (record.by, record.at, record.poses) == ("Grace", 20 * DAY, 8)
    # What nothing tells of a scanner that has moved is known less than before.
    assert record.position_error > 5e-4
    # Days before that are of another pose: nothing is counted twice.
    assert told(sessions, after).scans == 0


@pytest.mark.extensive
def test_a_scanner_that_was_knocked_on_its_arm_is_told_from_its_view(tmp_path):
    on_arm = on_arm_cell()
    record = CalibrationRecord(DAY, "Ada", 8, 2e-4, 5e-4, np.deg2rad(0.05))
    mount = replace(on_arm.scanner, resolution=(160, 120), calibration=record)
    cell = replace(on_arm, scanner=mount)
    middle = cell.bin.T_world_bin.translation
    for day in range(10):
        T = motion_of(DRIFT * (day >= 5), middle) * cell.scanner.T_world_scanner
        scan = synthesize(with_scanner_at(cell, T), (), seed=day)
        at = (day + 1.5) * DAY
        session = Days(cell, tmp_path, at)
        there = cell.scanner.T_world_scanner
        session.scan(at, replace(scan, T_world_scanner=there, joints=at_view(cell)))
        session.close()
    found = told(tmp_path, cell)
    assert found.scans == 10 and "table" in found.drift.drifted
    after = refined_cell(cell, found.drift, 20 * DAY, "Grace")
    truth = motion_of(DRIFT, middle) * cell.scanner.T_world_scanner
    off = after.scanner.T_world_scanner.act(truth.actInv(middle)) - middle
    assert np.abs(off).max() < 2e-4
    moved = cell.scanner.on_arm.T_flange_scanner.actInv(after.scanner.on_arm.T_flange_scanner)
    assert np.linalg.norm(moved.translation) > 5e-4
    assert after.scanner.calibration.by == "Grace"
    assert np.allclose(
        np.linalg.eigvalsh(calibration_covariance(after.scanner)),
        np.linalg.eigvalsh(after.scanner.calibration.covariance),
    )
    # From another view nothing is known yet.
    assert told(tmp_path, with_view(with_lower_view(cell), "low")).scans == 0


def test_what_was_before_the_calibration_does_not_count(cell, sessions):
    later = replace(cell.scanner.calibration, at=7 * DAY)
    found = told(sessions, replace(cell, scanner=replace(cell.scanner, calibration=later)))
    assert found.scans == 4
    assert found.drift.drifted == () and found.drift.moved is None


def test_without_a_calibration_nothing_is_told(cell, sessions):
    never = replace(cell, scanner=replace(cell.scanner, calibration=None))
    with pytest.raises(InputError, match="was never calibrated"):
        told(sessions, never)


def test_without_drift_there_is_nothing_to_take_over(cell):
    found = recorded_drift((), cell, lambda done, note: None)
    with pytest.raises(InputError, match="nothing recorded says"):
        refined_cell(cell, found.drift, 0.0, "Ada")
    assert tuple(map(str, drift_words(cell, found.drift))) == (
        "there are scans of 0 days; 4 are needed to compare them",
    )


@pytest.fixture(scope="module")
def with_pallet():
    """The TX2-90, whose scanner sees its pallet as well."""
    tx2_90 = read_cell("robots/tx2_90/pallet.toml")
    record = CalibrationRecord(DAY, "Ada", 8, 2e-4, 5e-4, np.deg2rad(0.05))
    mount = replace(tx2_90.scanner, field_of_view=np.deg2rad(62), calibration=record)
    return replace(tx2_90, scanner=mount)


def test_a_part_on_the_pallet_is_held_against_where_the_robot_has_put_it(with_pallet, tmp_path):
    cell, middle = with_pallet, with_pallet.bin.T_world_bin.translation
    moved = np.array([4e-4, -6e-4, -2e-3, 0, 0, 2e-3])
    there = motion_of(moved, middle) * cell.scanner.T_world_scanner
    true = replace(cell, scanner=replace(cell.scanner, T_world_scanner=there))

    def scanned(lies, seed):
        scan = synthesize(true, [Detection("puck", T) for T in lies], seed=seed)
        return replace(scan, T_world_scanner=cell.scanner.T_world_scanner)

    height = float(np.ptp(cell.part("puck").mesh.points[:, 2])) / 2
    T_true = cell.bin.T_world_bin * pose_from_rpy((0.05, -0.08, height))
    T_seen = motion_of(moved, middle).inverse() * T_true
    days = Days(cell, tmp_path)
    scan = days.scan(1.5 * DAY, scanned([T_true], 0))
    days.do(FindParts())
    days.ended((Detection("puck", T_seen),))
    days.do(MakePlan())
    result = plan_pick(cell, (Detection("puck", T_seen),), scan.digest)
    days.ended(result)
    plan = result.plan
    for command in (WatchPlan(plan.digest), Approve(plan.digest), SendPlan(plan.digest)):
        days.do(command)
    days.do(LinkEnded(parts_placed=1))
    (put,) = days.line.state.placed
    # The cup keeps where it holds the part, and how it is turned; on the pallet it lies level.
    T_raw = put.T_world_part * T_seen.inverse() * T_true
    wrong = T_raw * put.T_world_part.inverse()
    yaw = pin.rpy.matrixToRpy(wrong.rotation)[2]
    (T_rest,) = at_rest(cell, (put,))
    T_lies = pin.SE3(
        pin.exp3(np.array([0, 0, yaw])) @ T_rest.rotation,
        np.array([*T_raw.translation[:2], T_rest.translation[2]]),
    )
    days.scan(1.6 * DAY, scanned([T_lies], 1))
    days.scan(1.7 * DAY, scanned([T_lies], 2))
    days.close()

    with closing(open_journal(days.folder)) as journal:
        found = list(of_session(replay(journal, cell_of(journal)), cell, DAY))
    parts = [one for scan in found for one in scan if one.kind == "part"]
    (one,) = parts  # seen twice, counted once
    # A puck tells how high it lies and how it leans, and by the side that is seen one shift.
    explained = one.off - one.slopes @ moved
    assert 5 * (explained @ one.information @ explained) < one.off @ one.information @ one.off
