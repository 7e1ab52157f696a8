"""Sessions of some days, read again: what they say of the scanner since it was calibrated."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest
from line import Line

from workbench.app.core.commands import Entry, JobEnded, TakeScan
from workbench.app.picking.drift_words import drift_words
from workbench.app.records.record import command_form, entry_record
from workbench.app.records.sessions import new_session
from workbench.app.review.scanner_drift import recorded_drift, refined_cell
from workbench.formats.cells.reading import read_cell
from workbench.model.calibration import CalibrationRecord
from workbench.model.errors import InputError
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
        _record(root, cell, replace(scan, T_world_scanner=cell.scanner.T_world_scanner), day)
    return root


def _record(root, cell, scan, day):
    line = Line(cell)
    line.now = (day + 1.5) * DAY
    with closing(new_session(root, cell, line.now)) as journal:
        line.state = replace(line.state, number=1, saved=cell.digest)
        for command in (TakeScan(), JobEnded(2, scan)):
            state = line.do(command)
            actor = "ada" if isinstance(command, TakeScan) else "worker"
            entry = Entry(state.number, line.now, actor, command)
            record = entry_record(entry, command_form(command), state)
            journal.append(record.kind, record.body, record.files)


def told(sessions, cell):
    folders = sorted(sessions.iterdir())
    return recorded_drift(folders, cell, lambda done, note: None)


def test_a_scanner_that_was_knocked_is_told_and_taken_over(cell, sessions):
    found = told(sessions, cell)
    assert (found.sessions, found.scans, found.problems) == (10, 10, ())
    assert found.drift.drifted == ("table",)
    assert not found.drift.is_bin_off
    says = " ".join(drift_words(cell, found.drift))
    assert "the scanner has drifted since its calibration, as table shows" in says
    assert "nothing but the bin tells x, y, rz" in says

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
    assert drift_words(cell, found.drift) == (
        "there are scans of 0 days, 4 are needed to compare them",
    )
