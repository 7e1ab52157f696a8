"""Who is in control: asked for, taken, handed over, given back."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.command import EVERY_PHASE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.ahead import given_up
from workbench.app.core.people import FRONT_DOOR, MACHINES, Role
from workbench.app.core.state import State
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message, all_of, as_message
from workbench.model.messages.refusals import ControlRefusal, Refusal
from workbench.model.messages.states import AheadText, ControlText, StateText

MOST_ASKING = 20
"""People who have asked and wait for an answer."""


@dataclass(frozen=True, slots=True, eq=False)
class AskForControl(Command):
    """A person would like to be in control; who is may hand it over, or keep it."""

    right: ClassVar[Right] = Right(
        CommandText.ASK_FOR_CONTROL, EVERY_PHASE, beside_job=True, without_control=True
    )

    def check(self, state: State, asked: Asked) -> None:
        refuse(control_problem(state, self, asked.actor, asked.role))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _waiting_for(state, with_control(state, self, entry.actor))


@dataclass(frozen=True, slots=True, eq=False)
class TakeControl(Command):
    """A person is in control from now on: nobody was, or an engineer takes it over."""

    right: ClassVar[Right] = Right(
        CommandText.TAKE_CONTROL, EVERY_PHASE, beside_job=True, without_control=True
    )

    def check(self, state: State, asked: Asked) -> None:
        refuse(control_problem(state, self, asked.actor, asked.role))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _waiting_for(state, with_control(state, self, entry.actor))


@dataclass(frozen=True, slots=True, eq=False)
class GiveControl(Command):
    """Hand control over to somebody who has asked for it."""

    right: ClassVar[Right] = Right(CommandText.GIVE_CONTROL, EVERY_PHASE, beside_job=True)

    to: str

    def check(self, state: State, asked: Asked) -> None:
        refuse(control_problem(state, self, asked.actor, asked.role))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _waiting_for(state, with_control(state, self, entry.actor))


@dataclass(frozen=True, slots=True, eq=False)
class DenyControl(Command):
    """Keep control: what `to` has asked for is answered with no."""

    right: ClassVar[Right] = Right(CommandText.DENY_CONTROL, EVERY_PHASE, beside_job=True)

    to: str

    def check(self, state: State, asked: Asked) -> None:
        refuse(control_problem(state, self, asked.actor, asked.role))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _waiting_for(state, with_control(state, self, entry.actor))


@dataclass(frozen=True, slots=True, eq=False)
class ReleaseControl(Command):
    """Nobody is in control any more.

    `of` is whose it was when that person's last browser has gone, as the front door saw it;
    empty: of the one who gives this.
    """

    right: ClassVar[Right] = Right(
        CommandText.RELEASE_CONTROL, EVERY_PHASE, beside_job=True, also_by=FRONT_DOOR
    )

    of: str = ""

    def check(self, state: State, asked: Asked) -> None:
        refuse(control_problem(state, self, asked.actor, asked.role))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _waiting_for(state, with_control(state, self, entry.actor))


ControlCommand = AskForControl | TakeControl | GiveControl | DenyControl | ReleaseControl


def control_problem(
    state: State, command: ControlCommand, actor: str, role: Role
) -> Message | None:
    """Why a command about control does not count; None when it does.

    Args:
        state: says who is in control, and who has asked for it.
        command: what is asked for.
        actor: whose it is.
        role: the person's; a machine's says nothing.
    """
    match command:
        case AskForControl() | TakeControl() if state.control == actor:
            return ControlRefusal.YOURS()
        case AskForControl():
            return _asking_problem(state, actor)
        case TakeControl():
            is_free = not state.control or role.covers(Role.ENGINEER)
            return None if is_free else Refusal.IN_CONTROL(person=state.control)
        case GiveControl(to=to) | DenyControl(to=to):
            return _answer_problem(state, to)
        case ReleaseControl(of=of):
            return _release_problem(state, of, actor)


def _answer_problem(state: State, to: str) -> Message | None:
    if not state.control:
        return ControlRefusal.NOBODYS()
    if to in state.asking:
        return None
    if not state.asking:
        return ControlRefusal.NOBODY_ASKED(person=repr(to))
    return ControlRefusal.NOT_ASKED(person=repr(to), others=state.asking)


def _asking_problem(state: State, actor: str) -> Message | None:
    if not state.control:
        return ControlRefusal.FREE()
    if actor in state.asking:
        return ControlRefusal.ASKED_ALREADY(person=state.control)
    if len(state.asking) >= MOST_ASKING:
        return ControlRefusal.TOO_MANY_ASK(count=MOST_ASKING)
    return None


def _release_problem(state: State, of: str, actor: str) -> Message | None:
    if not state.control:
        return ControlRefusal.NOBODYS()
    # The front door says whom it has missed: meanwhile somebody else may have taken over.
    if actor in MACHINES:
        is_theirs = of == state.control
        other = ControlRefusal.OTHER_PERSON(person=repr(of), other=state.control)
        return None if is_theirs else other
    if of in ("", actor):
        return None
    return ControlRefusal.NOT_YOURS(person=repr(of), other=repr(actor))


def with_control(state: State, command: ControlCommand, actor: str) -> State:
    """The state after a command about control.

    Args:
        state: before.
        command: what is asked for, which `control_problem` has nothing against.
        actor: whose it is.
    """
    match command:
        case AskForControl():
            message = ControlText.ASKS(person=actor, other=state.control)
            return replace(state, asking=(*state.asking, actor), message=message)
        case TakeControl():
            message = ControlText.TAKES(person=actor)
            if state.control:
                message = ControlText.TAKES_OVER(person=actor, other=state.control)
            return _held_by(state, actor, message)
        case GiveControl(to=to):
            return _held_by(state, to, ControlText.HANDS_OVER(person=actor, other=to))
        case DenyControl(to=to):
            asking = tuple(name for name in state.asking if name != to)
            return replace(state, asking=asking, message=ControlText.KEEPS(person=actor, other=to))
        case ReleaseControl():
            message = ControlText.GIVES_BACK(person=actor)
            if actor in MACHINES:
                message = ControlText.GONE(person=state.control)
            # Who has asked may take it now; there is nobody left to answer.
            return replace(state, control="", asking=(), message=message)


def _held_by(state: State, name: str, message: Message) -> State:
    asking = tuple(person for person in state.asking if person != name)
    return replace(state, control=name, asking=asking, message=message)


def _waiting_for(before: State, after: State) -> Decision:
    """The state after a change of control: no task continues in the name of who gave it away."""
    if after.ahead is not None and after.control != before.control:
        return given_up(after, AheadText.CONTROL_GONE())
    job = after.job
    if job is None or job.then is None or after.control == before.control:
        return after, ()
    words = StateText.ENDS_AFTER_TASK()
    message = all_of((as_message(after.message), words))
    return replace(after, job=replace(job, then=None), message=message), ()
