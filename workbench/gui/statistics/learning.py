"""Grasps for the parts that stayed in the bin: looked for where they lay, and added in one step."""

import logging
import threading
from collections import Counter
from collections.abc import Sequence

import viser

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.statistics.remaining import RemainingPart
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line, said
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.statistics import StatisticsText
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.commands import GraspEditText
from workbench.model.messages.message import Message, as_message

log = logging.getLogger(__name__)


class LearningControls:
    """Adds families of grasps to the library of the kind of part that was left most often.

    Concurrency: callbacks of viser and the renderer's thread; one thread looks at a time.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls, out of sight until some part was left."""
        self._visitor = visitor
        self._left: tuple[RemainingPart, ...] = ()
        self._cancelled = threading.Event()
        self._is_busy = False
        gui = visitor.gui
        self._button = gui.add_button(
            "Add grasps for the parts left",
            icon=viser.Icon.BULB,
            hint="Tries what the tools can hold where the parts of the commonest kind lay, and "
            "adds families of grasps that take them. Undo takes them back.",
            visible=False,
        )
        self._line = gui.add_html("", visible=False)
        self._button.on_click(lambda _: self._begin())
        visitor.on_end(self._cancelled.set)

    def show(self, view: View) -> None:
        """Offer the button where parts were left of which the cell has the kind."""
        kinds = {part.name for part in view.state.cell.parts}
        self._left = tuple(
            remaining for remaining in view.statistics.remaining if remaining.part in kinds
        )
        self._button.visible = bool(self._left)
        busy = "grasps are being looked for" if self._is_busy else ""
        self._visitor.admit(self._button, view.state, EditPart, otherwise=busy)

    def _begin(self) -> None:
        if self._is_busy or not self._left:
            return
        self._is_busy = True
        self._button.disabled = True
        threading.Thread(target=self._work, name="learning", daemon=True).start()

    def _work(self) -> None:
        # Physics, which most sessions spare.
        from workbench.app.filling.fill_apart import propose_apart
        from workbench.app.filling.words import proposal_words

        left, cell = self._left, self._visitor.cell
        name = Counter(remaining.part for remaining in left).most_common(1)[0][0]
        says: list[str] = []
        try:
            found = propose_apart(cell, name, left, self._report, self._cancelled)
            says = [said(message, self._visitor.words) for message in proposal_words(name, found)]
            if found.entries:
                says_edit = GraspEditText.LEARNED(part=name)
                edit = EditPart(name, (), found.entries, says=says_edit)
                says = says if self._visitor.ask(lambda: edit) else []
        except JobCancelled:
            says = []
        except WorkbenchError as error:
            says = [self._visitor.words.render(error.message)]
        except Exception as error:
            # A rim: a library without the new grasps stays as it is.
            log.exception("grasps for parts that were left could not be made")
            self._visitor.notify("Internal error", f"{type(error).__name__}: {error}")
        self._is_busy = False
        self._show_lines(says)
        state = self._visitor.bench.state
        self._visitor.admit(self._button, state, EditPart)

    def _report(self, done: float, note: Message | str) -> None:
        progress = StatisticsText.PROGRESS(done=done, note=as_message(note))
        self._show_lines([self._visitor.words.render(progress)])

    def _show_lines(self, says: Sequence[str]) -> None:
        self._line.content = "".join(line(text, kind="hint") for text in says)
        self._line.visible = bool(says)
