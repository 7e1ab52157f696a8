"""What goes out in which order: legs as curves, and between them orders to the module in RAPID."""

from dataclasses import dataclass

import numpy as np

from workbench.devices.abb_egm import wire
from workbench.devices.abb_loads import load_data
from workbench.devices.jerk_limited_way import JerkLimitedWay
from workbench.devices.streamed_way import StreamedWay, timed_way
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.plan import Plan
from workbench.model.release import Approval

NO_LOAD = (0.0,) * 11
"""Mass, centre of gravity, axes and inertia of a load that is not reported."""

SAME_OPENING = 1e-6
"""[m] Openings that differ by less are the same."""


@dataclass(frozen=True, slots=True)
class Order:
    """A word to the module of one arm: `command`, and for the gripper its `opening` [m].

    `load` is what the arm carries from then on, by `abb_loads`; zeros where nobody knows.
    """

    arm: str
    command: int
    opening: float = 0.0
    holding: bool = False
    load: tuple[float, ...] = NO_LOAD

    @property
    def words(self) -> str:
        """For receipts."""
        if self.command == wire.GRIP:
            closes = " on a part" if self.holding else ""
            return f"gripper {self.opening * 1000:.1f} mm{closes}"
        return {wire.BEGIN: "begin", wire.END: "end"}[self.command]


@dataclass(frozen=True, slots=True, eq=False)
class LegRun:
    """A leg of one arm; `number` counts legs from 1."""

    arm: str
    name: str
    number: int
    way: StreamedWay | JerkLimitedWay


@dataclass(frozen=True, slots=True, eq=False)
class Score:
    """Everything of a plan, in its order, for the `arms` that take part.

    `ticket` names the approval: a controller that has begun it takes it no second time.
    """

    ticket: float
    arms: tuple[str, ...]
    items: tuple[Order | LegRun, ...]

    @property
    def total(self) -> int:
        """How many receipts there are."""
        return len(self.items)

    def start(self, arm: str) -> StreamedWay | JerkLimitedWay:
        """The first way of an arm."""
        return next(item.way for item in self.items if isinstance(item, LegRun) and item.arm == arm)


def score_of(cell: Cell, plan: Plan, approval: Approval) -> Score:
    """What a plan is made of.

    Raises:
        InputError: a joint of the plan is beyond the cell's limits.
    """
    hands: dict[str, tuple[float, bool]] = {}
    moves: list[Order | LegRun] = []
    legs = 0
    for step in plan.sequence:
        for name, leg_name in step.runs:
            arm, leg = cell.arm(name), plan.arm(name).leg(leg_name)
            lower, upper, _ = cell.robot.limits(arm.joints)
            if np.any(leg.q < lower - 1e-6) or np.any(leg.q > upper + 1e-6):
                raise InputError(f"leg {leg_name} goes beyond the limits of arm {name}")
            before = hands.get(name)
            if (
                before is None
                or before[1] != leg.holding
                or abs(before[0] - leg.opening) > SAME_OPENING
            ):
                hands[name] = leg.opening, leg.holding
                loads, load = plan.arm(name).loads, NO_LOAD
                if loads is not None:
                    load = load_data(loads.carried(leg.holding)).numbers
                moves.append(Order(name, wire.GRIP, leg.opening, leg.holding, load))
            legs += 1
            moves.append(LegRun(name, leg_name, legs, timed_way(cell, plan, arm, leg)))
    arms = tuple(dict.fromkeys(arm.arm for arm in plan.arms))
    begins = [Order(arm, wire.BEGIN) for arm in arms]
    ends = [Order(arm, wire.END) for arm in arms]
    return Score(float(int(approval.digest[:12], 16)), arms, (*begins, *moves, *ends))
