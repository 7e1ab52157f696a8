"""The shipped cell with a scanner on an arm, and where that scanner is."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.devices.universal_robots.rtde import RTDE_PORT
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.robot import ScanPosture
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution
from workbench.plugins.robot_link import controller_by


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


def before_view(cell: Cell) -> dict[str, float]:
    """Joints [rad] of all arms where the one with the scanner has not gone to the view yet."""
    carrier = cell.scanner.on_arm
    assert carrier is not None
    postures = {arm.name: arm.home for arm in cell.arms} | {carrier.arm: carrier.home}
    return cell.joint_values(postures)


def parked(cell: Cell) -> Cell:
    """The cell as a controller has it whose arm with the scanner begins at its own home."""
    carrier = cell.scanner.on_arm
    assert carrier is not None
    arms = (
        replace(arm, home=carrier.home) if arm.name == carrier.arm else arm for arm in cell.arms
    )
    return replace(cell, arms=tuple(arms))


def six_axes_cell(link: str) -> Cell:
    """The shipped cell with six axes and a scanner on its arm, spoken to by that link."""
    cell = read_cell(find("robots", "tx2_90") / "on_arm.toml")
    return replace(cell, controller=controller_by(link, "127.0.0.1", 30002, RTDE_PORT))


def with_lower_view(cell: Cell, *, by: float = 0.05, merges: bool = False) -> Cell:
    """The cell with a second view, called low, whose scanner is `by` [m] below the first one's.

    With `merges` each scan is merged from both.
    """
    carrier = cell.scanner.on_arm
    assert carrier is not None
    T_world_scanner = pin.SE3(cell.scanner.T_world_scanner)
    T_world_scanner.translation -= (0.0, 0.0, by)
    T_world_flange = T_world_scanner * carrier.T_flange_scanner.inverse()
    T_world_tcp = T_world_flange * cell.arm(carrier.arm).tool.T_flange_tcp
    chain = World(cell, ()).chains[carrier.arm]
    answers, residuals = chain.solve(T_world_tcp, np.array([carrier.view.q]))
    assert is_solution(residuals).all()
    first, low = replace(carrier.view, number=1), ScanPosture("low", answers[0], number=2)
    views = replace(carrier, view=first, other_views=(low,), merges_views=merges)
    return replace(cell, scanner=replace(cell.scanner, on_arm=views))
