"""The plate before a scanner on an arm: what is asked of the robot's joints while it is scanned."""

from dataclasses import replace

import numpy as np
import pytest
from arm_scanner_cell import at_view, on_arm_cell
from line import Line

from workbench.app.core.cycle.scanning import SightPlate
from workbench.app.core.effects import StartJob
from workbench.model.calibration import BallPlate, PlateObservation
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused

PLATE = BallPlate()


@pytest.fixture(scope="module")
def simulated() -> Cell:
    return on_arm_cell()


@pytest.fixture(scope="module")
def cell(simulated: Cell) -> Cell:
    """The same cell with a real scanner."""
    return replace(simulated, scanner=replace(simulated.scanner, source="folder"))


@pytest.fixture
def line(cell: Cell) -> Line:
    line = Line(cell)
    line.joints = at_view(cell)
    return line


def sight(line: Line, arm: str = "left") -> None:
    q = np.asarray(line.state.cell.arm(arm).home)
    line.do(SightPlate(arm, q, PLATE))


def moved(cell: Cell, degrees: float) -> dict[str, float]:
    joints = at_view(cell)
    joints["left_joint_1"] += np.deg2rad(degrees)
    return joints


def seen(cell: Cell) -> PlateObservation:
    q = np.asarray(cell.arm("left").home)
    return PlateObservation("pose 1", "left", q, PLATE, PLATE.centres, 0.0, np.ones((4, 3)))


def test_the_plate_is_scanned_where_the_controller_reports_the_arm(line: Line) -> None:
    sight(line)
    begun = line.effects[-1]
    assert isinstance(begun, StartJob) and begun.arguments["arm"] == "left"
    line.ended(seen(line.state.cell))
    assert len(line.state.observations) == 1


@pytest.mark.parametrize("joints", [{}, {"left_joint_1": 0.0}])
def test_no_plate_is_scanned_where_joints_are_not_reported(line: Line, joints) -> None:
    line.joints = joints
    with pytest.raises(CommandRefused, match="does not report the joints of the left arm"):
        sight(line)


def test_no_plate_is_scanned_elsewhere_than_the_command_says(cell: Cell, line: Line) -> None:
    line.joints = moved(cell, 0.5)
    with pytest.raises(CommandRefused, match="does not stand still where the plate is scanned"):
        sight(line)


def test_a_pose_during_which_the_arm_has_moved_is_not_used(cell: Cell, line: Line) -> None:
    sight(line)
    line.joints = moved(cell, 0.5)
    line.ended(seen(cell))
    assert line.state.observations == () and "scan the plate again" in str(line.state.message)


def test_the_plate_is_not_scanned_with_the_joints_of_the_other_arm(line: Line) -> None:
    with pytest.raises(CommandRefused, match="the left arm carries the scanner, not the right"):
        sight(line, "right")


def test_a_simulated_scanner_sees_the_plate_from_where_the_arm_is_jogged(simulated: Cell) -> None:
    line = Line(simulated)
    line.joints = moved(simulated, 20.0)
    sight(line)
    assert isinstance(line.effects[-1], StartJob)
