"""The preview: who has watched the plan to its end."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

from workbench.app.core.command import Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.people import NOBODY, is_same_person
from workbench.app.core.state import Phase, State
from workbench.app.core.value_checks import named_plan
from workbench.model.digest import LATER, called
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import StateText


@dataclass(frozen=True, slots=True, eq=False)
class WatchPlan(Command):
    """The plan with this digest was played to its end before somebody's eyes, and its row with it.

    `row` are the digests of the plans after it.  `is_reported`: a program says so, and no browser
    has confirmed that it has drawn it.
    """

    # Several people may have to approve, each of whom has to see the plan: only one is in control.
    right: ClassVar[Right] = Right(
        CommandText.WATCH_PLAN, frozenset({Phase.PLANNED, Phase.APPROVED}), without_control=True
    )

    plan_digest: str
    is_reported: bool = field(default_factory=bool, metadata={**LATER, **called("is_told")})
    row: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)

    def check(self, state: State, asked: Asked) -> None:
        named_plan(state, self.plan_digest)
        refuse(other_row(state, self.row))

    def apply(self, state: State, entry: Entry) -> Decision:
        return with_watched(state, entry.actor, is_reported=self.is_reported), ()


def with_watched(state: State, actor: str, *, is_reported: bool) -> State:
    """The state after a person has watched the plan to its end, or a program states so."""
    reported, watched = state.watched_elsewhere, state.watched
    if actor not in watched:
        watched, reported = (*watched, actor), (*reported, actor) if is_reported else reported
    elif not is_reported:
        reported = tuple(name for name in reported if name != actor)
    message = StateText.PLAYED()
    if is_reported:
        message = StateText.PLAYED_BY_REPORT(person=actor)
    return replace(state, watched=watched, watched_elsewhere=reported, message=message)


def explain_unwatched(state: State, actor: str) -> Message | None:
    """Why a person must watch the plan before approving it; None when that has happened.

    A plan that was played in a browser without a login counts for every person.
    """
    seen = any(is_same_person(name, actor) or name == NOBODY for name in state.watched)
    return None if seen else Refusal.NOT_PLAYED()


def has_seen(state: State, actor: str) -> bool:
    """Whether the page has shown a person the whole plan; a program's claim is not enough."""
    drawn = [name for name in state.watched if name not in state.watched_elsewhere]
    return any(is_same_person(name, actor) or name == NOBODY for name in drawn)


def other_row(state: State, named: tuple[str, ...]) -> Message | None:
    """Why the plans named are not those that follow the plan; None when they are.

    A person who has watched one row has not watched another one.
    """
    have = tuple(proven_plan.plan.digest for proven_plan in state.row)
    if named == have:
        return None
    if not have:
        return Refusal.NOTHING_FOLLOWS()
    return Refusal.OTHER_ROW(plans=tuple(digest[:12] for digest in have))
