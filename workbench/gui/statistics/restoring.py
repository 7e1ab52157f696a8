"""Restores a backup from the page: shows what changes, asks for confirmation, and records it."""

import logging
import threading
import time
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import viser

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.state import State
from workbench.app.records.restoring import BACKUPS, Thing, look_apart, restore_and_log
from workbench.formats.files.whole_files import sent_name, write_upload
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.viser_server import taken_upload
from workbench.gui.shared.visitor import Visitor
from workbench.gui.statistics.views import changes_any, not_restored, things_html
from workbench.gui.texts.statistics import StatisticsText
from workbench.model.errors import CommandRefused, InputError, JobCancelled, WorkbenchError
from workbench.model.messages.message import Message

log = logging.getLogger(__name__)

NONE: str = "-"

LISTED_EVERY = 2.0
"""[s] Between two looks at the backups that are kept here."""


@dataclass(frozen=True, slots=True, eq=False)
class Chosen:
    """A backup by its name, and how it is had as a file for a while."""

    name: str
    opened: Callable[[], AbstractContextManager[Path]]


class RestoreControls:
    """A backup from somebody's machine, or one that is kept here; a table, and a button.

    Concurrency: callbacks of viser, the renderer's thread, and a thread for each look and each
    restoring; what was viewed is replaced as a whole.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._chosen: Chosen | None = None
        self._wanted_look: Chosen | None = None
        self._things: tuple[Thing, ...] = ()
        self._view: View | None = None
        self._listed_at = -LISTED_EVERY
        gui = visitor.gui
        self._pick = gui.add_upload_button(
            "Choose a backup", icon=viser.Icon.UPLOAD, color="gray", hint="A zip file, up to 50 MB."
        )
        self._kept = gui.add_dropdown(
            "Or one kept here", (NONE,), hint="What was there before something was restored."
        )
        self._told = gui.add_html(line("Nothing chosen yet.", kind="hint"))
        self._restore = gui.add_button(
            "Restore it",
            icon=viser.Icon.HISTORY,
            hint="What is there now is kept as a backup first.",
        )
        self._pick.on_upload(self._upload)
        self._kept.on_update(self._on_take)
        self._restore.on_click(lambda _: self._on_wanted())
        visitor.on_end(self._forget)

    def show(self, view: View) -> None:
        """Let it be used while nothing speaks against it."""
        self._view = view
        problem = self._problem(view.state)
        self._visitor.allow(self._pick, self._visitor.lacks(view.state, ChangeCell))
        self._visitor.allow(self._restore, problem or self._missing())
        # A view comes up to 30 times a second while the robot moves; a folder may be slow.
        if time.monotonic() - self._listed_at < LISTED_EVERY:
            return
        self._listed_at = time.monotonic()
        names = (NONE, *sorted((file.name for file in BACKUPS.glob("*.zip")), reverse=True))
        if self._kept.options != names:
            self._kept.options = names

    def _problem(self, state: State) -> str:
        live = self._view.live.robot if self._view is not None else None
        return self._visitor.obstacle(state, ChangeCell) or not_restored(state, live)

    def _missing(self) -> str:
        if self._chosen is None:
            return "choose a backup first"
        return "" if changes_any(self._things) else "it would change nothing"

    def _upload(self, event: Any) -> None:
        name, content = taken_upload(event.target)
        try:
            sent_name(name)
        except InputError as error:
            self._told.content = line(self._visitor.words.render(error.message), kind="bad")
            return
        self._look(Chosen(name, lambda: write_upload(name, content)))

    def _on_take(self, event: Any) -> None:
        if event.client is not None and event.target.value != NONE:
            name = event.target.value
            self._look(Chosen(name, lambda: nullcontext(BACKUPS / name)))

    def _forget(self) -> None:
        self._chosen, self._wanted_look, self._things = None, None, ()

    def _look(self, chosen: Chosen) -> None:
        self._forget()
        self._wanted_look = chosen
        self._told.content = self._line(StatisticsText.READING(name=chosen.name))
        self._begin(lambda: self._show_content(chosen))

    def _show_content(self, chosen: Chosen) -> None:
        with chosen.opened() as file:
            things = look_apart(file, Path.cwd(), cancelled=lambda: self._wanted_look is not chosen)
        if self._wanted_look is not chosen:
            return
        self._chosen, self._things = chosen, things
        self._told.content = things_html(chosen.name, things, self._visitor.words)

    def _on_wanted(self) -> None:
        chosen = self._chosen
        if chosen is not None and self._visitor.attempt(self._check):
            self._told.content = self._line(StatisticsText.RESTORING(name=chosen.name))
            self._begin(lambda: self._on_restored(chosen))

    def _check(self) -> None:
        # A button that is disabled is only a courtesy.
        if problem := self._problem(self._visitor.bench.state):
            raise CommandRefused(problem)

    def _on_restored(self, chosen: Chosen) -> None:
        by = self._visitor.person.name
        before = restore_and_log(chosen.opened, chosen.name, by, self._check)
        self._chosen, self._things = None, ()
        restored = StatisticsText.RESTORED(name=chosen.name, before=before.name)
        self._told.content = line(self._visitor.words.render(restored))

    def _line(self, text: Message) -> str:
        return line(self._visitor.words.render(text), kind="hint")

    def _begin(self, work: Callable[[], None]) -> None:
        """Have something done in a thread of its own; what goes wrong is reported in its place."""

        def work_and_report() -> None:
            try:
                work()
            except JobCancelled:
                return
            except WorkbenchError as error:
                self._told.content = line(self._visitor.words.render(error.message), kind="bad")
            except Exception:
                log.exception("a backup could not be used")
                self._told.content = line("Internal error, see the log.", kind="bad")
            if self._view is not None:
                self._listed_at = -LISTED_EVERY
                self.show(self._view)

        threading.Thread(target=work_and_report, name="restore", daemon=True).start()
