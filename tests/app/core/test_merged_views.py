"""Scans merged from several views: what stays until the next one, and what makes it void."""

from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import at_view, on_arm_cell, with_lower_view
from line import Line

from workbench.app.core.cell.bins import NewBin
from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cell.views import ChooseView, missing_view
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.people import SESSION_START
from workbench.app.core.session import Opened
from workbench.app.core.state import Phase, State
from workbench.app.empty_hand.view_plan import plan_view
from workbench.app.runtime.work import scan as work_scan
from workbench.model.cell import Cell
from workbench.model.derived.by_view import view_name, with_view
from workbench.model.geometry import pose_from_rpy
from workbench.model.robot import ScannedView
from workbench.model.scan import Detection, Scan
from workbench.plugins.progress import never, silent


@pytest.fixture(scope="session")
def cell() -> Cell:
    return with_lower_view(on_arm_cell(), merges=True)


@pytest.fixture
def line(cell: Cell) -> Line:
    line = Line(cell)
    line.joints = at_view(cell)
    return line


def from_views(cell: Cell, *names: str, through: float = 0.0) -> Scan:
    """A scan merged from these views, taken last from the one of the cell."""
    views = tuple(
        ScannedView(name, 3, with_view(cell, name).scanner.T_world_scanner, through=through)
        for name in names
    )
    points = np.ones((3 * len(names), 3))
    joints = at_view(cell)
    return Scan(points, cell.scanner.T_world_scanner, "made", joints=joints, views=views)


def scanned(line: Line, *names: str) -> State:
    """The state after a scan from the view that is chosen, merged from these."""
    line.do(TakeScan())
    return line.ended(from_views(line.state.cell, *names))


def at_low(line: Line) -> State:
    """The state once the arm stands at the lower view."""
    state = line.do(ChooseView("low"))
    line.joints = at_view(state.cell)
    return state


def test_a_scan_stays_until_the_next_view_is_scanned_from(cell, line):
    state = scanned(line, "bin")
    assert "view low is next, whose scan is merged with this one" in str(state.message)
    state = at_low(line)
    assert state.scan is None and state.earlier.views[0].name == "bin"
    line.do(TakeScan())
    assert line.effects[-1].arguments["earlier"] is state.earlier
    state = line.ended(from_views(state.cell, "bin", "low"))
    assert (state.earlier, missing_view(state), str(state.message)) == (
        None,
        "",
        "scan with 6 points",
    )


def test_the_task_merges_what_the_scanner_sees_from_both(cell):
    request = {"seed": 3, "parts": 3, "joints": at_view(cell)}
    first = work_scan(cell, request, silent, never)
    low = with_view(cell, "low")
    both = work_scan(low, request | {"joints": at_view(low), "earlier": first}, silent, never)
    assert [view.name for view in first.views] == ["bin"]
    assert [view.name for view in both.views] == ["bin", "low"]
    assert both.views[0].count == len(first.points) and not both.views[0].is_off
    assert both.joints == at_view(low)


def test_a_cycle_goes_to_each_view_before_it_searches(cell, line):
    line.state = replace(line.state, phase=Phase.DONE)
    line.do(GoOn())
    state = line.ended(from_views(cell, "bin"))
    assert (view_name(state.cell), state.job.name) == ("low", "view")
    state = line.ended(plan_view(state.cell, start="bin"))
    assert state.phase is Phase.PLANNED and state.earlier is not None
    # As after its sending: a person has approved it.
    line.state = replace(state, phase=Phase.DONE)
    line.joints = at_view(state.cell)
    line.do(GoOn())
    assert line.effects[-1].arguments["earlier"] is state.earlier
    state = line.ended(from_views(state.cell, "bin", "low"))
    assert state.job.name == "localize"
    state = line.ended(())
    assert (state.job, state.views_without) == (None, ("bin", "low")), "both have had their turn"
    assert str(state.message) == "no part found; no further cycle starts"


def test_what_may_have_changed_the_bin_makes_the_earlier_scan_void(cell):
    cell = replace(cell, bin=replace(cell.bin, name="right"))
    line = Line(cell)
    line.joints = at_view(cell)
    scanned(line, "bin")
    waiting = at_low(line)
    low = with_view(cell, "low")
    walls = replace(low, bin=replace(low.bin, wall=0.004))
    for change in (NewBin("right"), ChangeCell(walls, "other walls")):
        line.state = waiting
        assert line.do(change).earlier is None
    line.state = replace(waiting, phase=Phase.FAULT, fault="stopped on the path")
    assert line.do(AcknowledgeFault()).earlier is None
    line.state = waiting
    assert line.do(Opened(), SESSION_START).earlier is None


def test_after_a_cycle_its_scan_is_merged_with_nothing(cell, line):
    scanned(line, "bin")
    line.state = replace(line.state, phase=Phase.DONE)
    assert at_low(line).earlier is None


def test_a_view_that_does_not_fit_the_others_is_said(cell, line):
    line.do(TakeScan())
    state = line.ended(from_views(cell, "low", "bin", through=0.05))
    assert "view low does not fit the others: 0.0 mm and 0.0 deg off, 5.0% looked" in str(
        state.message
    )
    assert "the calibration of the scanner or the robot is off" in str(state.message)


def test_without_merging_nothing_stays(line):
    line = Line(with_lower_view(on_arm_cell()))
    line.joints = at_view(line.state.cell)
    line.do(TakeScan())
    line.ended(replace(from_views(line.state.cell, "bin"), views=()))
    assert at_low(line).earlier is None
    assert missing_view(line.state) == ""
    found = Detection("keyed_cylinder", pose_from_rpy((0.4, 0, 0.02)))
    assert line.do(UseDetections((found,))).earlier is None
