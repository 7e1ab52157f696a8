"""Hands that may hold what they should not: an arm drops it back, or a person sees none."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.standing import shift_of
from workbench.app.core.hands import arms_that_may_hold, last_sent, may_hold
from workbench.app.core.state import State
from workbench.app.core.tasks import begin_task
from workbench.app.core.value_checks import SEED_LIMIT, check_integer, check_text
from workbench.model.cell import Arm, Cell
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import StateText
from workbench.model.tools.held_body import (
    HeldAmount,
    drop_problem,
    kinds_problem,
    recipe_problem,
    tool_problem,
)


@dataclass(frozen=True, slots=True, eq=False)
class PlanDropBack(Command):
    """Plan how an arm drops back what its hand may hold, from where it stands.

    `held`: `one` part, `two`, or `unknown`.  `arm`: its name; empty: the one
    that is not at home, else the one that the last plan moved.
    """

    right: ClassVar[Right] = Right(CommandText.PLAN_DROP_BACK, SAFE, plans=True)

    held: str = str(HeldAmount.UNKNOWN)
    arm: str = ""
    seed: int = 0

    def check(self, state: State, asked: Asked) -> None:
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        check_text("arm", self.arm)
        check_text("held", self.held)
        if self.held not in set(HeldAmount):
            value = f"{self.held!r:.60}"
            raise CommandRefused(Refusal.DROP_AMOUNT(known=list(HeldAmount), value=value))
        cell = state.cell
        refuse(recipe_problem(state.whole or cell, cell) or drop_problem(cell))
        refuse(kinds_problem(state.largest_sent, cell) if arms_that_may_hold(state) else None)
        refuse(self._start_problem(state, asked.joints))

    def apply(self, state: State, entry: Entry) -> Decision:
        arm = self._arm_in(state, entry.joints)
        arguments = {
            "arm": arm.name,
            "q": np.array([entry.joints[name] for name in arm.joints]),
            "held": self.held,
            "placed": state.placed,
            "seed": self.seed,
        }
        return begin_task(state, entry, "drop", arguments, StateText.PLANNING())

    def _arm_in(self, state: State, joints: Mapping[str, float]) -> Arm:
        """The arm that is meant."""
        cell = state.cell
        if self.arm:
            return cell.arm(self.arm)
        away = [arm for arm in cell.arms if not _is_home(cell, arm, joints)]
        # The cell may be another one since.
        names = [arm.arm for plan in last_sent(state) for arm in plan.arms]
        moved = [arm for name in names for arm in cell.arms if arm.name == name]
        return (*away, *moved, *cell.arms)[0]

    def _start_problem(self, state: State, joints: Mapping[str, float]) -> Message | None:
        """Why the arm cannot begin from where it stands; None when it can."""
        cell = state.cell
        if self.arm not in ("", *(arm.name for arm in cell.arms)):
            return Refusal.DROP_NO_ARM(arm=f"{self.arm!r:.60}")
        for arm in cell.arms:
            if not all(math.isfinite(joints.get(name, math.nan)) for name in arm.joints):
                return Refusal.DROP_NO_JOINTS(arm=arm.name)
        drops = self._arm_in(state, joints)
        for arm in cell.arms:
            if arm is not drops and not _is_home(cell, arm, joints):
                return Refusal.DROP_OTHER_ARM(arm=arm.name)
            if arm is not drops and arm.name in arms_that_may_hold(state):
                return Refusal.DROP_OTHER_HOLDS(arm=arm.name)
        return tool_problem(drops.tool)


@dataclass(frozen=True, slots=True, eq=False)
class ConfirmHandsEmpty(Command):
    """A person has seen that hands hold nothing.

    `arm`: the name of the one whose hand is empty; without it: those of all arms.
    """

    right: ClassVar[Right] = Right(CommandText.CONFIRM_HANDS_EMPTY, SAFE)

    arm: str = ""

    def check(self, state: State, asked: Asked) -> None:
        check_text("arm", self.arm)
        if self.arm not in ("", *(arm.name for arm in state.cell.arms)):
            raise CommandRefused(Refusal.DROP_NO_ARM(arm=f"{self.arm!r:.60}"))
        if not may_hold(state) and not arms_that_may_hold(state):
            raise CommandRefused(Refusal.HANDS_EMPTY())

    def apply(self, state: State, entry: Entry) -> Decision:
        arms = (self.arm,) if self.arm else tuple(arm.name for arm in state.cell.arms)
        after = replace(
            state,
            hands_emptied=(*(arm for arm in state.hands_emptied if arm not in arms), *arms),
            hands_open=tuple(arm for arm in state.hands_open if arm not in arms),
            message=StateText.HANDS_EMPTY(person=entry.actor, arms=arms),
        )
        return after, ()


def _is_home(cell: Cell, arm: Arm, joints: Mapping[str, float]) -> bool:
    off = shift_of(cell, arm, arm.home, joints)
    return off.shift <= off.allowed
