"""A scanner on an arm: whether the arm stands where a scan may be taken, or where it was taken."""

import math
from collections.abc import Mapping

import numpy as np

from workbench.app.core.cycle.standing import LEAST_MOVED, shift_of
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.robot import HOME, ArmScanner
from workbench.model.scan import Scan


def standing_joints(cell: Cell, reported: Mapping[str, float]) -> Mapping[str, float]:
    """The joint positions of the robot, name -> [rad, m].

    They are those that the controller reports.  A simulated scanner needs no controller: without a
    report every arm is where plans begin.
    """
    if reported or cell.scanner.source != "simulated":
        return reported
    return cell.joint_values({arm.name: arm.home for arm in cell.arms})


def view_problem(cell: Cell, joints: Mapping[str, float]) -> Message | None:
    """Why no scan can be taken; None when it can, or where the scanner stands.

    Args:
        cell: whose scanner it is.
        joints: name -> [rad, m], as `standing_joints` has them.
    """
    carrier = cell.scanner.on_arm
    if carrier is None:
        return None
    if problem := _unknown(cell, joints):
        return problem
    arm = cell.arm(carrier.arm)
    off = shift_of(cell, arm, carrier.view.q, joints)
    if off.shift <= off.allowed:
        return None
    return Refusal.NOT_AT_VIEW(
        axis=off.axis, arm=arm.name, off=off.worst, view=carrier.view.name, away=off.shift
    )


def is_at_view(cell: Cell, reported: Mapping[str, float]) -> bool:
    """Whether a scan can be taken while the controller reports joints, name -> [rad, m]."""
    return view_problem(cell, standing_joints(cell, reported)) is None


def view_named(cell: Cell, view: str) -> ArmScanner:
    """The scanner of a cell on its arm, which has the view of that name; empty: any, or `HOME`.

    Raises:
        CommandRefused: the scanner stands, or another view is chosen.
    """
    carrier = cell.scanner.on_arm
    if carrier is None:
        raise CommandRefused(Refusal.SCANNER_STANDS(cell=cell.name))
    known = [posture.name for posture in carrier.views]
    if view not in ("", HOME, *known):
        raise CommandRefused(Refusal.OTHER_VIEW(view=f"{view!r:.60}", known=known))
    if view not in ("", HOME, carrier.view.name):
        raise CommandRefused(Refusal.VIEW_NOT_CHOSEN(chosen=carrier.view.name, view=view))
    return carrier


def path_start(cell: Cell, carrier: ArmScanner, joints: Mapping[str, float]) -> str | None:
    """Where a path to the view begins: at `HOME` or the other view where the arm stands; else None.

    Args:
        cell: whose scanner it is.
        carrier: the scanner on its arm.
        joints: name -> [rad, m], as `standing_joints` has them.
    """
    if _unknown(cell, joints):
        return None
    arm = cell.arm(carrier.arm)
    starts = {HOME: carrier.home} | {view.name: view.q for view in carrier.other_views}
    offs = {name: shift_of(cell, arm, q, joints) for name, q in starts.items()}
    near = [name for name, off in offs.items() if off.shift <= off.allowed]
    return min(near, key=lambda name: offs[name].shift, default=None)


def path_problem(
    cell: Cell, carrier: ArmScanner, joints: Mapping[str, float], view: str = ""
) -> Message | None:
    """Why the path to the view or home cannot begin; None when the arm stands where it begins.

    Args:
        cell: whose scanner it is.
        carrier: the scanner on its arm.
        joints: name -> [rad, m], as `standing_joints` has them.
        view: where it leads: `HOME`, else to the view.
    """
    if view == HOME:
        return view_problem(cell, joints)
    if problem := _unknown(cell, joints):
        return problem
    if path_start(cell, carrier, joints) is not None:
        return None
    arm = cell.arm(carrier.arm)
    off = shift_of(cell, arm, carrier.home, joints)
    if view_problem(cell, joints) is None:
        return Refusal.AT_VIEW(arm=arm.name, view=carrier.view.name)
    return Refusal.NOT_AT_HOME(axis=off.axis, arm=arm.name, off=off.worst, away=off.shift)


def scan_problem(cell: Cell, scan: Scan | None, joints: Mapping[str, float]) -> Message | None:
    """Why a scan cannot be used while the robot stands so; None when it can.

    Args:
        cell: with its scanner; where that stands every scan can be used.
        scan: that was taken; None for parts from a file, which no scanner has seen.
        joints: name -> [rad, m], as `standing_joints` has them.
    """
    carrier = cell.scanner.on_arm
    if carrier is None or scan is None:
        return None
    arm = cell.arm(carrier.arm)
    if scan.joints is None or any(name not in scan.joints for name in arm.joints):
        return Refusal.SCAN_WITHOUT_JOINTS(arm=arm.name)
    if problem := view_problem(cell, scan.joints) or _unknown(cell, joints):
        return problem
    q = np.array([scan.joints[name] for name in arm.joints])
    T_world_scanner = carrier.T_world_scanner(cell.T_world_robot, cell.robot, q)
    if not scan.T_world_scanner.isApprox(T_world_scanner, 1e-9):
        return Refusal.SCAN_OF_OTHER_POSE(arm=arm.name)
    off = shift_of(cell, arm, q, joints)
    if off.shift <= off.allowed:
        return None
    return Refusal.MOVED_SINCE_SCAN(axis=off.axis, arm=arm.name, off=off.worst, away=off.shift)


def plate_problem(
    cell: Cell, arm_name: str, q: Floats, joints: Mapping[str, float]
) -> Message | None:
    """Why a scan of the plate cannot be used; None when it can, or where the scanner stands.

    Args:
        cell: whose scanner it is; a simulated one sees the plate from wherever an arm is jogged.
        arm_name: of the arm that carries the scanner.
        q: where it stands (n,) [rad, m], chain order.
        joints: name -> [rad, m], as the controller reports.
    """
    carrier = cell.scanner.on_arm
    if carrier is None:
        return None
    if arm_name != carrier.arm:
        return Refusal.OTHER_CARRIER(carrier=carrier.arm, arm=arm_name)
    if cell.scanner.source == "simulated":
        return None
    if not all(math.isfinite(joints.get(name, math.nan)) for name in carrier.joints):
        return Refusal.SCANNER_UNKNOWN(arm=carrier.arm)
    off = shift_of(cell, cell.arm(carrier.arm), q, joints)
    if off.shift <= LEAST_MOVED:
        return None
    return Refusal.PLATE_SCAN_MOVED(axis=off.axis, arm=carrier.arm, off=off.worst, away=off.shift)


def _unknown(cell: Cell, joints: Mapping[str, float]) -> Message | None:
    """An arm at an unknown pose; it may be in the image."""
    for arm in cell.arms:
        if not all(math.isfinite(joints.get(name, math.nan)) for name in arm.joints):
            return Refusal.SCANNER_UNKNOWN(arm=arm.name)
    return None
