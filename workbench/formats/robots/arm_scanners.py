"""A cell file's scanner that hangs on an arm: where on the flange, its housing, its views."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import Table
from workbench.formats.meshes.solids import read_pose, read_solid
from workbench.model.cell import Arm
from workbench.model.derived.controller_axes import from_controller, to_controller
from workbench.model.geometry import Floats
from workbench.model.robot import HOME, ArmScanner, Joint, Robot, ScanPosture

POSE = ("position_mm", "rpy_deg")

START_POSTURES = 12
"""Postures from which a view's pose is searched, the arm's home first."""

MOST_STEPS = 150
"""Of a search from one posture."""

CONVERGED_WITHIN = 1e-8
"""[m, rad] So near to the pose a search has found it."""

DAMPING = 1e-6

LONGEST_STEP = 0.3
"""[rad, m] Of any joint in one step of a search."""

DEGREE_DIGITS = 3
"""Of a degree: the view is the same on every processor."""

MOST_VIEWS = 16


def read_arm_scanner(
    table: Table, robot: Robot, T_world_robot: pin.SE3, arms: Sequence[Arm]
) -> ArmScanner:
    """The table `[scanner.on_arm]`.

    Args:
        table: it.
        robot: of the cell.
        T_world_robot: where it stands.
        arms: of the cell, as the file has them.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    name = table.text("arm")
    arm = next((arm for arm in arms if arm.name == name), None)
    if arm is None:
        raise table.error("arm", f"{name!r} is not one of {', '.join(arm.name for arm in arms)}")
    T_flange_scanner = read_pose(table)
    housing = tuple(read_solid(solid) for solid in table.tables("housing"))
    table.once("housing.name", (solid.name for solid in housing))
    taken = {solid.name for solid in (*arm.tool.body, *(f.solid for f in arm.tool.fingers))}
    for solid in housing:
        if solid.name in taken:
            raise table.error("housing.name", f"{solid.name!r} is a solid of tool {arm.tool.name}")
    stands = robot, T_world_robot, arm, T_flange_scanner
    if not table.is_array("view"):
        views = (_read_view(table.table("view"), *stands),)
    else:
        tables = list(table.tables("view"))
        if not 1 <= len(tables) <= MOST_VIEWS:
            raise table.error("view", f"{len(tables)} views, 1 to {MOST_VIEWS} are expected")
        views = tuple(_read_view(each, *stands, n) for n, each in enumerate(tables, start=1))
        table.once("view.name", (view.name for view in views))
        views = (replace(views[0], number=0),) if len(views) == 1 else views
    merges = table.flag("merge_views", False)
    if merges and len(views) == 1:
        raise table.error("merge_views", "there is one view only: it has nothing to merge")
    table.finish()
    flange = arm.flange, arm.joints, T_flange_scanner
    return ArmScanner(arm.name, *flange, views[0], arm.home, housing, views[1:], merges)


def _read_view(
    table: Table,
    robot: Robot,
    T_world_robot: pin.SE3,
    arm: Arm,
    T_flange_scanner: pin.SE3,
    number: int = 0,
) -> ScanPosture:
    """The posture, by the joints of the arm or by the pose of the scanner in the world."""
    name, bin = table.text("name", "view"), table.text("bin", "", empty=True)
    if name == HOME:
        raise table.error("name", f"a view cannot be called {HOME}: that is where home_deg is")
    has_pose = any(table.has(key) for key in POSE)
    count = len(arm.joints)
    if table.has("joints_deg") == has_pose:
        raise table.error(
            "joints_deg",
            f"either the {count} joints of arm {arm.name} are expected, or the scanner's pose as "
            "position_mm and rpy_deg",
        )
    home = np.rad2deg(to_controller(arm, arm.home))
    typed = table.numbers("joints_deg", count, home, low=-720, high=720)
    T_world_scanner = read_pose(table)
    table.finish()
    if not has_pose:
        q = from_controller(arm, np.deg2rad(typed))
        lower, upper, _ = robot.limits(arm.joints)
        for axis, place in enumerate(arm.axis_order):
            if not lower[place] <= q[place] <= upper[place]:
                sign = arm.axis_signs[axis]
                low, high = sorted(np.rad2deg([sign * lower[place], sign * upper[place]]))
                value = np.rad2deg(sign * q[place])
                raise table.error(
                    "joints_deg",
                    f"{value:g} for axis {axis + 1} is outside {low:.1f} to {high:.1f}",
                )
        return ScanPosture(name, q, bin, number)
    T_robot_flange = T_world_robot.actInv(T_world_scanner) * T_flange_scanner.inverse()
    q, away = _find_posture(robot, arm, T_robot_flange)
    if q is None:
        raise table.error(
            "position_mm",
            f"the view is out of reach of arm {arm.name}, {away * 1000:.0f} mm at best",
        )
    return ScanPosture(name, np.deg2rad(np.round(np.rad2deg(q), DEGREE_DIGITS)), bin, number)


