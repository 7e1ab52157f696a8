"""A new part from a CAD file that somebody has on their machine."""

import viser

from workbench.app.core.cell.making import ImportPart
from workbench.app.core.command import Command
from workbench.app.core.state import State
from workbench.app.picking.part_import import PARTS
from workbench.formats.parts.new_part import PLASTIC, free_name
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.parts import UploadText
from workbench.gui.uploads.cad_pick import CadPick
from workbench.model.errors import InputError
from workbench.model.messages.refusals import ChangeRefusal


class PartUpload:
    """The file, what it does not say, and the button that makes a part of it.

    Concurrency: callbacks of viser and the renderer's thread; handles only.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self.asked = ""
        """Name of the part that this browser has asked for last."""
        self._proposed = ""
        """Name after the file that was chosen last; a person may have typed another one."""
        gui = visitor.gui
        self._pick = CadPick(visitor, "Choose a CAD file", self._on_chosen, has_solids=True)
        self._mass = gui.add_html("")
        self._name = gui.add_text("Name", "", hint="Letters, digits, - and _.")
        self._density = gui.add_number(
            "Density [g/cm³]", PLASTIC / 1000, min=0.01, max=25.0, step=0.01, hint="For its mass."
        )
        self._is_mended = gui.add_checkbox(
            "Repair mesh", False, hint="Close holes, turn facets, join what lies apart."
        )
        self._is_symmetric = gui.add_checkbox(
            "Take its symmetry",
            True,
            hint="Turns that change nothing multiply grasps.",
        )
        self._make = gui.add_button("Make the part", icon=viser.Icon.CUBE_PLUS)
        self._density.on_update(lambda _: self._show_mass())
        self._name.on_update(lambda _: self.show(self._visitor.bench.state))
        visitor.on_press(self._make, self._make_command)

    def show(self, state: State) -> None:
        """Let it be used while a part can be made."""
        missing, name = "", self._name.value.strip()
        if self._pick.drawing is None:
            missing = "choose a file first"
        elif self._pick.is_refused:
            missing = "choose another file: nothing can be made of this one"
        elif name in {part.name for part in state.cell.parts}:
            missing = self._visitor.words.render(ChangeRefusal.PART_EXISTS(part=name))
        self._visitor.admit(self._make, state, ImportPart, otherwise=missing)
        self._pick.admit(state, ImportPart)

    def _on_chosen(self) -> None:
        if self._pick.drawing is not None and self._name.value in ("", self._proposed):
            self._proposed = free_name(PARTS, self._pick.stem)
            self._name.value = self._proposed
        self._show_mass()
        self.show(self._visitor.bench.state)

    def _show_mass(self) -> None:
        look = self._pick.look
        if look is None or not look.surface.volume:
            self._mass.content = ""
            return
        mass = look.surface.volume * self._density.value * 1e6
        self._mass.content = line(self._visitor.words.render(UploadText.MASS(mass=f"{mass:.4g}")))

    def _make_command(self) -> Command:
        drawing = self._pick.drawing
        if drawing is None:
            raise InputError("choose a CAD file first")
        self.asked = self._name.value.strip()
        return ImportPart(
            self.asked,
            drawing.file,
            drawing.content,
            drawing.unit,
            self._density.value * 1000,
            bool(self._is_mended.value),
            bool(self._is_symmetric.value),
            self._pick.solid,
        )
