"""The checklist of commissioning: each step is done when the program has seen that it is."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.state import State
from workbench.app.review.commissioning import Step, checklist, next_step
from workbench.app.statistics.cycles import CycleRecord, PickRecord
from workbench.app.statistics.statistics import Statistics
from workbench.formats.cells.reading import read_cell
from workbench.model.calibration import CalibrationRecord
from workbench.model.scan import Scan

NOW = 1_800_000_000.0

PICKS = (PickRecord(0, "bolt", "rim", "left", "picked"), PickRecord(1, "bolt", "rim", "left"))

AFTER_A_CYCLE = Statistics((CycleRecord(1, NOW, NOW, end="done", picks=PICKS),))


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


@pytest.fixture
def state(cell):
    return State(cell, saved=cell.digest)


def said(state, statistics=None, now=NOW):
    checked = checklist(state, statistics or Statistics(), now)
    return {each.step: (each.is_done, str(each.says)) for each in checked}


def without_masses(cell):
    def light(tool):
        return replace(tool, mass=None)

    arms = tuple(
        replace(arm, tool=light(arm.tool), tools=tuple(map(light, arm.tools))) for arm in cell.arms
    )
    return replace(cell, arms=arms)


def test_a_simulated_cell_begins_with_its_first_scan(state):
    checked = checklist(state, Statistics(), NOW)
    assert [each.step for each in checked] == list(Step)
    assert next_step(checked) is Step.SCAN
    assert [each.step for each in checked if each.is_done] == [
        Step.LOAD,
        Step.CALIBRATION,
        Step.GRASPS,
        Step.SAVED,
    ]


def test_after_a_cycle_nothing_is_left_and_picks_are_counted(state):
    checked = checklist(state, AFTER_A_CYCLE, NOW)
    assert next_step(checked) is None
    assert said(state, AFTER_A_CYCLE)[Step.PICK] == (True, "1 of 2 picks succeeded.")


def test_a_tool_without_a_mass_is_named(cell, state):
    done, says = said(replace(state, cell=without_masses(cell)))[Step.LOAD]
    assert not done and "smart_gripper" in says


@pytest.mark.parametrize(
    ("days", "is_done", "says"),
    [(0, True, "0 days ago"), (29, True, "29 days ago"), (400, False, "400 days old")],
)
def test_a_calibration_counts_while_it_is_young(cell, state, days, is_done, says):
    record = CalibrationRecord(NOW - days * 24 * 3600.0, "Ada", 10, 0.0001)
    scanner = replace(cell.scanner, source="folder", calibration=record, calibration_days=30.0)
    found = said(replace(state, cell=replace(cell, scanner=scanner)))[Step.CALIBRATION]
    assert found[0] is is_done and says in found[1]


def test_a_real_scanner_that_was_never_calibrated_is_next(cell, state):
    scanner = replace(cell.scanner, source="folder", calibration=None)
    checked = checklist(replace(state, cell=replace(cell, scanner=scanner)), Statistics(), NOW)
    assert next_step(checked) is Step.CALIBRATION


def test_a_scan_from_a_file_asks_for_a_calibration(cell, state):
    points = np.array([[0.0, 0.0, 1.0]])
    for source, is_done in (("simulated", True), ("file", False)):
        scan = Scan(points, cell.scanner.T_world_scanner, source)
        assert said(replace(state, scan=scan))[Step.CALIBRATION][0] is is_done


def test_merged_scanners_have_their_own_calibrations(cell, state):
    scanner = replace(cell.scanner, source="merged", calibration=None)
    found = said(replace(state, cell=replace(cell, scanner=scanner)))[Step.CALIBRATION]
    assert found == (True, "Each of the merged scanners is calibrated.")


def test_a_cell_without_parts_and_a_part_without_grasps_are_different(cell, state):
    none = said(replace(state, cell=replace(cell, parts=())))[Step.GRASPS]
    assert none == (False, "Make the part from its CAD file.")
    part = cell.parts[0]
    bare = replace(part, library=replace(part.library, entries=(), searches=False))
    lacking = said(replace(state, cell=replace(cell, parts=(bare,))))[Step.GRASPS]
    assert not lacking[0] and part.name in lacking[1]


def test_a_changed_cell_is_not_saved(state):
    assert said(replace(state, saved="another"))[Step.SAVED] == (False, "Save the cell.")
