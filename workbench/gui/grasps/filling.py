"""The button that fills the library with the grasps by which the cell's bin is emptied."""

import logging
import threading

import viser

from workbench.app.core.cell.part_edits import EditPart
from workbench.gui.grasps.editing import Editing
from workbench.gui.shared.views import line, said
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.gui.texts.statistics import StatisticsText
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.commands import GraspEditText
from workbench.model.messages.message import Message, as_message

log = logging.getLogger(__name__)


class FillControls:
    """Fills the library of the part in a thread of its own, and adds what is found in one step.

    Concurrency: callbacks of viser and the renderer's thread; one thread fills at a time.
    """

    def __init__(self, visitor: Visitor, editing: Editing):
        """Add the controls."""
        self._visitor, self._editing = visitor, editing
        self._cancelled = threading.Event()
        self._is_filling = False
        gui = visitor.gui
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._fill = gui.add_button(
            "Fill the library",
            icon=viser.Icon.STACK,
            hint="Tries what the tools can hold in simulated piles of the part, and adds families "
            "of grasps by what each takes. Takes about a minute.",
        )
        self._stop = gui.add_button("Stop", icon=viser.Icon.X, color="gray", disabled=True)
        self._line = gui.add_html("")
        self._fill.on_click(lambda _: self._begin())
        self._stop.on_click(lambda _: self._cancelled.set())
        visitor.on_end(self._cancelled.set)

    def show(self) -> None:
        """Whether it can be pressed now."""
        busy = "the library is being filled" if self._is_filling else ""
        self._visitor.admit(self._fill, self._visitor.bench.state, EditPart, otherwise=busy)
        self._visitor.allow(self._stop, "" if self._is_filling else "nothing is being filled")

    def _begin(self) -> None:
        if self._is_filling:
            return
        self._cancelled.clear()
        self._is_filling = True
        self._editing.notify()
        threading.Thread(target=self._work, name="filling", daemon=True).start()

    def _work(self) -> None:
        # Physics, which most sessions spare.
        from workbench.app.filling.fill_apart import fill_apart
        from workbench.app.filling.words import filled_words

        part, cell = self._editing.part, self._visitor.cell  # as they are when it begins
        says: list[str] = []
        try:
            found = fill_apart(cell, part, self._report, self._cancelled)
            says = [said(message, self._visitor.words) for message in filled_words(found)]
            count = len(found.entries)
            if self._editing.part.name != part.name:
                says = [self._visitor.words.render(GraspText.OTHER_PART(part=part.name))]
            elif count:
                self._editing.add(found.entries, GraspEditText.FILLED(count=count))
            else:
                says = [*says, "Nothing was found to add."]
        except JobCancelled:
            says = ["Stopped: nothing was added."]
        except WorkbenchError as error:
            says = [self._visitor.words.render(error.message)]
        except Exception as error:
            # A rim: a library that cannot be filled stays as it is.
            log.exception("the library of a part could not be filled")
            self._visitor.notify("Internal error", f"{type(error).__name__}: {error}")
        self._is_filling = False
        self._line.content = "".join(line(text, kind="hint") for text in says)
        self._editing.notify()

    def _report(self, done: float, note: Message | str) -> None:
        progress = StatisticsText.PROGRESS(done=done, note=as_message(note))
        self._line.content = line(self._visitor.words.render(progress), kind="hint")
