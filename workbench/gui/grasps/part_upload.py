"""A new part from a CAD file that somebody has on their machine."""

import math
from pathlib import PurePosixPath
from typing import Any

import numpy as np
import viser

from workbench.app.core.commands import Command, ImportPart
from workbench.app.core.state import State
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import MB
from workbench.formats.meshes.cad_files import KINDS
from workbench.formats.parts.new_part import PLASTIC
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.model.errors import InputError

AS_SAID = "as the file says"


class PartUpload:
    """The file, what it does not say, and the button that makes a part of it.

    Concurrency: callbacks of viser and the renderer's thread; `_file` is replaced as a whole.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._file: tuple[str, bytes] | None = None
        self.asked = ""
        """Name of the part that this browser has asked for last."""
        gui = visitor.gui
        self._pick = gui.add_upload_button(
            "Choose a CAD file", icon=viser.Icon.UPLOAD, color="gray", hint=", ".join(KINDS)
        )
        self._line = gui.add_html(line("Nothing chosen yet.", kind="hint"))
        self._name = gui.add_text("Name", "", hint="Letters, digits, - and _.")
        self._unit = gui.add_dropdown(
            "Unit", (AS_SAID, *UNITS), hint="STL, OBJ and PLY files do not say it."
        )
        self._density = gui.add_number(
            "Density [g/cm³]", PLASTIC / 1000, min=0.01, max=25.0, step=0.01, hint="For its mass."
        )
        self._is_mended = gui.add_checkbox(
            "Mend it", False, hint="Close holes, turn facets, join what lies apart."
        )
        self._is_symmetric = gui.add_checkbox(
            "Take its symmetry",
            True,
            hint="Turns that change nothing multiply grasps.",
        )
        self._make = gui.add_button("Make the part", icon=viser.Icon.CUBE_PLUS)
        self._pick.on_upload(self._chosen)
        visitor.on_press(self._make, self._wanted)

    def show(self, state: State) -> None:
        """Let it be used while a part can be made."""
        missing = "choose a file first" if self._file is None else ""
        self._visitor.admit(self._make, state, ImportPart, otherwise=missing)
        self._visitor.admit(self._pick, state, ImportPart)

    def _chosen(self, event: Any) -> None:
        file = event.target.value
        name = PurePosixPath(file.name.replace("\\", "/")).name
        self._file = (name, file.content)
        # A small file is no "0.00 MB".
        size = len(file.content)
        told = f"{size / MB:.1f} MB" if size >= MB else f"{math.ceil(size / 1000)} kB"
        self._line.content = line(f"{name}, {told}")
        if not self._name.value:
            stem = PurePosixPath(name).stem
            self._name.value = "".join(c if c.isalnum() and c.isascii() else "_" for c in stem)[:60]
        self.show(self._visitor.bench.state)

    def _wanted(self) -> Command:
        if self._file is None:
            raise InputError("choose a CAD file first")
        file, content = self._file
        self.asked = self._name.value.strip()
        return ImportPart(
            self.asked,
            file,
            np.frombuffer(content, np.uint8),
            "" if self._unit.value == AS_SAID else self._unit.value,
            self._density.value * 1000,
            bool(self._is_mended.value),
            bool(self._is_symmetric.value),
        )
