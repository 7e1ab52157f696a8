"""Parts: searched in a scan or given from outside, and the detections."""

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, ClassVar

from workbench.app.core.cell.bins import with_contents
from workbench.app.core.cell.views import next_view_message, with_nothing_seen
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right
from workbench.app.core.hands import arms_that_may_hold
from workbench.app.core.people import POSES_FOLDER
from workbench.app.core.state import PartsState, Phase, ScanState, State, begin_stage, stale_by
from workbench.app.core.tasks import Begun, begin_task
from workbench.app.core.value_checks import (
    DETAIL,
    SEED_LIMIT,
    check_detections,
    check_integer,
    check_number,
    check_says,
)
from workbench.model.digest import LATER, called, digest_of
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText, EditText, NameText, StaleText
from workbench.model.messages.message import Message, all_of, as_message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import StateText
from workbench.model.scan import Detection, Remark, SearchOverrides, SearchRecord

if TYPE_CHECKING:
    from workbench.app.core.cycle.ahead import GoOn


MOST_SEARCHES, MOST_REMARKS = 6, 30
"""In one scan, that are remembered."""


@dataclass(frozen=True, slots=True, eq=False)
class FindParts(Command):
    """Localize parts in the current scan.

    `is_compared`: the search is listed with the earlier ones, and a person decides which to take.
    """

    right: ClassVar[Right] = Right(CommandText.FIND_PARTS, SAFE - {Phase.IDLE, Phase.DONE})

    seed: int = 0
    overrides: SearchOverrides = field(default_factory=SearchOverrides, metadata=called("wishes"))
    is_compared: bool = field(default_factory=bool, metadata=LATER)

    @classmethod
    def obstacle(cls, state: State) -> Message | None:
        return Refusal.MOVED_BY_A_MISS() if state.disturbed else None

    def check(self, state: State, asked: Asked) -> None:
        check_search(self)
        if state.scan is None:
            raise CommandRefused(Refusal.SCAN_FIRST())
        if self.is_compared and not state.detections:
            raise CommandRefused(Refusal.NOTHING_TO_COMPARE())

    def apply(self, state: State, entry: Entry) -> Decision:
        return find_parts(state, entry, self)


@dataclass(frozen=True, slots=True, eq=False)
class UseDetections(Command):
    """Take part poses from outside: a file, another matcher, a person's correction or veto.

    `says` states for people what was done; empty: poses from outside.
    """

    right: ClassVar[Right] = Right(CommandText.USE_DETECTIONS, SAFE, also_by=POSES_FOLDER)

    detections: tuple[Detection, ...]
    says: Message | str = ""

    def check(self, state: State, asked: Asked) -> None:
        check_says("says", self.says)
        check_detections(state.cell, self.detections)

    def apply(self, state: State, entry: Entry) -> Decision:
        return with_outside_detections(state, entry, self), ()


def check_search(command: FindParts) -> None:
    """The values of a search are in range.

    Raises:
        CommandRefused: they are not.
    """
    check_integer("seed", command.seed, 0, SEED_LIMIT - 1)
    check_number("detail", command.overrides.detail, *DETAIL, NameText.OF_USUAL)
    check_number(NameText.LEAST_SCORE, command.overrides.least_score, 0.0, 1.0)


def find_parts(
    state: State,
    entry: Entry,
    command: FindParts,
    then: "GoOn | None" = None,
) -> Begun:
    """The search for parts begins; with `then` the next steps of a cycle follow it.

    Raises:
        CommandRefused: there is no scan.
    """
    if state.scan is None:
        raise CommandRefused(Refusal.NO_SCAN())
    arguments = {"scan": state.scan, "seed": command.seed, "overrides": command.overrides}
    return begin_task(
        state,
        entry,
        "localize",
        arguments,
        StateText.SEARCHING(),
        seed=command.seed,
        overrides=command.overrides,
        is_compared=command.is_compared,
        then=then,
    )


def add_search(state: State, search: SearchRecord) -> State:
    """The state after a search that takes nothing: it is listed with the earlier ones."""
    searches = (*state.searches, search)[-MOST_SEARCHES:]
    message = StateText.COMPARED(number=len(searches), count=len(search.detections))
    return replace(state, searches=searches, message=message)


def with_detections(state: State, search: SearchRecord) -> State:
    """The state with what a search has found."""
    detections = search.detections
    message: Message | None = StateText.FOUND(count=len(detections))
    if not detections:
        state = with_nothing_seen(state)
        message = all_of((StateText.NOTHING_FOUND(), next_view_message(state)))
    return begin_stage(
        with_contents(state, is_empty=not detections),
        PartsState,
        phase=Phase.LOCALIZED if detections else Phase.SCANNED,
        searches=(*state.searches, search)[-MOST_SEARCHES:],
        detections=detections,
        scene_digest=state.scan.digest if state.scan is not None else "",
        stale=stale_by(state, StaleText.PARTS_SOUGHT()),
        message=message,
    )


def with_outside_detections(state: State, entry: Entry, command: UseDetections) -> State:
    """The state with parts from outside: a file, another matcher, or a person's correction."""
    detections = command.detections
    says = command.says or EditText.POSES_TAKEN(count=len(detections))
    remark = Remark(entry.at, entry.actor, says)
    # Poses from another matcher usually belong to this scan, but never to a picked bin.
    is_picked = state.phase is Phase.DONE
    before = state.parts_before
    if detections:
        state = with_contents(state, is_empty=False)
    if before and digest_of(before[0]) == digest_of(detections):
        # What was done last is undone.
        before = before[1:]
    elif state.detections:
        before = (state.detections, *before)
    return begin_stage(
        replace(state, unscanned=None, hands_open=tuple(sorted(arms_that_may_hold(state)))),
        ScanState if is_picked else PartsState,
        phase=Phase.LOCALIZED,
        remarks=(*(() if is_picked else state.remarks), remark)[-MOST_REMARKS:],
        parts_before=() if is_picked else before[:MOST_REMARKS],
        detections=detections,
        scene_digest=digest_of(detections),
        stale=None if is_picked else stale_by(state, StaleText.PARTS_CHANGED()),
        message=StateText.PARTS_FROM_OUTSIDE(change=as_message(says), person=entry.actor),
    )
