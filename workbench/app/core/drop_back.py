"""What a hand holds that it should not: when an arm may drop it back, and how that is planned."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.standing import shift_of
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Outcome
from workbench.app.core.state import Phase, State, is_remembered, sent_for
from workbench.app.core.tasks import begin_task
from workbench.app.core.value_checks import SEED_LIMIT, check_integer, check_text
from workbench.model.cell import Arm, Cell
from workbench.model.derived.row_parts import count_taken, parts_taken
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import StateText
from workbench.model.plan import Plan
from workbench.model.release import PickResult
from workbench.model.tools.held_body import HeldAmount, drop_problem, tool_problem


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
        refuse(drop_problem(state.cell) or self._start_problem(state, asked.joints))

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
        moved = [cell.arm(arm.arm) for plan in last_sent(state) for arm in plan.arms]
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
            if arm is not drops and arm.name in _arms_that_may_hold(state):
                return Refusal.DROP_OTHER_HOLDS(arm=arm.name)
        return tool_problem(drops.tool)


def _is_home(cell: Cell, arm: Arm, joints: Mapping[str, float]) -> bool:
    off = shift_of(cell, arm, arm.home, joints)
    return off.shift <= off.allowed


def last_sent(state: State) -> tuple[Plan, ...]:
    """The plans that were sent last, the last one first; none where nothing was sent."""
    sent = sent_for(state)
    return () if sent is None else sent.plans[::-1]


def may_hold(state: State) -> bool:
    """Whether a hand may hold something that it should not, by what was sent last.

    So it is after a fault, and where a part was not picked alone, until it was dropped back or a
    scan came.
    """
    has_ended = state.phase in (Phase.IDLE, Phase.DONE)
    results = (outcome for _, outcome in _parts_sent_for(state) if outcome is not None)
    is_odd = any(outcome.became is not PickResult.PICKED for outcome in results)
    return is_drop_next(state) or (has_ended and is_odd)


def is_drop_next(state: State) -> bool:
    """Whether a drop back is what comes next: after a fault, and where a second part came."""
    if state.phase not in (Phase.IDLE, Phase.DONE):
        return False
    outcomes = [outcome for _, outcome in _parts_sent_for(state)]
    # A fault that was acknowledged leaves what was sent behind, and no word of its parts.
    is_open = state.phase is Phase.IDLE and any(outcome is None for outcome in outcomes)
    return is_open or any(
        outcome is not None and outcome.became is PickResult.DOUBLE for outcome in outcomes
    )


def _parts_sent_for(state: State) -> Iterator[tuple[str, Outcome | None]]:
    """The arm of each part that was sent for last, and what became of it, as far as stated.

    Arms that have dropped back what they held since are left out.
    """
    sent = sent_for(state)
    if sent is None or not sent.plans:
        return
    outcomes = {outcome.detection: outcome for outcome in sent.outcomes}
    for plan in sent.plans:
        for number, arm in zip(parts_taken(sent.plans[0], plan), plan.picks, strict=True):
            if arm.arm not in state.hands_emptied:
                yield arm.arm, outcomes.get(number)


def _arms_that_may_hold(state: State) -> frozenset[str]:
    """The arms that have taken a part of which nobody has stated that it left the hand.

    A gripper that has felt a part says nothing of its place.
    """
    plans = last_sent(state)
    has_ended = state.phase is Phase.DONE and not is_remembered(state)
    if has_ended and plans and state.parts_placed >= count_taken(plans[::-1]):
        return frozenset()
    lost = (PickResult.FAILED, PickResult.DROPPED)
    return frozenset(
        arm
        for arm, outcome in _parts_sent_for(state)
        if outcome is None
        or outcome.became is PickResult.DOUBLE
        or (outcome.became not in lost and outcome.by == ROBOT_LINK)
    )
