"""A scanner on an arm: what is asked of the robot's joints before, during and after a scan."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import at_view, on_arm_cell, pose_at
from line import Line

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.results import is_failure
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.effects import StartJob
from workbench.app.core.state import Phase
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused
from workbench.model.scan import Detection, Scan


@pytest.fixture(scope="module")
def simulated() -> Cell:
    return on_arm_cell()


@pytest.fixture(scope="module")
def cell(simulated: Cell) -> Cell:
    """The same cell with a real scanner, which does not assume where the robot stands."""
    return replace(simulated, scanner=replace(simulated.scanner, source="folder"))


@pytest.fixture
def line(cell: Cell) -> Line:
    line = Line(cell)
    line.joints = at_view(cell)
    return line


def turned(cell: Cell, degrees: float, joint: str = "left_joint_1") -> dict[str, float]:
    joints = at_view(cell)
    joints[joint] += np.deg2rad(degrees)
    return joints


def scan_at(cell: Cell, joints: Mapping[str, float]) -> Scan:
    q = np.array([joints[name] for name in cell.arm("left").joints])
    return Scan(np.ones((3, 3)), pose_at(cell, q), "made", joints=joints)


def test_a_scan_is_taken_at_the_view_with_the_joints_that_the_controller_reports(
    cell: Cell, line: Line
) -> None:
    line.joints = turned(cell, 0.02)
    line.do(TakeScan())
    begun = line.effects[-1]
    assert isinstance(begun, StartJob)
    assert begun.arguments["joints"] == line.joints


def test_no_scan_is_taken_where_no_joints_are_reported(line: Line) -> None:
    line.joints = {}
    with pytest.raises(CommandRefused, match="nobody knows where the scanner is"):
        line.do(TakeScan())


def test_no_scan_is_taken_where_only_the_other_arm_is_reported(cell: Cell, line: Line) -> None:
    line.joints = {k: v for k, v in at_view(cell).items() if not k.startswith("left")}
    with pytest.raises(CommandRefused, match="joints of the left arm"):
        line.do(TakeScan())


def test_no_scan_is_taken_where_a_joint_is_no_number(cell: Cell, line: Line) -> None:
    line.joints = at_view(cell) | {"left_joint_3": float("nan")}
    with pytest.raises(CommandRefused, match="nobody knows where the scanner is"):
        line.do(TakeScan())


def test_no_scan_is_taken_beside_the_view(cell: Cell, line: Line) -> None:
    line.joints = turned(cell, 3)
    with pytest.raises(CommandRefused, match=r"does not stand at view bin: axis 1 is 3"):
        line.do(TakeScan())


def test_a_scan_during_which_the_arm_moved_is_not_used(cell: Cell, line: Line) -> None:
    line.do(TakeScan())
    taken = scan_at(cell, line.joints)
    line.joints = turned(cell, 3)
    state = line.ended(taken)
    assert state.scan is None
    assert is_failure(state.message)
    assert "has moved since the scan" in str(state.message)


def test_a_scan_after_which_nobody_reports_is_not_used(cell: Cell, line: Line) -> None:
    line.do(TakeScan())
    taken = scan_at(cell, line.joints)
    line.joints = {}
    assert line.ended(taken).scan is None


def test_a_scan_without_joints_is_refused_from_a_file_and_from_the_scanner(
    cell: Cell, line: Line
) -> None:
    unknown = replace(scan_at(cell, line.joints), joints=None)
    with pytest.raises(CommandRefused, match="nobody knows from where the scan was taken"):
        line.do(UseScan(unknown))
    line.do(TakeScan())
    assert line.ended(unknown).scan is None


def test_a_scan_of_another_view_is_refused(cell: Cell, line: Line) -> None:
    elsewhere = scan_at(cell, turned(cell, 5))
    with pytest.raises(CommandRefused, match="does not stand at view bin"):
        line.do(UseScan(elsewhere))


def test_a_scan_whose_pose_does_not_follow_from_its_joints_is_refused(
    cell: Cell, line: Line
) -> None:
    scan = scan_at(cell, line.joints)
    T = scan.T_world_scanner.copy()
    T.translation = T.translation + [0, 0, 0.001]
    with pytest.raises(CommandRefused, match="does not follow from its joints"):
        line.do(UseScan(replace(scan, T_world_scanner=T)))


def test_nothing_is_planned_once_the_arm_has_moved(cell: Cell, line: Line) -> None:
    with_parts(cell, line)
    line.joints = turned(cell, 3)
    with pytest.raises(CommandRefused, match="has moved since the scan"):
        line.do(MakePlan())
    line.joints = {}
    with pytest.raises(CommandRefused, match="nobody knows where the scanner is"):
        line.do(MakePlan())
    line.joints = at_view(cell)
    assert line.do(MakePlan()).job is not None


def test_going_on_does_not_plan_once_the_arm_has_moved(cell: Cell, line: Line) -> None:
    line.state = replace(line.state, phase=Phase.DONE)
    line.do(GoOn())
    line.ended(scan_at(cell, line.joints))
    line.joints = turned(cell, 3)
    state = line.ended((Detection("keyed_cylinder", cell.bin.T_world_bin),))
    assert state.job is None
    assert "has moved since the scan" in str(state.message)


def test_the_next_cycle_waits_for_the_end_of_the_plan(line: Line) -> None:
    line.state = replace(line.state, phase=Phase.SENDING)
    with pytest.raises(CommandRefused, match="go on when the plan has ended"):
        line.do(GoOn())


def test_a_simulated_scanner_scans_at_the_view_without_a_controller(simulated: Cell) -> None:
    line = Line(simulated)
    line.do(TakeScan())
    begun = line.effects[-1]
    assert isinstance(begun, StartJob)
    assert begun.arguments["joints"] == at_view(simulated)


def test_a_scanner_that_stands_asks_for_no_joints() -> None:
    line = Line(read_cell("yumi"))
    line.do(TakeScan())
    begun = line.effects[-1]
    assert isinstance(begun, StartJob)
    assert begun.arguments.keys() == {"seed", "parts", "part"}


def with_parts(cell: Cell, line: Line) -> None:
    line.do(TakeScan())
    line.ended(scan_at(cell, line.joints))
    line.do(FindParts())
    line.ended((Detection("keyed_cylinder", cell.bin.T_world_bin),))
