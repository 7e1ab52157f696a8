"""Whether the scanner still hangs where it was calibrated: what the recorded sessions say."""

import logging
import threading
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import viser

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.command import Command
from workbench.app.core.state import State
from workbench.app.records.session_archive import sessions_in
from workbench.app.runtime.bench import Bench
from workbench.gui.help.groups import group
from workbench.gui.shared.colours import JOINTS
from workbench.gui.shared.look import View
from workbench.gui.shared.plots import Curve, Plot, legend_html, plot_html
from workbench.gui.shared.views import line, sentence
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.calibration import CalibrationText
from workbench.model.cell import Cell
from workbench.model.errors import InputError, JobCancelled, WorkbenchError
from workbench.model.geometry import Floats, Ints
from workbench.model.messages.commands import EditText
from workbench.model.messages.message import Message
from workbench.words.words import IN_ENGLISH, Words

log = logging.getLogger(__name__)

LOOK = "Look at recorded scans"

NOTHING = "Look at the recorded scans first."

NAME_MISSING = "type your name: it is kept with the calibration"


class DriftGroup:
    """A look at the sessions beside this one, what it brought, and its use.

    Concurrency: callbacks of viser, the renderer's thread, and a thread for each look, which waits
    for a process of its own.
    """

    def __init__(self, visitor: Visitor, name: Callable[[], str]):
        """Add the controls; `name` returns the name of the person, empty while none is typed."""
        self._visitor, self._name = visitor, name
        self._found: tuple[str, Callable[[float, str], Cell]] | None = None
        self._given_up: threading.Event | None = None
        self._beginning = threading.Lock()
        gui = visitor.gui
        with group(gui, "4 · Drift", expand_by_default=False):
            self._says = gui.add_html("")
            gui.add_html('<div class="wb-buttons wb-two"></div>')
            self._look = gui.add_button(LOOK, icon=viser.Icon.HISTORY, color="gray")
            self._look.visible = not visitor.is_recorded
            self._take = gui.add_button("Move the scanner", icon=viser.Icon.CHECK)
            self._cancel = gui.add_button("Cancel the look", icon=viser.Icon.X, color="gray")
            self._cancel.visible = False
        self._look.on_click(lambda _: self._began())
        self._cancel.on_click(lambda _: self._gave_up())
        visitor.on_press(self._take, self._take_drift)
        visitor.on_end(self._gave_up)

    def show(self, new: View) -> None:
        """Let be used what can be used of a cell as it is now."""
        self._admit(new.state)

    def _admit(self, state: State) -> None:
        is_of_it = self._found is not None and self._found[0] == state.cell.digest
        missing = NOTHING
        if is_of_it:
            missing = "" if self._name() else NAME_MISSING
        self._visitor.admit(self._take, state, ChangeCell, otherwise=missing)

    def _began(self) -> None:
        with self._beginning:
            if self._given_up is not None or not isinstance(self._visitor.bench, Bench):
                return
            given_up = self._given_up = threading.Event()
        threading.Thread(
            target=self._look_for_drift, args=(given_up,), name="drift", daemon=True
        ).start()

    def _gave_up(self) -> None:
        given_up = self._given_up
        if given_up is not None:
            given_up.set()

    def _look_for_drift(self, given_up: threading.Event) -> None:
        """Look through the sessions; that takes some seconds for each week."""
        bench = self._visitor.bench
        if not isinstance(bench, Bench):
            return
        self._look.disabled, self._look.label = True, "Reading …"
        self._take.visible, self._cancel.visible = False, True
        try:
            self._found = self._read_change(bench, given_up)
        except JobCancelled:
            self._says.content = line("The look was cancelled.", kind="hint")
        except WorkbenchError as error:
            self._visitor.notify("Check failed", self._visitor.words.render(error.message))
        except Exception:
            log.exception("recorded scans could not be looked at")
            self._visitor.notify("Check failed", "Internal error, see the log.")
        finally:
            self._given_up = None
            self._take.visible, self._cancel.visible = True, False
            self._look.disabled, self._look.label = False, LOOK
            self._admit(bench.state)

    def _read_change(
        self, bench: Bench, given_up: threading.Event
    ) -> tuple[str, Callable[[float, str], Cell]] | None:
        # Open3D takes a second to load: the page does not wait for it.
        from workbench.app.calibration.drift_words import drift_words
        from workbench.app.review.drift_process import drift_apart
        from workbench.app.review.scanner_drift import refined_cell

        cell = bench.state.cell
        found = drift_apart(sessions_in(bench.folder.parent), cell, self._report, given_up)
        words = self._visitor.words
        sessions = CalibrationText.SESSIONS(scans=found.scans, sessions=found.sessions)
        said = [
            line(words.render(sessions)),
            *(line(f"{sentence(words.render(word))}.") for word in drift_words(cell, found.drift)),
            *(
                course_html(course.thing, course.days, course.moved, words)
                for course in found.drift.courses
            ),
            *(line(words.render(problem), kind="bad") for problem in found.problems),
        ]
        self._says.content = "".join(said)
        if found.drift.moved is None:
            return None
        return cell.digest, partial(refined_cell, cell, found.drift)

    def _report(self, done: float, note: Message | str) -> None:
        self._look.label = self._visitor.words.render(CalibrationText.READING(done=done))

    def _take_drift(self) -> Command:
        cell = self._visitor.bench.state.cell
        if self._found is None or self._found[0] != cell.digest:
            raise InputError(NOTHING)
        if not (by := self._name()):
            raise InputError(NAME_MISSING)
        says = EditText.SCANNER_MOVED(by=by)
        return ChangeCell(self._found[1](time.time(), by), says, was=cell.digest)


def course_html(thing: str, days: Ints, moved: Floats, words: Words = IN_ENGLISH) -> str:
    """By how much a thing says that the scanner is moved, day after day.

    Args:
        thing: its name.
        days: (n,) since the epoch.
        moved: (n, 6) [m, rad], NaN where a day does not tell.
        words: of who reads it.
    """
    if len(days) < 2:
        return ""
    along, plots = (days - days[0]).astype(float), list[str]()
    shift, turn = (
        text(thing=thing) for text in (CalibrationText.SHIFT_BY, CalibrationText.TURN_BY)
    )
    units = (
        (words.render(shift), "mm", 0, 1e3),
        (words.render(turn), "deg", 3, 180 / np.pi),
    )
    for title, unit, first, scale in units:
        curves = tuple(
            Curve(name, JOINTS[axis], moved[:, first + axis] * scale)
            for axis, name in enumerate("xyz")
            if np.isfinite(moved[:, first + axis]).any()
        )
        if curves:
            plot = Plot(title, unit, along, curves, -0.1, 0.1, along="days")
            plots.append(plot_html(plot, float(along[-1])) + legend_html(plot))
    return "".join(plots)