def _find_posture(robot: Robot, arm: Arm, T_robot_flange: pin.SE3) -> tuple[Floats | None, float]:
    """Of the postures (n,) found that bring the flange there, the one nearest to home.

    None where no search comes there, with how far [m] the best one stays away.
    """
    lower, upper, _ = robot.limits(arm.joints)
    random = np.random.default_rng(0).uniform(lower, upper, (START_POSTURES - 1, len(lower)))
    found: list[Floats] = []
    best = np.inf
    for start in (np.clip(arm.home, lower, upper), *random):
        q, away = _search_posture(robot, arm, T_robot_flange, np.array(start))
        best = min(best, away)
        if away == 0.0:
            found.append(q)
    turns = [float(np.abs(q - arm.home).max()) for q in found]
    return (found[int(np.argmin(turns))] if found else None), best


def _search_posture(
    robot: Robot, arm: Arm, T_robot_flange: pin.SE3, q: Floats
) -> tuple[Floats, float]:
    """Where a search from one posture ends, and how far [m] from there; 0.0 where it arrives."""
    lower, upper, _ = robot.limits(arm.joints)
    for _ in range(MOST_STEPS):
        T, jacobian = _flange(robot, arm, q)
        error = pin.log6(T.actInv(T_robot_flange)).vector
        if np.abs(error).max() < CONVERGED_WITHIN:
            return q, 0.0
        square = jacobian @ jacobian.T + DAMPING * np.eye(6)
        step = jacobian.T @ np.linalg.solve(square, error)
        step *= min(1.0, LONGEST_STEP / max(float(np.abs(step).max()), 1e-12))
        q = np.clip(q + step, lower, upper)
    T, _ = _flange(robot, arm, q)
    return q, max(
        float(np.linalg.norm(T.translation - T_robot_flange.translation)), CONVERGED_WITHIN
    )


def _flange(robot: Robot, arm: Arm, q: Floats) -> tuple[pin.SE3, Floats]:
    """Where the flange is in the robot's frame, and the Jacobian (6, n) in the flange's frame."""
    values = dict(zip(arm.joints, q.tolist(), strict=True))
    T, frames = pin.SE3.Identity(), list[tuple[Joint, pin.SE3]]()
    for joint in robot.chain(arm.flange):
        if joint.kind != "fixed":
            frames.append((joint, T * joint.T_parent_joint))
        T = T * joint.at(values.get(joint.name, 0.0)).T_parent_joint
    columns: list[Floats] = []
    for joint, T_joint in frames:
        axis = T_joint.rotation @ joint.axis
        if joint.kind == "revolute":
            arm_length = T.translation - T_joint.translation
            columns.append(np.concatenate([np.cross(axis, arm_length), axis]))
        else:
            columns.append(np.concatenate([axis, np.zeros(3)]))
    jacobian = np.stack(columns, axis=1).reshape(2, 3, -1)
    return T, (T.rotation.T @ jacobian).reshape(6, -1)
