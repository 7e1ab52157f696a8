"""Parts that are corrected: as large as the scan shows them, and then searched again."""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.cell.changes import change_whole, changed_cell
from workbench.app.core.cell.part_edits import part_of
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right
from workbench.app.core.cycle.parts import FindParts, find_parts
from workbench.app.core.effects import WriteCell
from workbench.app.core.people import Role
from workbench.app.core.state import Phase, State
from workbench.app.core.tasks import begin_task
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText, EditText
from workbench.model.messages.message import Message, all_of, as_message, plain
from workbench.model.messages.refusals import ChangeRefusal, Refusal
from workbench.model.messages.states import StateText
from workbench.model.part import Part

CORRECT = "correct"
"""The task."""


@dataclass(frozen=True, slots=True, eq=False)
class CorrectPart(Command):
    """Have a part as large, and its surface where, the current scan shows it; search again.

    Undone and redone with the cell.  It is written into the part's file at once, unless changes of
    the cell wait to be saved: then it is saved with them.
    """

    right: ClassVar[Right] = Right(
        CommandText.CORRECT_PART,
        SAFE - {Phase.IDLE, Phase.DONE},
        role=Role.ENGINEER,
        changes_cell=True,
    )

    part: str

    @classmethod
    def obstacle(cls, state: State) -> Message | None:
        return Refusal.MOVED_BY_A_MISS() if state.disturbed else None

    def check(self, state: State, asked: Asked) -> None:
        part_of(state.cell, self.part)
        if state.scan is None or not state.detections or not state.searches:
            raise CommandRefused(ChangeRefusal.FIND_FIRST())

    def apply(self, state: State, entry: Entry) -> Decision:
        last = state.searches[-1]
        wanted = {"seed": last.seed, "overrides": last.overrides}
        arguments = {"part": self.part, "scan": state.scan, **wanted}
        says = StateText.CORRECTING(part=self.part)
        return begin_task(state, entry, CORRECT, arguments, says, by=entry.actor, **wanted)


def with_corrected(state: State, number: int, part: Part, entry: Entry) -> Decision:
    """The state with a part as the task has read it, which is searched in the scan again."""
    job = state.job
    if job is None or (job.number, job.name) != (number, CORRECT):
        return state, ()
    says = _changes(state.cell.part(part.name), part)

    def change(whole: State) -> Decision:
        known = whole.cell.part(part.name)
        corrected = replace(part, library=known.library, symmetry=known.symmetry)
        parts = tuple(corrected if each is known else each for each in whole.cell.parts)
        after, effects = changed_cell(whole, replace(whole.cell, parts=parts), says)
        if not whole.is_saved:
            return after, effects
        return after, (*effects, WriteCell(after.cell, str(says), job.by, entry.at, state.saved))

    after, effects = change_whole(replace(state, job=None), change)
    if after.scan is None:
        return after, effects
    searched, task = find_parts(after, entry, FindParts(job.seed, job.overrides))
    message = all_of((says, as_message(searched.message)))
    return replace(searched, message=message), (*effects, *task)


def _changes(known: Part, part: Part) -> Message:
    """How a part differs now, for people."""
    changes: list[Message] = []
    if part.scale != known.scale:
        changes.append(EditText.PART_SCALED(part=part.name, scale=f"{part.scale:g}"))
    if part.offset != known.offset:
        changes.append(EditText.PART_GROWN(part=part.name, offset=part.offset))
    return all_of(changes) or plain("")
