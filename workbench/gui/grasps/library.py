"""A part's grasps as a whole: pairs for two arms, and what was saved and not saved."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import viser

from workbench.app.core.cell.changes import SaveCell
from workbench.app.core.cell.part_edits import DropDraft
from workbench.app.core.state import State
from workbench.app.picking.part_import import PARTS
from workbench.formats.parts.grasp_words import changes_in_words
from workbench.formats.parts.saves import Version, draft_of, versions
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.views import pairs_html, texts_html, versions_html
from workbench.gui.help.groups import group
from workbench.gui.shared.views import line, not_saved, sentence
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.messages.commands import GraspEditText
from workbench.model.messages.message import Message
from workbench.model.part import GraspLibrary, GraspPair, Part
from workbench.words.words import Words

NONE: str = "-"
NOW: str = "as it is in the file"


class PairControls:
    """Which grasp of one arm goes with which of the other.

    Concurrency: callbacks of viser and the renderer's thread; handles only.
    """

    def __init__(self, visitor: Visitor, editing: Editing):
        """Add the controls."""
        self._visitor, self._editing = visitor, editing
        gui = visitor.gui
        self._list = gui.add_html("")
        self._first = gui.add_dropdown("First arm by", (NONE,))
        self._second = gui.add_dropdown("Second arm by", (NONE,))
        self._is_ordered = gui.add_checkbox("In this order", False, hint="The first goes first.")
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._add = gui.add_button("Add pair", icon=viser.Icon.LINK)
        self._clear = gui.add_button("Remove pairs", icon=viser.Icon.TRASH, color="gray")
        self._add.on_click(lambda _: self._add_pair())

        @self._clear.on_click
        def _(_: Any) -> None:
            editing.set_pairs(editing.part.library.pairs, (), GraspEditText.NO_PAIRS())

    def show(self, part: Part, *, problem: str) -> None:
        """The part is this one now."""
        names = tuple(entry.name for entry in part.library.entries) or (NONE,)
        for dropdown in (self._first, self._second):
            if dropdown.options != names:
                dropdown.options = names
        self._list.content = pairs_html(part.library.pairs, self._visitor.words)
        allow, missing = self._visitor.allow, "put a grasp on the part first"
        allow(self._add, problem or (missing if names == (NONE,) else ""))
        allow(self._clear, problem or ("" if part.library.pairs else "there are no pairs"))

    def _add_pair(self) -> None:
        pair = GraspPair(self._first.value, self._second.value, bool(self._is_ordered.value))
        known = self._editing.part.library.pairs
        says = GraspEditText.PAIR(first=pair.first, second=pair.second)
        self._editing.set_pairs(known, (*known, pair), says)


class LibraryControls:
    """Save with a remark, what was changed since, older versions, a draft that was left.

    Concurrency: callbacks of viser and the renderer's thread; handles only.
    """

    def __init__(
        self, visitor: Visitor, editing: Editing, not_applied: Callable[[], str] = lambda: ""
    ):
        """Add the controls; `not_applied` returns what a person does first with typed fields."""
        self._visitor, self._editing, self._not_applied = visitor, editing, not_applied
        self._known: tuple[Version, ...] = ()
        self._is_saving = False
        gui = visitor.gui
        self._draft = gui.add_html("")
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._take = gui.add_button("Take the draft", icon=viser.Icon.HISTORY, visible=False)
        self._drop = gui.add_button(
            "Discard draft", icon=viser.Icon.TRASH, color="gray", visible=False
        )
        self._changes = gui.add_html("")
        self._remark = gui.add_text("Remark", "", hint="Why the grasps were changed; kept.")
        self._save = gui.add_button(
            "Save", icon=viser.Icon.DEVICE_FLOPPY, hint="All changes of cell and parts."
        )
        with group(gui, "Versions", expand_by_default=False):
            self._list = gui.add_html("")
            self._version = gui.add_dropdown("Version", (NOW,))
            self._words = gui.add_html("")
            self._back = gui.add_button("Restore version", icon=viser.Icon.ARROW_BACK_UP)
        self._save.on_click(lambda _: self._save_library())
        visitor.on_press(self._drop, lambda: DropDraft(editing.part.name))
        self._take.on_click(lambda _: self._on_take())
        self._back.on_click(lambda _: self._gone_back())
        self._version.on_update(lambda _: self._show_words(editing.part))

    @property
    def _folder(self) -> Path | None:
        known, name = self._visitor.folders, self._editing.part.name
        if name in known or not known:
            return known.get(name)
        # It has come since; where it lies is where every new part goes.
        return PARTS / name if (PARTS / name).is_dir() else None

    def show(self, state: State, part: Part, *, problem: str) -> None:
        """The part is this one now."""
        is_changed = not state.is_saved
        if self._is_saving and not is_changed:
            self._is_saving, self._remark.value = False, ""
        folder = self._folder
        known: tuple[Version, ...] = ()
        draft: GraspLibrary | None = None
        try:
            known = versions(folder) if folder is not None else ()
            draft = draft_of(folder) if folder is not None and not is_changed else None
            self._show_draft(part, draft)
        except InputError as error:
            self._draft.content = line(str(error), kind="bad")
        self._known = known
        self._take.visible = self._drop.visible = draft is not None
        for button in (self._take, self._drop):
            self._visitor.allow(button, problem)
        self._list.content = versions_html(known)
        options = (
            NOW,
            *(f"{version.number}: {version.remark[:30]}" for version in reversed(known)),
        )
        if self._version.options != options:
            self._version.options = options
        self._show_words(part)
        self._visitor.allow(self._back, problem)
        self._show_changes(state, part)

    @property
    def save_button(self) -> viser.GuiButtonHandle:
        """Saves all changes."""
        return self._save

    def follow_typed(self) -> None:
        """Show whether there is something to save after a person has typed something."""
        self._show_changes(self._visitor.bench.state, self._editing.part)

    def _show_changes(self, state: State, part: Part) -> None:
        """Show what is not in the files: what is typed is in them only after it was applied."""
        typed = self._not_applied()
        self._visitor.admit(self._save, state, SaveCell, otherwise=typed or not_saved(state))
        if typed:
            self._changes.content = line(f"{sentence(typed)}.", kind="warn")
        elif not state.is_saved:
            says = "Changed and not saved; kept as a draft."
            last = self._known[-1] if self._known else None
            self._changes.content = _changes_html(last, part, says, self._visitor.words)
        else:
            self._changes.content = line("Everything is saved.", kind="hint")

    def _save_library(self) -> None:
        """Save with the remark, which goes once it is in the files."""
        if typed := self._not_applied():
            self._visitor.notify("Refused", typed)
            return
        self._is_saving = True
        self._is_saving = self._visitor.save(lambda: SaveCell(self._remark.value))

    def _show_draft(self, part: Part, draft: GraspLibrary | None) -> None:
        if draft is None:
            self._draft.content = ""
            return
        count = len(changes_in_words(part.library, draft))
        self._draft.content = line(self._visitor.words.render(GraspText.DRAFT(count=count)))

    def _chosen_version(self) -> Version | None:
        number = self._version.value.partition(":")[0]
        return next((version for version in self._known if str(version.number) == number), None)

    def _show_words(self, part: Part) -> None:
        version = self._chosen_version()
        says = "The grasps are as in this version."
        self._words.content = (
            "" if version is None else _changes_html(version, part, says, self._visitor.words)
        )

    def _gone_back(self) -> None:
        version = self._chosen_version()
        if version is not None:
            says = GraspEditText.VERSION(version=version.number)
            self._taken_over(lambda: version.library, says)

    def _on_take(self) -> None:
        folder = self._folder
        if folder is not None:
            says = GraspEditText.DRAFT()
            self._taken_over(lambda: draft_of(folder), says)

    def _taken_over(self, read: Callable[[], GraspLibrary | None], says: Message) -> None:
        """Put the library that is read from a file, if it is there, instead of the one now."""
        try:
            library = read()
        except InputError as error:
            self._visitor.notify("Refused", self._visitor.words.render(error.message))
            return
        if library is None:
            return
        if digest_of(library) == digest_of(self._editing.part.library):
            self._visitor.notify("Versions", "the grasps are as in this version already")
            return
        self._editing.take_library(library, says)


def _changes_html(version: Version | None, part: Part, otherwise: str, words: Words) -> str:
    """What a part's grasps have otherwise than a version, if there is one that can be read."""
    try:
        changes = () if version is None else changes_in_words(version.library, part.library)
    except InputError as error:
        return line(words.render(error.message), kind="bad")
    return texts_html(changes, otherwise, words)
