"""Who is in control: asked for, taken, handed over, given back."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.command import EVERY_PHASE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.ahead import discard_ahead
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
        refuse(_asking_problem(state, asked.actor))

    def apply(self, state: State, entry: Entry) -> Decision:
        message = ControlText.ASKS(person=entry.actor, other=state.control)
        return replace(state, asking=(*state.asking, entry.actor), message=message), ()


@dataclass(frozen=True, slots=True, eq=False)
class TakeControl(Command):
    """A person is in control from now on: nobody was, or an engineer takes it over."""

    right: ClassVar[Right] = Right(
        CommandText.TAKE_CONTROL, EVERY_PHASE, beside_job=True, without_control=True
    )

    def check(self, state: State, asked: Asked) -> None:
        if state.control == asked.actor:
            refuse(ControlRefusal.YOURS())
        if state.control and not asked.role.covers(Role.ENGINEER):
            refuse(Refusal.IN_CONTROL(person=state.control))

    def apply(self, state: State, entry: Entry) -> Decision:
        message = ControlText.TAKES(person=entry.actor)
        if state.control:
            message = ControlText.TAKES_OVER(person=entry.actor, other=state.control)
        return _hand_to(entry.actor, state, message)


@dataclass(frozen=True, slots=True, eq=False)
class GiveControl(Command):
    """Hand control over to somebody who has asked for it."""

    right: ClassVar[Right] = Right(CommandText.GIVE_CONTROL, EVERY_PHASE, beside_job=True)

    to: str

    def check(self, state: State, asked: Asked) -> None:
        refuse(_answer_problem(state, self.to))

    def apply(self, state: State, entry: Entry) -> Decision:
        message = ControlText.HANDS_OVER(person=entry.actor, other=self.to)
        return _hand_to(self.to, state, message)


@dataclass(frozen=True, slots=True, eq=False)
class DenyControl(Command):
    """Keep control: what `to` has asked for is answered with no."""

    right: ClassVar[Right] = Right(CommandText.DENY_CONTROL, EVERY_PHASE, beside_job=True)

    to: str

    def check(self, state: State, asked: Asked) -> None:
        refuse(_answer_problem(state, self.to))

    def apply(self, state: State, entry: Entry) -> Decision:
        message = ControlText.KEEPS(person=entry.actor, other=self.to)
        return replace(state, asking=_without(state.asking, self.to), message=message), ()


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
        refuse(_release_problem(state, self.of, asked.actor))

    def apply(self, state: State, entry: Entry) -> Decision:
        message = ControlText.GIVES_BACK(person=entry.actor)
        if entry.actor in MACHINES:
            message = ControlText.GONE(person=state.control)
        # Who has asked may take it now; there is nobody left to answer.
        return _end_tasks(state, replace(state, control="", asking=(), message=message))


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
    if state.control == actor:
        return ControlRefusal.YOURS()
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


def _hand_to(name: str, state: State, message: Message) -> Decision:
    asking = _without(state.asking, name)
    return _end_tasks(state, replace(state, control=name, asking=asking, message=message))


def _without(asking: tuple[str, ...], name: str) -> tuple[str, ...]:
    return tuple(person for person in asking if person != name)


def _end_tasks(before: State, after: State) -> Decision:
    """The state after a change of control: no task continues in the name of who gave it away."""
    if after.ahead is not None and after.control != before.control:
        return discard_ahead(after, AheadText.CONTROL_GONE())
    job = after.job
    if job is None or job.then is None or after.control == before.control:
        return after, ()
    words = StateText.ENDS_AFTER_TASK()
    message = all_of((as_message(after.message), words))
    return replace(after, job=replace(job, then=None), message=message), ()
