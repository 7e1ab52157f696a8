"""The session: started, opened again, and what has changed since the start before."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.command import (
    EVERY_PHASE,
    SAFE,
    Asked,
    Command,
    Decision,
    Entry,
    Right,
    refuse,
)
from workbench.app.core.people import Role
from workbench.app.core.rights import changes_said
from workbench.app.core.state import Phase, State, without_approval
from workbench.app.core.value_checks import check_text
from workbench.app.provenance.inventory import Inventory
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message, plain
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.states import StateText


@dataclass(frozen=True, slots=True, eq=False)
class Started(Command):
    """The workbench has begun with this session, and `ran` lists its software and machine.

    `changes` says what is otherwise than at the start before, which `since` names, and what nobody
    had acknowledged then.  `is_trial`: a demonstration, which no later start is compared with.
    """

    right: ClassVar[Right] = Right(
        CommandText.STARTED, EVERY_PHASE, beside_job=True, by_machine=True
    )

    ran: Inventory
    changes: tuple[Message | str, ...] = ()
    since: str = ""
    is_trial: bool = False

    def apply(self, state: State, entry: Entry) -> Decision:
        return apply_start(state, self), ()


@dataclass(frozen=True, slots=True, eq=False)
class Opened(Command):
    """A bench goes on with this session: by a new start, or with a copy of it elsewhere.

    Words and approvals belong to one start of one bench: those given before have ended.
    """

    right: ClassVar[Right] = Right(
        CommandText.OPENED, EVERY_PHASE, beside_job=True, by_machine=True
    )

    def apply(self, state: State, entry: Entry) -> Decision:
        return opened_again(state), ()


@dataclass(frozen=True, slots=True, eq=False)
class AcknowledgeChanges(Command):
    """How software, machine or people differ from the start before was seen: `ran`, its digest."""

    # While nothing moves, by whoever answers for the machine; a task that runs is not held up.
    right: ClassVar[Right] = Right(
        CommandText.ACKNOWLEDGE_CHANGES,
        SAFE,
        beside_job=True,
        role=Role.ENGINEER,
        without_control=True,
    )

    ran: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("ran", self.ran)
        refuse(changes_problem(state, self.ran))

    def apply(self, state: State, entry: Entry) -> Decision:
        return acknowledge_changes(state, entry.actor), ()


@dataclass(frozen=True, slots=True, eq=False)
class WriteNote(Command):
    """Write a note into the session: what somebody saw or did at the cell."""

    right: ClassVar[Right] = Right(
        CommandText.WRITE_NOTE, EVERY_PHASE, beside_job=True, without_control=True
    )

    text: str

    def check(self, state: State, asked: Asked) -> None:
        check_text("text", self.text)
        if not self.text.strip():
            raise CommandRefused(ChangeRefusal.NOTE_EMPTY())

    def apply(self, state: State, entry: Entry) -> Decision:
        message = StateText.NOTE(person=entry.actor, text=plain(self.text))
        return replace(state, message=message), ()


@dataclass(frozen=True, slots=True, eq=False)
class PosesRefused(Command):
    """A file that came into the watched folder cannot be used; `problem` says why."""

    right: ClassVar[Right] = Right(
        CommandText.POSES_REFUSED, EVERY_PHASE, beside_job=True, by_machine=True
    )

    problem: str

    def apply(self, state: State, entry: Entry) -> Decision:
        return replace(state, message=StateText.POSES_REFUSED(problem=plain(self.problem))), ()


def apply_start(state: State, start: Started) -> State:
    """The state after a start: what had changed by then stays until it is acknowledged."""
    changed = tuple(dict.fromkeys((*state.changed, *start.changes)))
    since = state.changed_since or start.since
    after = replace(state, ran=start.ran, changed=changed, changed_since=since if changed else "")
    after = replace(after, tools_unknown=_unstated(state))
    return replace(after, message=changes_said(after)) if start.changes else after


def opened_again(state: State) -> State:
    """The state of a session that a bench continues, possibly a copy of it elsewhere.

    Views and approvals of the plan are void: they were given at another bench.
    """
    had, message = state.votes or state.approval or state.watched, state.message
    if had and state.phase in (Phase.PLANNED, Phase.APPROVED):
        message = StateText.OPENED_AGAIN()
    state = replace(without_approval(state), unapproved_by="", earlier=None, may_have_moved=None)
    state = replace(state, tools_unknown=_unstated(state))
    return replace(state, watched=(), watched_elsewhere=(), message=message)


def _unstated(state: State) -> tuple[str, ...]:
    """The arms whose tool is unknown after a start: those with tool slots.

    A robot that is simulated from this start on carries the tools of the cell file.
    """
    if state.cell.controller.is_simulated:
        return state.tools_unknown
    changing = (arm.name for arm in state.cell.arms if arm.tool_slots)
    return tuple(dict.fromkeys((*state.tools_unknown, *changing)))


def changes_problem(state: State, ran: str) -> Message | None:
    """Why a person who saw the inventory `ran` cannot acknowledge the changes; else None."""
    if not state.changed or state.ran is None:
        return ChangeRefusal.NOTHING_CHANGED()
    if state.ran.digest != ran:
        digest = state.ran.digest[:12]
        return ChangeRefusal.OTHER_CHANGES(digest=digest, named=repr(ran[:12]))
    return None


def acknowledge_changes(state: State, actor: str) -> State:
    """The state after a person has acknowledged the changes."""
    message = StateText.CHANGES_ACKNOWLEDGED(person=actor, since=state.changed_since)
    return replace(state, changed=(), changed_since="", message=message)
