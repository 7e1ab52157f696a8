"""Vision only: an engineer may switch approval off, since nothing of the motion is proven anyway.

Where the robot link sends paths none of this is in order.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.approval import check_approvable, let_out
from workbench.app.core.cycle.standing import lacks_reports, left_on_station, stale_because
from workbench.app.core.hands import full_hand_problem
from workbench.app.core.people import NOBODY, Role, is_same_person
from workbench.app.core.state import Phase, State, without_approval
from workbench.app.core.value_checks import check_person, named_plan
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import PosesRefusal, Refusal
from workbench.model.messages.states import PosesText


@dataclass(frozen=True, slots=True, eq=False)
class SwitchApproval(Command):
    """Switch approval off, or on again, for picks whose poses alone go out."""

    right: ClassVar[Right] = Right(CommandText.SWITCH_APPROVAL, SAFE, role=Role.ENGINEER)

    is_off: bool

    def check(self, state: State, asked: Asked) -> None:
        refuse(poses_problem(state))
        if self.is_off not in (True, False):
            raise CommandRefused(PosesRefusal.NO_SWITCH(value=repr(self.is_off)))
        check_person(asked.actor)
        if is_same_person(asked.actor, NOBODY):
            raise CommandRefused(Refusal.NO_LOGIN(person=repr(asked.actor)))

    def apply(self, state: State, entry: Entry) -> Decision:
        # What somebody has let out before was let out under the other rule.
        says = PosesText.OFF if self.is_off else PosesText.ON
        by = entry.actor if self.is_off else ""
        state = replace(without_approval(state), unapproved_by=by)
        return replace(state, message=says(person=entry.actor)), ()


@dataclass(frozen=True, slots=True, eq=False)
class ReleasePoses(Command):
    """Let the poses of the plan with this digest out while approval is switched off."""

    right: ClassVar[Right] = Right(CommandText.RELEASE_POSES, frozenset({Phase.PLANNED}))

    plan_digest: str

    def check(self, state: State, asked: Asked) -> None:
        refuse(release_problem(state))
        plan = named_plan(state, self.plan_digest)
        if state.proof is None:
            raise CommandRefused(Refusal.NO_PROOF())
        if plan.scan_digest != state.scene_digest:
            raise CommandRefused(Refusal.NEWER_SCAN())
        refuse(lacks_reports(state) or left_on_station([plan]))
        check_approvable(state.cell, plan, state.proof, state.unapproved_by)
        refuse(full_hand_problem(state))
        refuse(stale_because(state, plan, asked.joints))

    def apply(self, state: State, entry: Entry) -> Decision:
        plan, proof, by = state.plan, state.proof, state.unapproved_by
        if plan is None or proof is None:
            raise CommandRefused(Refusal.NO_PROVEN_PLAN())
        ran = "" if state.ran is None else state.ran.digest
        approval = replace(let_out(state.cell, plan, proof, by, entry.at), ran=ran)
        message = PosesText.RELEASED(plan=plan.digest[:12], person=by)
        return replace(state, phase=Phase.APPROVED, approval=approval, message=message), ()


def release_problem(state: State) -> Message | None:
    """Why a plan waits for people; None where its poses go out without approval."""
    if problem := poses_problem(state):
        return problem
    if not state.unapproved_by:
        return PosesRefusal.IS_ON()
    return PosesRefusal.ROW() if state.row else None


def poses_problem(state: State) -> Message | None:
    """Why approval has to stay on with the cell's robot link; None where it may be off."""
    motion = state.cell.controller.motion
    return None if motion.sends_poses else PosesRefusal.PATHS(link=motion.link)
