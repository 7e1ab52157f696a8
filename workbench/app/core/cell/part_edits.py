"""Grasps and symmetry of a part: edited, and drafts of them that are dropped."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

from workbench.app.core.cell.changes import Changed, changed_cell
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse_input
from workbench.app.core.effects import RemoveDraft
from workbench.app.core.people import Role
from workbench.app.core.state import State
from workbench.app.core.value_checks import check_says
from workbench.formats.parts.grasp_files import as_written
from workbench.model.cell import Cell
from workbench.model.digest import LATER, digest_of
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.commands import CommandText, GraspEditText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.messages.states import StateText
from workbench.model.part import Entry as GraspEntry
from workbench.model.part import GraspLibrary, GraspPair, GraspPattern, Part
from workbench.model.part_edits import edit_library, with_part
from workbench.model.symmetry import Symmetry

MOST_GRASPS = 10_000
"""Of one part, with patterns and symmetry written out."""


@dataclass(frozen=True, slots=True, eq=False)
class EditPart(Command):
    """Change the grasps of a part, or its symmetry; undone and redone with the cell.

    `was` are the entries as the one who edits has seen them, `now` what shall stand in their
    place: who edits something that was changed meanwhile is refused.  So are `pairs_was` and
    `pairs`.  `searches`: of the library.  None: as it is.
    """

    right: ClassVar[Right] = Right(
        CommandText.EDIT_PART, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    part: str
    was: tuple[GraspEntry, ...] = ()
    now: tuple[GraspEntry, ...] = ()
    pairs: tuple[GraspPair, ...] | None = None
    symmetry: Symmetry | None = None
    says: Message | str = ""
    searches: bool | None = None
    pairs_was: tuple[GraspPair, ...] | None = field(default_factory=lambda: None, metadata=LATER)

    def check(self, state: State, asked: Asked) -> None:
        check_says("says", self.says)
        check_edit(state.cell, self)

    def apply(self, state: State, entry: Entry) -> Decision:
        return edited_cell(state, self)


@dataclass(frozen=True, slots=True, eq=False)
class DropDraft(Command):
    """Forget the changes of a part's grasps that an earlier session has not saved."""

    right: ClassVar[Right] = Right(
        CommandText.DROP_DRAFT, SAFE, role=Role.ENGINEER, changes_cell=True
    )

    part: str

    def check(self, state: State, asked: Asked) -> None:
        part_of(state.cell, self.part)

    def apply(self, state: State, entry: Entry) -> Decision:
        message = StateText.DRAFT_DROPPED(part=self.part)
        return replace(state, message=message), (RemoveDraft(self.part),)


def edited_cell(state: State, edit: EditPart) -> Changed:
    """The state with other grasps or another symmetry of a part."""
    part = edited_part(state.cell.part(edit.part), edit)
    cell = with_part(state.cell, part.name, library=part.library, symmetry=part.symmetry)
    return changed_cell(state, cell, edit.says or GraspEditText.CHANGED(part=part.name))


def part_of(cell: Cell, name: str) -> Part:
    """The part of that name.

    Raises:
        CommandRefused: there is none.
    """
    with refuse_input():
        return cell.part(name)


def check_edit(cell: Cell, edit: EditPart) -> None:
    """What is edited is there, and what comes of it can be kept in files.

    Raises:
        CommandRefused: it is not, or cannot.
    """
    part = part_of(cell, edit.part)
    with refuse_input():
        after = edited_part(part, edit)
    if after.digest == part.digest:
        raise CommandRefused(ChangeRefusal.PART_AS_IT_WAS(part=part.name))


def edited_part(part: Part, edit: EditPart) -> Part:
    """The part after an edit, its numbers as files hold them.

    Raises:
        InputError: what was edited is not there any more, or cannot be kept in a file.
    """
    symmetry = edit.symmetry or part.symmetry
    symmetry.check()
    # Counted before anything is written out.
    _check_count(edit.now, symmetry)
    library = part.library
    if edit.was or edit.now:
        library = edit_library(library, edit.was, as_written(GraspLibrary(edit.now)).entries)
    if edit.pairs is not None:
        if edit.pairs_was is not None and digest_of(edit.pairs_was) != digest_of(
            part.library.pairs
        ):
            raise InputError(ChangeRefusal.PAIRS_CHANGED(part=part.name))
        library = as_written(replace(library, pairs=edit.pairs))
    if edit.searches is not None:
        library = replace(library, searches=edit.searches)
    _check_count(library.entries, symmetry)
    return replace(part, library=library, symmetry=symmetry)


def _check_count(entries: Sequence[GraspEntry], symmetry: Symmetry) -> None:
    count = sum(entry.count if isinstance(entry, GraspPattern) else 1 for entry in entries)
    count *= 1 + len(symmetry.turns)
    if count > MOST_GRASPS:
        raise InputError(ChangeRefusal.MOST_GRASPS(count=f"{count:,}", most=f"{MOST_GRASPS:,}"))
