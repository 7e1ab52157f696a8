"""The parts of a film, in one browser alone, instead of what is really in the cell."""

from dataclasses import replace
from functools import partial
from typing import Any

import viser

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.robot import place
from workbench.gui.shared.colours import left_colour, part_colour, rgb_of
from workbench.gui.shared.look import FilmMoment, FilmPart, View
from workbench.gui.shared.solids import with_hard_edges
from workbench.gui.shared.visitor import Visitor
from workbench.model.cell import Cell

FILM = "/film"

REAL = (
    "/scan", "/parts", "/seen", "/placed", "/path", "/searched", "/rejected", "/candidate",
    "/grasps", "/meets",
)  # fmt: skip
"""Nodes that all browsers share and that a film has nothing to do with; and `/candidate_` arms."""


class FilmScene:
    """Moves the parts of a film; those that stay are coloured by why, at its end.

    What is really in the cell is not seen meanwhile: in viser a node of one browser takes the place
    of the shared node of that name, and what hangs below it follows.

    Concurrency: the renderer's thread; clicks come from others and change the own look alone.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is drawn yet."""
        self._visitor = visitor
        self._scene = visitor.client.scene
        self._drawn: FilmMoment | None = None
        self._hidden: tuple[str, ...] = ()
        self._nodes: dict[int, viser.FrameHandle] = {}
        self._meshes: dict[int, viser.MeshHandle] = {}
        self._shown: dict[int, tuple[FilmPart, bool]] = {}
        visitor.on_end(self._clear, in_scene=True)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is drawn from `old` to `new`."""
        filmed, showing = new.filmed, new.own.film
        if filmed is None or showing is None:
            self._clear()
            return
        is_other = old is None or old.own.film is None or old.own.film.film is not showing.film
        with self._visitor.client.atomic():
            if is_other or self._drawn is None:
                self._clear()
                arms = new.state.cell.arms
                self._hidden = (*REAL, *(f"/candidate_{arm.name}" for arm in arms))
                for name in self._hidden:
                    self._scene.add_frame(name, show_axes=False, visible=False)
                self._scene.add_frame(FILM, show_axes=False)
            self._draw(new.state.cell, filmed, showing.chosen)
        self._drawn = filmed

    def _draw(self, cell: Cell, filmed: FilmMoment, chosen: int | None) -> None:
        there = {part.number for part in filmed.parts}
        for number in set(self._nodes) - there:
            self._nodes.pop(number).remove()
            self._meshes.pop(number)
            self._shown.pop(number)
        for part in filmed.parts:
            if part.number not in self._nodes:
                self._add(cell, part)
            before, was_chosen = self._shown.get(part.number, (None, False))
            is_chosen = part.number == chosen
            if before is None or before.T_world_part is not part.T_world_part:
                place(self._nodes[part.number], part.T_world_part)
            if before is None or (before.kind, was_chosen) != (part.kind, is_chosen):
                self._colour_part(part, is_chosen)
            self._shown[part.number] = part, is_chosen

    def _add(self, cell: Cell, part: FilmPart) -> None:
        name = f"{FILM}/part-{part.number + 1}"
        self._nodes[part.number] = self._scene.add_frame(name, show_axes=False)
        points, triangles = with_hard_edges(triangles_of(cell.part(part.part).mesh))
        mesh = self._scene.add_mesh_simple(f"{name}/mesh", points, triangles)
        mesh.on_click(partial(self._on_pressed, part.number))
        self._meshes[part.number] = mesh

    def _colour_part(self, part: FilmPart, is_chosen: bool) -> None:
        """Colour a part, and say why it stays where that is reported."""
        colour = left_colour(part.kind) if part.kind else part_colour(part.number)
        self._meshes[part.number].color = rgb_of(colour)
        label = f"{FILM}/part-{part.number + 1}/label"
        self._scene.remove_by_name(label)
        if part.kind:
            number = part.number + 1
            words = f"part-{number}: {part.kind}" if is_chosen else f"{number}"
            self._scene.add_label(
                label,
                words,
                font_screen_scale=1.0 if is_chosen else 0.75,
                anchor="bottom-center",
                depth_test=False,
                position=(0.0, 0.0, 0.0),
            )

    def _on_pressed(self, number: int, _: Any) -> None:
        self._visitor.own.show(lambda showing: replace(showing, chosen=number))

    def _clear(self) -> None:
        if self._drawn is None:
            return
        for name in (FILM, *self._hidden):
            self._scene.remove_by_name(name)
        self._nodes, self._meshes, self._shown, self._drawn = {}, {}, {}, None
