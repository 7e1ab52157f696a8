"""Kits: which parts they have, what they lack, and when a new one is begun."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.state import Phase, PlanState, State, begin_stage, stale_by
from workbench.model.derived.by_recipe import kit_of, wanted_parts
from workbench.model.messages.cells import KitText
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message, Others
from workbench.model.recipes.kit import KitPart, KitProgress, lacking


@dataclass(frozen=True, slots=True, eq=False)
class NewKit(Command):
    """The kit has been taken away, complete or not, and an empty one stands in its place."""

    right: ClassVar[Right] = Right(CommandText.NEW_KIT, SAFE)

    def check(self, state: State, asked: Asked) -> None:
        if not kit_of(state.cell):
            refuse(KitText.NO_KIT())
        refuse(None if state.kit.parts or state.placed else KitText.NOTHING())

    def apply(self, state: State, entry: Entry) -> Decision:
        is_complete = not lacks_of(state)
        kit = KitProgress(
            (), state.kit.complete + is_complete, state.kit.incomplete + (not is_complete)
        )
        before = KitText.BEFORE(complete=kit.complete, incomplete=kit.incomplete)
        message = Others.ALSO(first=KitText.BEGUN(), last=before)
        if state.phase in (Phase.PLANNED, Phase.APPROVED) and state.detections is not None:
            # That plan is for what the kit before lacked, and around what stood there.
            state = begin_stage(
                state, PlanState, phase=Phase.LOCALIZED, stale=stale_by(state, message)
            )
        return replace(state, kit=kit, placed=(), message=message), ()


def lacks_of(state: State) -> Mapping[str, int]:
    """How many parts of each kind the kit lacks; empty where it is complete, or there is none."""
    return lacking(kit_of(state.cell), state.kit.counts)


def kit_problem(state: State) -> Message | None:
    """Why no part can be taken for the kit; None when one can, or there is no kit."""
    wanted = wanted_parts(state.cell, state.kit.counts)
    if wanted is None:
        return None
    if not wanted.counts:
        return KitText.COMPLETE()
    if state.detections and not any(wanted.allows([found.part]) for found in state.detections):
        return KitText.NOT_FOUND(items=_counts(wanted.now))
    return None


def with_kit_part(state: State, plan: str, detection: int, part: str) -> State:
    """The state once a part lies in the kit; one that lies there already is not counted again."""
    kit_part = KitPart(part, plan, detection)
    if not kit_of(state.cell) or kit_part in state.kit.parts:
        return state
    return replace(state, kit=replace(state.kit, parts=(*state.kit.parts, kit_part)))


def without_kit_part(state: State, plan: str, detection: int) -> State:
    """The state once somebody has said that a part did not come into the kit."""
    parts = tuple(
        kit_part
        for kit_part in state.kit.parts
        if (kit_part.plan, kit_part.detection) != (plan, detection)
    )
    return replace(state, kit=replace(state.kit, parts=parts))


def lacks_message(state: State) -> Message | None:
    """What the kit lacks, or that it is complete; None where there is no kit."""
    if not kit_of(state.cell):
        return None
    lacks = lacks_of(state)
    return KitText.LACKS(items=_counts(lacks)) if lacks else KitText.COMPLETE()


def kit_message(state: State) -> Message | None:
    """How many parts of each kind the kit has, of how many; None where there is no kit."""
    counts = state.kit.counts
    items = [
        KitText.ITEM(count=counts.get(item.part, 0), of=item.count, part=item.part)
        for item in kit_of(state.cell)
    ]
    return KitText.STATE(items=items) if items else None


def _counts(lacks: Mapping[str, int]) -> list[Message]:
    return [KitText.LACK(count=count, part=part) for part, count in lacks.items()]
