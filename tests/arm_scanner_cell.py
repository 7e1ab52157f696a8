"""The shipped cell with a scanner on an arm, and where that scanner is."""

import pinocchio as pin

from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import Cell
from workbench.model.geometry import Floats


def on_arm_cell() -> Cell:
    return read_cell(find("robots", "yumi") / "on_arm.toml")


def pose_at(cell: Cell, q: Floats) -> pin.SE3:
    """T_world_scanner when the arm stands at `q` (n,) [rad]."""
    carrier = cell.scanner.on_arm
    assert carrier is not None
    return carrier.T_world_scanner(cell.T_world_robot, cell.robot, q)


def at_view(cell: Cell) -> dict[str, float]:
    """Joints [rad] of all arms when they wait, by name."""
    return cell.joint_values({arm.name: arm.home for arm in cell.arms})
