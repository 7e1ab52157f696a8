"""Checks of what a controller reports: finite numbers, within the range of each quantity.

`plugins.robot_link.send` and `states` check the reports of every link.  A link that acts on a
report itself asks `JointBounds` before it computes with the report.
"""

import math
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from numbers import Integral, Real
from typing import Any

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.errors import ProtocolError
from workbench.model.geometry import Floats
from workbench.model.motion import MotionModel
from workbench.model.plan import Plan
from workbench.model.release import LinkStatus, Receipt, RobotState

BEYOND = math.radians(5.0)
"""[rad] A joint may be reported this far beyond its limits: robots are calibrated differently."""

BEYOND_M = 0.05
"""[m] The same for a sliding joint, and for the opening of a hand."""

TURN = 2 * math.pi

LATEST = 1e11
"""[s] No clock shows more: some three thousand years."""

MOST_COUNTED = 2**53
"""Above this, numbers with a point leave some out."""


@dataclass(frozen=True, slots=True, eq=False)
class JointBounds:
    """Where joints of one arm can be: `lower` to `upper` (n,) [rad, m], and which of them turn."""

    names: tuple[str, ...]
    lower: Floats
    upper: Floats
    turns: tuple[bool, ...]

    def take(self, q: Sequence[Any] | Floats, *, in_motion: bool = True) -> Floats:
        """A reported configuration (n,) [rad, m], chain order, once it can be one.

        A turning joint may be reported a full turn from where it is.  While nothing moves, a person
        may have jogged the robot beyond the limits in the cell file.

        Args:
            q: as it was reported.
            in_motion: whether a plan moves the arm, which stays within the limits.

        Raises:
            ProtocolError: names the joint, and what it was reported to be.
        """
        if len(q) != len(self.names):
            raise ProtocolError(
                f"the controller reports {len(q)} joints where the arm has {len(self.names)}"
            )
        values = [_number(position, name) for position, name in zip(q, self.names, strict=True)]
        for name, value, low, high, turns in zip(
            self.names, values, self.lower.tolist(), self.upper.tolist(), self.turns, strict=True
        ):
            slack = BEYOND if turns else BEYOND_M
            if low - slack <= value <= high + slack:
                continue
            if turns and _is_turned(value, low - slack, high + slack, in_motion):
                continue
            raise ProtocolError(
                f"the controller reports {name} at {_format_value(value, turns)}; "
                f"it goes from {_format_value(low, turns)} to {_format_value(high, turns)}"
            )
        return np.array(values)


def bounds_of(cell: Cell, arm: Arm) -> JointBounds:
    """Where the joints of an arm of the cell can be."""
    lower, upper, _ = cell.robot.limits(arm.joints)
    turns = tuple(cell.robot.joint(name).kind == "revolute" for name in arm.joints)
    return JointBounds(arm.joints, lower, upper, turns)


def check_state(state: RobotState, cell: Cell) -> None:
    """Refuse a state that cannot be.

    Raises:
        ProtocolError: says what of it.
    """
    _check_joints(state.joints, cell, in_motion=False)
    for name, opening in state.openings.items():
        low, high = _arm(cell, name).tool.stroke
        value = _number(opening, f"the opening of the {name} arm")
        if not min(low, 0.0) - BEYOND_M <= value <= high + BEYOND_M:
            raise ProtocolError(
                f"the controller reports the opening of the {name} arm as "
                f"{_format_value(value, False)}"
            )
    for what, count in (("messages", state.received), ("parts", state.placed)):
        _check_count(count, MOST_COUNTED, f"the number of {what}")


def check_status(status: LinkStatus, cell: Cell) -> None:
    """Refuse how a link is said to stand where that cannot be.

    Raises:
        ProtocolError: says what of it.
    """
    _check_joints(status.joints or {}, cell, in_motion=True)
    _check_count(status.steps, MOST_COUNTED, "the number of steps")
    _check_count(status.step, status.steps, "the step")
    for at in (status.acknowledged_at, status.reported_at):
        check_time(at, "a time")
    if status.stopped is not None:
        check_time(status.stopped, "how long the stop took")


