"""A CAD file that somebody chooses on their machine, with what it holds."""

import logging
from collections.abc import Callable
from threading import Thread
from typing import Any

import numpy as np
import viser

from workbench.app.core.state import State
from workbench.formats.cells.drawn_tools import CadDrawing
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import sent_name
from workbench.formats.meshes.cad_files import CAD_ENDINGS
from workbench.formats.meshes.cad_look import CadLook
from workbench.formats.parts.new_part import name_after
from workbench.gui.shared.views import line
from workbench.gui.shared.viser_server import element_id, taken_upload
from workbench.gui.shared.visitor import Visitor, hidden_css
from workbench.gui.texts.parts import UploadText
from workbench.gui.uploads.reading import cad_look
from workbench.gui.uploads.views import look_message, size_message
from workbench.model.errors import InputError, JobCancelled, WorkbenchError
from workbench.model.messages.message import Message

log = logging.getLogger(__name__)

AS_SAID = "as the file says"
WHOLE: str = "all, as one rigid part"
MOST_SOLIDS = 200
"""That may be chosen among on the page."""


class CadPick:
    """The button, the unit that the file may not say, and size, unit and volume once it is read.

    Where the file holds several solids, one of them may be chosen.

    Concurrency: callbacks of viser, and one thread for each look.  That waits for a process of its
    own and ends it when another file or unit was chosen meanwhile, or the browser has gone;
    `drawing`, `look` and `is_refused` are replaced as a whole.
    """

    def __init__(
        self,
        visitor: Visitor,
        label: str,
        changed: Callable[[], object],
        *,
        has_solids: bool = False,
    ):
        """Add the controls.

        Args:
            visitor: whose browser.
            label: of the button.
            changed: called when another file is there, and when it was read.
            has_solids: one of several solids may be chosen; otherwise all are taken.
        """
        self._visitor, self._changed = visitor, changed
        self.drawing: CadDrawing | None = None
        self.look: CadLook | None = None
        self.is_refused = False
        """Whether nothing can be made of the file, as it was read."""
        gui = visitor.gui
        self._pick = gui.add_upload_button(
            label, icon=viser.Icon.UPLOAD, color="gray", hint=", ".join(CAD_ENDINGS)
        )
        self._style = gui.add_html(hidden_css([]))
        self._line = gui.add_html(line("Nothing chosen yet.", kind="hint"))
        self._unit = gui.add_dropdown(
            "Unit", (AS_SAID, *UNITS), hint="STL, OBJ and PLY files do not say it."
        )
        self._solid = (
            gui.add_dropdown("Solid", (WHOLE,), hint="What the part is, of several in the file.")
            if has_solids
            else None
        )
        if self._solid is not None:
            self._solid.visible = False
            self._solid.on_update(lambda _: self._look())
        self._pick.on_upload(self._choose)
        self._unit.on_update(lambda _: self._look())
        visitor.on_end(self._forget)

    @property
    def unit(self) -> str:
        """What a person says; empty: as the file says."""
        return "" if self._unit.value == AS_SAID else self._unit.value

    @property
    def solid(self) -> str:
        """The solid that a person chose; empty: all of them."""
        value = WHOLE if self._solid is None else self._solid.value
        return "" if value == WHOLE else value

    @property
    def stem(self) -> str:
        """The name of the file as that of a thing: letters, digits and _."""
        return "" if self.drawing is None else name_after(self.drawing.file)

    def admit(self, state: State, command: type) -> None:
        """Let a file be chosen while the command that takes it is in order."""
        self._visitor.admit(self._pick, state, command)

    def show(self, *, visible: bool) -> None:
        """Show the controls, or hide them."""
        for control in (self._pick, self._line, self._unit):
            control.visible = visible
        # viser 1.1.1 shows a button for files whatever its `visible` says.
        self._style.content = hidden_css([] if visible else [element_id(self._pick)])

    def _forget(self) -> None:
        self.drawing = self.look = None

    def _choose(self, event: Any) -> None:
        name, content = taken_upload(event.target)
        self._forget()
        self._offer(())
        try:
            self.drawing = CadDrawing(sent_name(name), np.frombuffer(content, np.uint8), self.unit)
        except InputError as error:
            self._line.content = line(self._visitor.words.render(error.message), kind="bad")
            self._changed()
        self._look()

    def _offer(self, solids: tuple[str, ...]) -> None:
        """Let one of these be chosen, or all."""
        if self._solid is None:
            return
        self._solid.visible = bool(solids)
        offered = (WHOLE, *solids[:MOST_SOLIDS])
        if self._solid.options != offered:
            if self._solid.value not in offered:
                self._solid.value = WHOLE
            self._solid.options = offered

    def _look(self) -> None:
        """Have the file read; a page does not wait for that."""
        if self.drawing is None:
            return
        # Another object for each look: by it an answer that comes too late is told.
        self.drawing = CadDrawing(self.drawing.file, self.drawing.content, self.unit)
        self.look, self.is_refused = None, False
        size = size_message(self.drawing.file, self.drawing.content.size)
        reading = self._visitor.words.render(UploadText.READING(file=size))
        self._line.content = line(reading, kind="hint")
        self._changed()
        Thread(target=self._read, args=(self.drawing,), name="look-at-cad", daemon=True).start()

    def _read(self, drawing: CadDrawing) -> None:
        try:
            look = cad_look(
                drawing.file,
                drawing.content.data,
                drawing.unit,
                self.solid,
                cancelled=lambda: drawing is not self.drawing,
            )
            text: Message = UploadText.LOOK(file=drawing.file, facts=look_message(look))
            kind = "result"
        except JobCancelled:
            return
        except WorkbenchError as error:
            look, text, kind = None, error.message, "bad"
            self.is_refused = drawing is self.drawing
        except Exception:
            # A rim: what cannot be looked at can be tried all the same.
            log.exception("a CAD file could not be looked at")
            look, text, kind = None, UploadText.FAILED(file=drawing.file), "bad"
        if drawing is self.drawing:
            self.look = look
            if look is not None and self._solid is not None:
                self._offer(look.solids)
            self._line.content = line(self._visitor.words.render(text), kind=kind)
            self._changed()
