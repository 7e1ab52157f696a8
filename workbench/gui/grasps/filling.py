"""What fills a library by itself: families by which the cell's bin is emptied, and the search."""

import threading
from collections.abc import Sequence
from typing import Any

import viser

from workbench.app.core.cell.part_edits import EditPart
from workbench.gui.grasps.editing import Editing
from workbench.gui.searching.grasp_search import GraspSearch
from workbench.gui.shared.views import message_text
from workbench.gui.shared.visitor import Visitor
from workbench.model.messages.commands import GraspEditText
from workbench.plugins.progress import Report


class FillControls:
    """Fills the library of the part, and adds what is found in one step.

    Concurrency: as `GraspSearch`.
    """

    def __init__(self, visitor: Visitor, editing: Editing):
        """Add the controls."""
        self._visitor, self._editing = visitor, editing
        gui = visitor.gui
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        begin = gui.add_button(
            "Fill the library",
            icon=viser.Icon.STACK,
            hint="Tries what the tools can hold in simulated piles of the part, and adds families "
            "of grasps by what each takes. Takes about a minute.",
        )
        stop = gui.add_button("Cancel", icon=viser.Icon.X, color="gray", disabled=True)
        self._search = GraspSearch(visitor, begin, stop, self._find, editing.notify)
        self._plans_search = gui.add_checkbox(
            "Plans search grasps where none takes a part",
            False,
            hint="A plan then tries all grasps of the tools. The proof checks that such a grasp "
            "holds the part.",
        )

        @self._plans_search.on_update
        def _(_: Any) -> None:
            is_on = bool(self._plans_search.value)
            if is_on != editing.part.library.searches and not editing.set_search(is_on=is_on):
                self._plans_search.value = editing.part.library.searches

    def show(self, *, problem: str) -> None:
        """Whether it can be pressed now, and what the part's library says."""
        self._search.show()
        self._plans_search.value = self._editing.part.library.searches
        self._plans_search.disabled = bool(problem)

    def _find(self, report: Report, cancelled: threading.Event) -> Sequence[str]:
        # Physics, which most sessions spare.
        from workbench.app.filling.fill_process import fill_apart
        from workbench.app.filling.words import filled_words

        part, cell = self._editing.part, self._visitor.cell  # as they are when it begins
        found = fill_apart(cell, part, report, cancelled)
        says = [message_text(message, self._visitor.words) for message in filled_words(found)]
        if not found.entries:
            return [*says, "Nothing was found to add."]
        says_filled = GraspEditText.FILLED(count=len(found.entries))
        # Of the part that was searched for, whichever is in hand by now.
        edit = EditPart(part.name, (), found.entries, says=says_filled, searches=True)
        if self._visitor.ask(lambda: edit) and self._editing.part.name == part.name:
            self._editing.show_added(found.entries[0].name)
        return says
