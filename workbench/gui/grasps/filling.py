"""The button that fills the library with the grasps by which the cell's bin is emptied."""

import threading
from collections.abc import Sequence

import viser

from workbench.gui.grasps.editing import Editing
from workbench.gui.searching.grasp_search import GraspSearch
from workbench.gui.shared.views import message_text
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
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

    def show(self) -> None:
        """Whether it can be pressed now."""
        self._search.show()

    def _find(self, report: Report, cancelled: threading.Event) -> Sequence[str]:
        # Physics, which most sessions spare.
        from workbench.app.filling.fill_process import fill_apart
        from workbench.app.filling.words import filled_words

        part, cell = self._editing.part, self._visitor.cell  # as they are when it begins
        found = fill_apart(cell, part, report, cancelled)
        says = [message_text(message, self._visitor.words) for message in filled_words(found)]
        if self._editing.part.name != part.name:
            return [self._visitor.words.render(GraspText.OTHER_PART(part=part.name))]
        if not found.entries:
            return [*says, "Nothing was found to add."]
        self._editing.add(found.entries, GraspEditText.FILLED(count=len(found.entries)))
        return says
