"""What the program proposes for a part: its symmetry, and grasps to take or leave."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import viser

from workbench.app.core.cell.part_edits import EditPart
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.views import (
    MOST_SUGGESTIONS,
    refused_message,
    suggestions_html,
    symmetry_line,
)
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.model.digest import digest_of
from workbench.model.errors import WorkbenchError
from workbench.model.geometry import Mesh
from workbench.model.messages.commands import GraspEditText
from workbench.model.part import Grasp, Part
from workbench.model.part_edits import free_name, names_in
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.coverage import rank_for_bin
from workbench.planning.grasps.grasp_check import GraspCheck
from workbench.planning.grasps.grasp_suggestions import Suggestion, suggest
from workbench.planning.grasps.part_symmetry import proposed_symmetry
from workbench.planning.kinematics.quickness import tool_acceleration

RANKED_OF_EACH, FEWEST_RANKED = 3, 24
"""Times as many grasps as are listed, and at least these, are tried against the bin."""

IN_THE_BIN = (
    "In the bin: the share of the ways to lie in which hand and arm can take the part, alone there."
)


class SymmetryControls:
    """What symmetry is said, what the mesh looks like, and a person's word.

    Concurrency: callbacks of viser and the renderer's thread; handles only.
    """

    def __init__(self, visitor: Visitor, editing: Editing):
        """Add the controls."""
        self._visitor, self._editing = visitor, editing
        self._looked: tuple[Mesh, Symmetry | None] | None = None
        gui = visitor.gui
        self._line = gui.add_html("")
        gui.add_html('<div class="wb-buttons wb-three"></div>')
        self._look = gui.add_button(
            "Detect", icon=viser.Icon.EYE, color="gray", hint="What symmetry the mesh has."
        )
        self._take = gui.add_button(
            "Confirm",
            icon=viser.Icon.CHECK,
            hint="Grasps are multiplied by it, and parts found anew.",
        )
        self._none = gui.add_button("None", icon=viser.Icon.X, color="gray")
        self._look.on_click(lambda _: self._look_at_mesh())
        self._take.on_click(lambda _: self._confirm())

        @self._none.on_click
        def _(_: Any) -> None:
            editing.set_symmetry(Symmetry())

    def show(self, part: Part, *, problem: str) -> None:
        """The part is this one now."""
        proposed = self._propose(part)
        self._line.content = symmetry_line(part.symmetry, proposed, self._visitor.words)
        allow, said = self._visitor.allow, ""
        if proposed is None:
            said = "press Detect first"
        elif digest_of(proposed) == digest_of(part.symmetry):
            said = "that is its symmetry already"
        allow(self._take, problem or said)
        allow(self._none, problem or ("it has none" if part.symmetry.is_none else ""))

    def _propose(self, part: Part) -> Symmetry | None:
        if self._looked is None or self._looked[0] is not part.mesh:
            return None
        return self._looked[1]

    def _look_at_mesh(self) -> None:
        part = self._editing.part
        found = proposed_symmetry(part.mesh)
        self._looked = part.mesh, Symmetry() if found is None else found.symmetry
        self._editing.notify()

    def _confirm(self) -> None:
        proposed = self._propose(self._editing.part)
        if proposed is not None:
            self._editing.set_symmetry(proposed)


class Suggestions:
    """Grasps that the program would put on the part, the best first.

    Concurrency: callbacks of viser; handles, and what was suggested last.
    """

    def __init__(self, visitor: Visitor, editing: Editing, preview: Callable[[Grasp], None]):
        """Add the controls; `preview` shows a grasp that is not in the library."""
        self._visitor, self._editing, self._preview = visitor, editing, preview
        self._found: tuple[Suggestion, ...] = ()
        self._shares: Mapping[str, float] = {}
        self._about: tuple[Mesh, str] | None = None
        self._chosen = 0
        self._left_out = ""
        gui = visitor.gui
        self._most = gui.add_slider(
            "How many",
            1,
            MOST_SUGGESTIONS,
            1,
            8,
            hint="Those are listed that take the part in most of its ways to lie in the bin.",
        )
        self._seed = gui.add_number("Seed", 0, min=0, step=1, hint="Of what is sampled.")
        gui.add_html('<div class="wb-buttons wb-three"></div>')
        self._suggest = gui.add_button("Suggest", icon=viser.Icon.BULB)
        self._take = gui.add_button("Take", icon=viser.Icon.PLUS, disabled=True)
        self._all = gui.add_button("Take all", color="gray", disabled=True)
        self._table = gui.add_html("")
        self._rows = visitor.rows(MOST_SUGGESTIONS, self._choose)
        self._suggest.on_click(lambda _: self._look())
        self._take.on_click(lambda _: self._add(self._found[self._chosen : self._chosen + 1]))
        self._all.on_click(lambda _: self._add(self._found))

    def show(self, part: Part) -> None:
        """The part is this one now; what was suggested for another part or tool is gone."""
        about = self._about
        tool = self._editing.tool.name
        if about is not None and not (about[0] is part.mesh and about[1] == tool):
            self._about, self._found = None, ()
            self._table.content = ""
        self._admit()

    def _admit(self) -> None:
        missing = "" if self._found else "press Suggest first"
        for button in (self._take, self._all):
            self._visitor.admit(button, self._visitor.bench.state, EditPart, otherwise=missing)

    def _look(self) -> None:
        self._table.content = line("Looking …", kind="hint")
        part, tool = self._editing.part, self._editing.tool
        refused: list[GraspCheck] = []
        try:
            seed, most, cell = int(self._seed.value), int(self._most.value), self._visitor.cell
            found = suggest(
                part,
                tool,
                most=max(FEWEST_RANKED, RANKED_OF_EACH * most),
                seed=seed,
                acceleration=tool_acceleration(cell, tool),
                refused=refused.append,
            )
            ranked = rank_for_bin(cell, part, tool, found)[:most]
        except (WorkbenchError, ValueError) as error:
            why = error.message if isinstance(error, WorkbenchError) else str(error)
            self._table.content = line(self._visitor.words.render(why), kind="bad")
            return
        self._about = part.mesh, tool.name
        self._left_out = ""
        if refused:
            left_out = self._visitor.words.render(refused_message(refused))
            self._left_out = line(left_out, kind="hint")
        self._shares = {suggestion.grasp.name: share for suggestion, share in ranked}
        self._show(tuple(suggestion for suggestion, _ in ranked), 0)

    def _show(self, found: tuple[Suggestion, ...], chosen: int) -> None:
        self._found, self._chosen = found, chosen
        self._admit()
        if not found:
            nothing = GraspText.NOTHING_NEW(tool=self._editing.tool.name)
            hint = line(self._visitor.words.render(nothing), kind="hint")
            self._table.content = hint + self._left_out
            return
        self._table.content = (
            suggestions_html(found, chosen, self._rows, self._shares)
            + line(IN_THE_BIN, kind="hint")
            + self._left_out
        )
        self._preview(found[chosen].grasp)

    def _choose(self, number: int) -> None:
        if number < len(self._found):
            self._show(self._found, number)

    def _add(self, wanted: tuple[Suggestion, ...]) -> None:
        """Add suggestions to the library, under names that are free now."""
        if not wanted:
            return
        taken, grasps = set(names_in(self._editing.part.library.entries)), list[Grasp]()
        for suggestion in wanted:
            grasps.append(replace(suggestion.grasp, name=free_name(taken, suggestion.grasp.name)))
            taken.add(grasps[-1].name)
        says = (
            GraspEditText.SUGGESTED(count=len(grasps))
            if len(grasps) > 1
            else GraspEditText.ADDED(grasp=grasps[0].name)
        )
        if self._editing.add(grasps, says):
            left = tuple(suggestion for suggestion in self._found if suggestion not in wanted)
            if left:
                self._show(left, min(self._chosen, len(left) - 1))
            else:
                # That nothing more would be found nobody has looked for.
                self._found, self._table.content = (), ""
                self._admit()
