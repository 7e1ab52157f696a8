"""A proven plan as the answers that a robot program gets, leg by leg and waypoint by waypoint."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.devices.legs import HandAction, hand_before, segment_seconds
from workbench.devices.pick_server.axes import AxisWords
from workbench.devices.pick_server.lines import LAST, answer_bytes
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.load import Loads
from workbench.model.messages.work import AskText
from workbench.model.plan import Leg, LegName, Plan
from workbench.model.release import Approval

LONGEST_SEGMENT = 99.999
"""[s] From one waypoint to the next."""

LEAST_SPEED = 0.1
"""[percent] No controller moves a joint at 0."""

TICKET = 8
"""Digits of the approval's digest that travel."""


@dataclass(frozen=True, slots=True, eq=False)
class AskedLeg:
    """One leg: what is answered to `leg`, to each `point`, and where (n,) [rad, m] it ends.

    `seconds` [s] is how long it takes at the approved speed.
    """

    name: LegName
    hand: HandAction
    words: tuple[str, ...]
    points: tuple[tuple[str, ...], ...]
    q_end: Floats
    seconds: float


@dataclass(frozen=True, slots=True, eq=False)
class AskedProgram:
    """A plan as it is asked for; `q_start` (n,) [rad, m] is where the robot has to stand."""

    arm: str
    detection: int
    ticket: str
    q_start: Floats
    legs: tuple[AskedLeg, ...]

    @property
    def words(self) -> tuple[str, ...]:
        """What is answered to `next`."""
        points = sum(len(leg.points) for leg in self.legs)
        return "PLAN", self.ticket, str(len(self.legs)), str(points)

    @property
    def steps(self) -> int:
        """How many legs there are."""
        return len(self.legs)

    @property
    def total(self) -> int:
        """Answers that carry the plan, and the reports of legs that were done."""
        return 1 + sum(2 + len(leg.points) for leg in self.legs)


def program_of(cell: Cell, plan: Plan, approval: Approval, axes: AxisWords) -> AskedProgram:
    """A plan as it is asked for, slower than planned where the approval says so.

    Raises:
        InputError: it moves another arm, or does not fit the lines.
    """
    arm_plan = plan.arms[0]
    before: Leg | None = None
    legs: list[AskedLeg] = []
    try:
        for step in plan.sequence:
            for name, leg_name in step.runs:
                leg = plan.arm(name).leg(leg_name)
                legs.append(_leg(cell, plan, leg, before, axes, approval.speed_share))
                before = leg
    except InputError as error:
        raise InputError(AskText.NOT_PROVEN(problem=error.message)) from error
    ticket = approval.digest[:TICKET]
    return AskedProgram(
        arm_plan.arm, arm_plan.detection, ticket, np.asarray(arm_plan.legs[0].q[0]), tuple(legs)
    )


def _leg(
    cell: Cell, plan: Plan, leg: Leg, before: Leg | None, axes: AxisWords, share: float
) -> AskedLeg:
    _, _, fastest = cell.robot.limits(cell.arms[0].joints)
    seconds = segment_seconds(cell, cell.arms[0].name, leg, share)
    if seconds.max() > LONGEST_SEGMENT:
        raise InputError(f"{seconds.max():.0f} s from one waypoint to the next are too long")
    speeds = (np.abs(np.diff(leg.q, axis=0)) / fastest).max(axis=1) / seconds * 100
    blend = f"{cell.zone * 100:.0f}"
    points: list[tuple[str, ...]] = []
    for k, (q, takes, speed) in enumerate(zip(leg.q[1:], seconds, speeds, strict=True), start=1):
        percent = max(math.floor(speed * 10 + 1e-9) / 10, LEAST_SPEED)
        # At the end of a leg the robot stops, whatever it does at corners.
        corner = blend if k < len(seconds) else "0"
        words = ("TO", *axes.words(q), f"{percent:.1f}", f"{takes:.3f}", corner)
        answer_bytes(axes.form, LAST, *words)
        points.append(words)
    hand = hand_before(leg, before)
    load = load_words(plan.arms[0].loads, leg.holding)
    words = ("LEG", leg.name, hand, f"{leg.opening * 1000:.1f}", str(len(points)))
    words = (*words, f"{seconds.sum():.3f}", *load)
    answer_bytes(axes.form, LAST, *words)
    return AskedLeg(
        leg.name, hand, words, tuple(points), np.asarray(leg.q[-1]), float(seconds.sum())
    )


def load_words(loads: Loads | None, holding: bool) -> tuple[str, ...]:
    """Mass [kg] and centre of gravity [mm] of tool and part; zeros where nobody has stated them."""
    if loads is None:
        return ("0.000", "0.0", "0.0", "0.0")
    carried = loads.carried(holding)
    centre = np.round(carried.centre * 1000, 1) + 0.0
    return (f"{carried.mass:.3f}", *(f"{value:.1f}" for value in centre))


def check_lines(cell: Cell, axes: AxisWords) -> None:
    """Refuse a form whose lines do not hold every waypoint of a cell.

    Raises:
        InputError: names what is too long, or the digits.
    """
    arm, rounded = cell.arms[0], cell.controller.motion.rounded
    axes.words(rounded(np.asarray(arm.home)))
    lower, upper, _ = cell.robot.limits(arm.joints)
    low, high = (arm.to_axes(q) for q in (lower, upper))
    coupling, offsets = np.eye(len(low)), np.zeros(len(low))
    if arm.mapping is not None:
        coupling, offsets = np.asarray(arm.mapping.coupling), np.asarray(arm.mapping.offsets)
    middle, half = coupling @ (low + high) / 2 + offsets, np.abs(coupling) @ np.abs(high - low) / 2
    longest = [
        max(words, key=len)
        for words in zip(
            axes.format_shown(middle - half), axes.format_shown(middle + half), strict=True
        )
    ]
    answer_bytes(axes.form, LAST, "TO", *longest, "100.0", f"{LONGEST_SEGMENT:.3f}", "50")
    load = ("99.999", "-999.9", "-999.9", "-999.9")
    answer_bytes(axes.form, LAST, "LEG", "approach", "open", "999.9", "99", "999.999", *load)
