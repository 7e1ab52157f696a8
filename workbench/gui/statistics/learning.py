"""Grasps for the parts that stayed in the bin: searched at their poses, and added in one step."""

import threading
from collections import Counter
from collections.abc import Sequence

import viser

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.statistics.remaining import RemainingPart
from workbench.gui.searching.grasp_search import GraspSearch
from workbench.gui.shared.look import View
from workbench.gui.shared.views import message_text
from workbench.gui.shared.visitor import Visitor
from workbench.model.messages.commands import GraspEditText
from workbench.plugins.progress import Report


class LearningControls:
    """Adds families of grasps to the library of the kind of part that was left most often.

    Concurrency: as `GraspSearch`.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls, out of sight until some part was left."""
        self._visitor = visitor
        self._left: tuple[RemainingPart, ...] = ()
        gui = visitor.gui
        begin = gui.add_button(
            "Add grasps for the parts left",
            icon=viser.Icon.BULB,
            hint="Tries what the tools can hold where the parts of the commonest kind lay, and "
            "adds families of grasps that take them. Undo takes them back.",
            visible=False,
        )
        stop = gui.add_button("Cancel", icon=viser.Icon.X, color="gray", visible=False)
        self._search = GraspSearch(visitor, begin, stop, self._find, self._offer)

    def show(self, view: View) -> None:
        """Offer the search where parts were left of which the cell has the kind."""
        kinds = {part.name for part in view.state.cell.parts}
        self._left = tuple(it for it in view.statistics.remaining if it.part in kinds)
        self._offer()

    def _offer(self) -> None:
        self._search.show(is_offered=bool(self._left))

    def _find(self, report: Report, cancelled: threading.Event) -> Sequence[str]:
        # Physics, which most sessions spare.
        from workbench.app.filling.fill_process import propose_apart
        from workbench.app.filling.words import proposal_words

        left, cell = self._left, self._visitor.cell
        name = Counter(it.part for it in left).most_common(1)[0][0]
        found = propose_apart(cell, name, left, report, cancelled)
        says = [
            message_text(message, self._visitor.words) for message in proposal_words(name, found)
        ]
        if not found.entries:
            return says
        edit = EditPart(name, (), found.entries, says=GraspEditText.LEARNED(part=name))
        return says if self._visitor.ask(lambda: edit) else ()
