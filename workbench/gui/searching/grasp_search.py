"""A search for grasps behind a button, with a button that stops it and lines of what came of it."""

import logging
import threading
from collections.abc import Callable, Sequence

from viser import GuiButtonHandle

from workbench.app.core.cell.part_edits import EditPart
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.statistics import StatisticsText
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.message import Message, as_message
from workbench.plugins.progress import Report

log = logging.getLogger(__name__)

Find = Callable[[Report, threading.Event], Sequence[str]]
"""Looks for grasps and adds them; takes the progress and what stops it, gives lines for people."""


class GraspSearch:
    """Runs a search in a thread of its own while its button waits.

    Concurrency: callbacks of viser and the renderer's thread; one search runs at a time.
    """

    def __init__(
        self,
        visitor: Visitor,
        begin: GuiButtonHandle,
        stop: GuiButtonHandle,
        find: Find,
        changed: Callable[[], None],
    ):
        """Add the lines below two buttons.

        Args:
            visitor: whose page it is.
            begin: starts a search.
            stop: ends it; nothing is added then.
            find: searches.
            changed: is called as a search begins and ends.
        """
        self._visitor, self._begin_button, self._stop_button = visitor, begin, stop
        self._find, self._changed = find, changed
        self._cancelled = threading.Event()
        self._is_running = False
        self._beginning = threading.Lock()
        self._line = visitor.gui.add_html("")
        begin.on_click(lambda _: self._begin())
        stop.on_click(lambda _: self._cancelled.set())
        visitor.on_end(self._cancelled.set)

    def show(self, *, is_offered: bool = True) -> None:
        """Let the buttons be used as the state permits, or hide both.

        Args:
            is_offered: whether there is something to search for.
        """
        is_visible = is_offered or self._is_running
        self._begin_button.visible = self._stop_button.visible = is_visible
        busy = "the search for grasps is running" if self._is_running else ""
        state = self._visitor.bench.state
        self._visitor.admit(self._begin_button, state, EditPart, otherwise=busy)
        self._visitor.allow(self._stop_button, "" if self._is_running else "nothing is under way")

    def _begin(self) -> None:
        with self._beginning:
            if self._is_running:
                return
            self._cancelled.clear()
            self._is_running = True
        self._changed()
        threading.Thread(target=self._work, name="searching", daemon=True).start()

    def _work(self) -> None:
        says: Sequence[str] = ()
        try:
            says = self._find(self._report, self._cancelled)
        except JobCancelled:
            says = ["Stopped: nothing was added."]
        except WorkbenchError as error:
            says = [self._visitor.words.render(error.message)]
        except Exception as error:
            # A rim: a library that cannot be filled stays as it is.
            log.exception("a search for grasps failed")
            self._visitor.notify("Internal error", f"{type(error).__name__}: {error}")
        self._is_running = False
        self._line.content = "".join(line(text, kind="hint") for text in says)
        self._changed()

    def _report(self, done: float, note: Message | str) -> None:
        progress = StatisticsText.PROGRESS(done=done, note=as_message(note))
        self._line.content = line(self._visitor.words.render(progress), kind="hint")