class Receipts:
    """The receipts of one sending, each checked as it comes.

    Lifetime: one sending.
    """

    def __init__(self, plan: Plan, motion: MotionModel) -> None:
        self._plan, self._motion = plan, motion
        self._last: Receipt | None = None
        self._parts = {(arm.arm, arm.detection) for arm in plan.picks}
        self._told = set[str]()

    def check(self, receipt: Receipt) -> None:
        """Refuse a receipt that cannot be, or that goes back behind the one before.

        Raises:
            ProtocolError: says what of it.
        """
        check_time(receipt.at, "a time")
        _check_count(receipt.total, MOST_COUNTED, "the number of messages")
        _check_count(receipt.done, receipt.total, "the message")
        before = self._last.done if self._last is not None else 0
        if receipt.done < before:
            raise ProtocolError(f"message {receipt.done} is told of after message {before}")
        for step in (receipt.waits, receipt.step):
            _check_count(step, len(self._plan.sequence), "the step")
        if receipt.part is not None:
            arm = receipt.part.arm
            if (arm, receipt.part.detection) not in self._parts or arm in self._told:
                raise ProtocolError(f"a part of the {arm} arm is told of that is none, or twice")
            self._told.add(arm)
        self._last = receipt

    def check_end(self) -> None:
        """Refuse an end before the controller has reported everything that was sent as done.

        Raises:
            ProtocolError: states what is missing.
        """
        last, link = self._last, self._motion.link
        if last is None or last.done != last.total:
            how_far = f"at message {last.done} of {last.total}" if last else "with nothing told"
            raise ProtocolError(f"the robot link {link} has ended too early, {how_far}")
        missing = [arm.arm for arm in self._plan.picks if arm.arm not in self._told]
        if self._motion.reports_progress and missing:
            raise ProtocolError(
                f"the robot link {link} has ended and told nothing of the {missing[0]} arm's part"
            )


def check_time(seconds: Any, what: str) -> float:
    """A time [s] that was reported, once it can be one.

    Raises:
        ProtocolError: names `what` it is.
    """
    value = _number(seconds, what)
    if not 0.0 <= value <= LATEST:
        raise ProtocolError(f"the controller reports {what} of {value:.6g} s")
    return value


def _is_turned(value: float, low: float, high: float, in_motion: bool) -> bool:
    """Whether a joint is a full turn from its range [rad]; not in motion, also on the way there."""
    if not low - TURN <= value <= high + TURN:
        return False
    return not in_motion or any(low <= value + turn <= high for turn in (-TURN, TURN))


def _check_joints(joints: Mapping[str, Any], cell: Cell, *, in_motion: bool) -> None:
    for name, q in joints.items():
        bounds_of(cell, _arm(cell, name)).take(q, in_motion=in_motion)


def _arm(cell: Cell, name: str) -> Arm:
    for arm in cell.arms:
        if arm.name == name:
            return arm
    raise ProtocolError(f"the controller reports an arm {name!r:.40}; cell {cell.name} has none")


def _check_count(value: Any, most: int, what: str) -> None:
    is_whole = type(value) is not bool and isinstance(value, Integral)
    if not is_whole or not 0 <= int(value) <= most:
        raise ProtocolError(f"the controller reports {what} as {_format(value)}")


def _number(value: Any, what: str) -> float:
    # Texts and flags are none, and whole numbers may be longer than any number with a point.
    number = math.nan
    if type(value) is not bool and isinstance(value, Real):
        with suppress(OverflowError):
            number = float(value)
    if math.isfinite(number):
        return number
    raise ProtocolError(
        f"the controller reports {what} as {_format(value)}, which is no finite number"
    )


def _format(value: Any) -> str:
    if isinstance(value, int) and value.bit_length() > 64:
        return f"a whole number of {value.bit_length()} bits"
    return f"{value!r:.40}"


def _format_value(value: float, turns: bool) -> str:
    return f"{math.degrees(value):.6g} degrees" if turns else f"{value * 1000:.6g} mm"
