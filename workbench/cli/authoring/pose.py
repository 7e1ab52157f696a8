"""`workbench cell pose`: where an arm's flange and TCP are, as the pendant of a maker shows it."""

import numpy as np
import pinocchio as pin

from workbench.cli.arguments.cell import CellPose
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.formats.cells.reading import read_cell
from workbench.formats.poses.conventions import PoseConvention, convention
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import from_shown, shown_axes
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.planning.kinematics.posture_check import Cause, base_poses, causes_of
from workbench.planning.kinematics.robot import Kinematics


def pose(typed: CellPose) -> int:
    """Print the poses, and what explains a difference to the pendant."""
    cell = read_cell(typed.cell)
    arm = cell.arms[0] if typed.arm is None else cell.arm(typed.arm)
    q = arm.home if typed.joints_deg is None else _configuration(cell, arm, typed.joints_deg)
    kinematics, written = Kinematics(cell), convention(typed.format)
    T_shown = None if typed.shown is None else written.pose(typed.shown)
    here = base_poses(kinematics, arm, q)
    rows = [
        ("flange in the robot's base", here["flange"]),
        ("TCP in the robot's base", here["tcp"]),
        ("TCP in the world", cell.T_world_robot * here["tcp"]),
    ]
    causes = () if T_shown is None else causes_of(kinematics, arm, q, T_shown)
    if typed.json:
        form = {"arm": arm.name, "joints_deg": round_axes(cell, arm, q), "format": typed.format}
        form |= {"numbers": list(written.names)}
        form |= {"poses": [{"what": what, "shown": _round_pose(written, T)} for what, T in rows]}
        form |= {"causes": [_form(written, cause) for cause in causes]}
        print_json(form)
    else:
        joints = ", ".join(f"{value:g}" for value in round_axes(cell, arm, q))
        title = f"{arm.name} arm of {cell.name} at {joints} deg, as {written.maker} shows it"
        table = [(what, *_digits(written, T)) for what, T in rows]
        print_table(title, ("what", *written.names), table)
        for number, cause in enumerate(causes):
            print(("" if number == 0 else "or ") + _sentence(written, cause, cell, arm))
        if len(causes) > 1:
            print("compare a second posture with other joints: only the right cause stays the same")
    return SUCCESS if all(cause.kind == "none" for cause in causes) else NO_PLAN


def _configuration(cell: Cell, arm: Arm, joints: tuple[float, ...]) -> Floats:
    if len(joints) != len(arm.joints) or not np.all(np.isfinite(joints)):
        raise InputError(
            f"--joints-deg needs {len(arm.joints)} numbers for the {arm.name} arm, not {joints}"
        )
    return from_shown(cell, arm, np.asarray(joints))


def round_axes(cell: Cell, arm: Arm, q: Floats) -> list[float]:
    """What the controller shows [deg, mm] at a configuration (n,) [rad, m], for people."""
    return [round(float(x), 4) + 0.0 for x in shown_axes(cell, arm, q)]


def _round_pose(written: PoseConvention, T: pin.SE3) -> list[float]:
    return [round(number, 6) + 0.0 for number in written.show(T)]


def _digits(written: PoseConvention, T: pin.SE3) -> list[str]:
    """The numbers of a pose with sensible digits: lengths 2, degrees 3, others 6."""
    places = {"mm]": 2, "deg]": 3}
    return [
        f"{number + 0.0:.{places.get(name.partition('[')[2], 6)}f}"
        for name, number in zip(written.names, written.show(T), strict=True)
    ]


def _form(written: PoseConvention, cause: Cause) -> dict[str, object]:
    form: dict[str, object] = {"kind": cause.kind, "frame": cause.frame}
    if cause.kind == "joint":
        form |= {"joint": cause.name, "offset": cause.offset}
    return form if cause.T is None else form | {"pose": _round_pose(written, cause.T)}


def _sentence(written: PoseConvention, cause: Cause, cell: Cell, arm: Arm) -> str:
    what = "TCP" if cause.frame == "tcp" else "flange"
    match cause.kind:
        case "none":
            return f"the pendant shows the {what} where the cell has it"
        case "joint":
            is_slide = any(
                joint.name == cause.name and joint.kind == "prismatic"
                for joint in cell.robot.joints
            )
            axis = arm.axis_order.index(arm.joints.index(cause.name))
            offset = arm.axis_signs[axis] * cause.offset * (1000 if is_slide else 180 / np.pi)
            return (
                f"the zero of axis {axis + 1} ({cause.name}) differs: at these joints the robot "
                f"stands as the cell does with {offset:+.2f} {'mm' if is_slide else 'deg'} on that "
                f"axis, if the pendant shows the {what}"
            )
        case _:
            assert cause.T is not None
            shown = zip(written.names, _digits(written, cause.T), strict=True)
            numbers = ", ".join(f"{name} {number}" for name, number in shown)
            if cause.kind == "tool":
                return f"the pendant uses another tool, whose TCP in the flange is {numbers}"
            return (
                f"the pendant uses another base, in which the cell's base is {numbers}, if it "
                f"shows the {what}"
            )
