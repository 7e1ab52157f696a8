"""The preview: before whose eyes the plan was played to its end."""

from dataclasses import dataclass, field, replace
from typing import ClassVar

from workbench.app.core.command import Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.people import NOBODY, is_same_person
from workbench.app.core.state import Phase, State
from workbench.app.core.value_checks import named_plan
from workbench.model.digest import LATER

NOT_PLAYED = "the plan has not been played to its end; play it first"


@dataclass(frozen=True, slots=True, eq=False)
class WatchPlan(Command):
    """The plan with this digest was played to its end before somebody's eyes, and its row with it.

    `row` are the digests of the plans after it.  `is_told`: a program says so, and no browser has
    confirmed that it has drawn it.
    """

    # Several people may have to approve, each of whom has to see the plan: only one is in control.
    right: ClassVar[Right] = Right(
        "a preview", frozenset({Phase.PLANNED, Phase.APPROVED}), without_control=True
    )

    plan_digest: str
    is_told: bool = field(default_factory=bool, metadata=LATER)
    row: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)

    def check(self, state: State, asked: Asked) -> None:
        named_plan(state, self.plan_digest)
        refuse(other_row(state, self.row))

    def apply(self, state: State, entry: Entry) -> Decision:
        return with_watched(state, entry.actor, is_told=self.is_told), ()


def with_watched(state: State, actor: str, *, is_told: bool) -> State:
    """The state after the plan was played to its end before somebody, or a program said so."""
    reported, watched = state.told, state.watched
    if actor not in watched:
        watched, reported = (*watched, actor), (*reported, actor) if is_told else reported
    elif not is_told:
        reported = tuple(name for name in reported if name != actor)
    message = "the plan was played to its end"
    if is_told:
        message = f"a program says that the plan was played to its end before {actor}"
    return replace(state, watched=watched, told=reported, message=message)


def unwatched(state: State, actor: str) -> str:
    """Why a person has to see the plan before approving it; empty when that has happened.

    What was played in a browser without a login was played before whoever was there.
    """
    seen = any(is_same_person(name, actor) or name == NOBODY for name in state.watched)
    return "" if seen else NOT_PLAYED


def has_seen(state: State, actor: str) -> bool:
    """Whether a page has drawn the plan to its end before a person; a program's word is none."""
    drawn = [name for name in state.watched if name not in state.told]
    return any(is_same_person(name, actor) or name == NOBODY for name in drawn)


def other_row(state: State, named: tuple[str, ...]) -> str:
    """Why the plans named are not those that follow the plan; empty when they are.

    Who has seen or read one row has said nothing about another one.
    """
    have = tuple(proven_plan.plan.digest for proven_plan in state.row)
    if named == have:
        return ""
    there = ", ".join(digest[:12] for digest in have) or "none"
    return (
        f"the plans that follow this one are {there}, not those that were named: look at the "
        "current row and decide again"
    )
