"""Vision only: a plan as the poses of its pick, of a motion that the robot's program makes itself.

The grasp is one that planning found and the proof holds for; how the robot comes there and goes
away is not known here, so that nothing of it is proven.  Each answer says so.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.devices.pick_server.lines import LAST, Form, answer_bytes
from workbench.devices.pick_server.options import form_of, pick_options
from workbench.devices.pick_server.program import TICKET, AskedProgram, load_words
from workbench.formats.poses.conventions import PoseConvention, convention
from workbench.model.cell import Arm, Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.work import AskText
from workbench.model.plan import Plan
from workbench.model.release import Approval

UNPROVEN = "unproven"
"""The word in every answer with a pose."""

POSES = ("approach", "grasp", "retreat")
"""Where the hand goes before it takes the part, where it takes it, and where it carries it."""

UNIT_DIGITS = {"mm]": 2, "deg]": 3}
"""After the point, by unit; others have 6."""

FARTHEST_POINT = -9999.99
"""[mm] The longest number of a length; no robot is larger."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseProgram(AskedProgram):
    """The poses of one pick as they are asked for; `seconds` [s] is what the plan would take."""

    pick: tuple[str, ...]
    poses: tuple[tuple[str, ...], ...]
    seconds: float

    @property
    def words(self) -> tuple[str, ...]:
        """What is answered to `next`."""
        return self.pick

    @property
    def steps(self) -> int:
        """How many poses there are."""
        return len(self.poses)

    @property
    def total(self) -> int:
        """The answers with the pick and its poses, and the report of its end."""
        return 2 + len(self.poses)


def pose_program_of(cell: Cell, plan: Plan, approval: Approval) -> PoseProgram:
    """A plan as the poses of its pick.

    Raises:
        InputError: they do not fit the lines.
    """
    arm_plan, form = plan.arms[0], form_of(cell)
    approach, extract = arm_plan.leg("approach"), arm_plan.leg("extract")
    stops = (
        ("approach", "open", approach.opening, approach.q[0]),
        ("grasp", "grip", extract.opening, approach.q[-1]),
        ("retreat", "keep", extract.opening, extract.q[-1]),
    )
    poses: list[tuple[str, ...]] = []
    for name, hand, opening, q in stops:
        numbers = _pose_words(cell, np.asarray(q))
        poses.append(("POSE", UNPROVEN, name, hand, f"{opening * 1000:.1f}", *numbers))
    detection = plan.detections[arm_plan.detection]
    kinds = [part.name for part in cell.parts]
    ticket, kind = approval.digest[:TICKET], str(kinds.index(detection.part) + 1)
    pick = ("PICK", UNPROVEN, ticket, kind, *load_words(arm_plan.loads, extract.holding))
    _check_fits(form, pick, *poses)
    seconds = plan.cycle_seconds / approval.speed_share
    q_start = np.asarray(arm_plan.legs[0].q[0])
    return PoseProgram(
        arm_plan.arm, arm_plan.detection, ticket, q_start, (), pick, tuple(poses), seconds
    )


def _pose_words(cell: Cell, q: Floats) -> list[str]:
    """Where the hand is at `q` (n,) [rad, m], chain order, as the numbers of the cell's maker."""
    given = pick_options(cell)
    T = _hand_pose(cell, cell.arms[0], q, frame=given.frame, pose_of=given.pose_of)
    return _digits(convention(given.poses), T)


def _hand_pose(cell: Cell, arm: Arm, q: Floats, *, frame: str, pose_of: str) -> pin.SE3:
    """The pose of an arm's TCP or flange at `q` (n,) [rad, m] in the robot's base or the world.

    The TCP is the first one of the tool, whichever takes the part: the robot's program knows it.
    """
    values = dict(zip(arm.joints, map(float, q), strict=True))
    T = cell.robot.link_poses(values)[arm.flange]
    if pose_of == "tcp":
        T = T * arm.tool.T_flange_tcp
    return cell.T_world_robot * T if frame == "world" else T


def _digits(written: PoseConvention, T: pin.SE3) -> list[str]:
    words = [
        f"{number:.{UNIT_DIGITS.get(name.partition('[')[2], 6)}f}"
        for name, number in zip(written.names, written.show(T), strict=True)
    ]
    return [word.removeprefix("-") if float(word) == 0 else word for word in words]


def check_pose_lines(cell: Cell) -> None:
    """Refuse a form whose lines do not hold every pose.

    Raises:
        InputError: says how long the longest one is.
    """
    written = convention(pick_options(cell).poses)
    widest = {"mm]": FARTHEST_POINT, "deg]": -179.999, "rad]": -3.141593}
    numbers = [
        f"{widest[unit]:.{UNIT_DIGITS.get(unit, 6)}f}" if unit in widest else "-0.999999"
        for unit in (name.partition("[")[2] for name in written.names)
    ]
    load = ("99.999", "-999.9", "-999.9", "-999.9")
    try:
        _check_fits(
            form_of(cell),
            ("POSE", UNPROVEN, "approach", "open", "999.9", *numbers),
            ("PICK", UNPROVEN, "0" * TICKET, "999", *load),
        )
    except InputError as error:
        raise InputError(f"poses do not fit: {error.message}") from error


def _check_fits(form: Form, *answers: tuple[str, ...]) -> None:
    try:
        for words in answers:
            answer_bytes(form, LAST, *words)
    except InputError as error:
        raise InputError(AskText.NOT_PROVEN(problem=error.message)) from error
