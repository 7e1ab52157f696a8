"""Copies of the chosen grasp: duplicates, mirror images, and patterns that stay editable."""

from dataclasses import replace

import numpy as np
import viser

from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.views import no_grasp
from workbench.gui.shared.typed_lists import direction_in, numbers_in, shown_numbers, shown_vector
from workbench.gui.shared.visitor import Visitor
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.messages.commands import GraspEditText
from workbench.model.messages.message import Message
from workbench.model.part import Entry, GraspPattern, grasps_of
from workbench.model.part_edits import grasp_of, mirror_entry, with_grasp

PLANES = {"yz": (1.0, 0.0, 0.0), "xz": (0.0, 1.0, 0.0), "xy": (0.0, 0.0, 1.0)}
"""Planes of the part's frame, with their normals."""


class GraspCopies:
    """Duplicate, mirror, pattern, explode.

    Concurrency: callbacks of viser and the renderer's thread; handles, and the entry as this
    browser has seen it, which an edit replaces.
    """

    def __init__(self, visitor: Visitor, editing: Editing):
        """Add the controls."""
        self._visitor, self._editing = visitor, editing
        self._seen: Entry | None = None
        gui = visitor.gui
        self._plane = gui.add_dropdown(
            "Mirror across", tuple(PLANES), hint="A plane through the origin of the part."
        )
        self._mirror = gui.add_button("Mirror", icon=viser.Icon.FLIP_HORIZONTAL, color="gray")
        self._axis = gui.add_vector3("Axis", (0.0, 0.0, 1.0), step=0.01, hint="Of the pattern.")
        self._through = gui.add_vector3(
            "Through [mm]", (0.0, 0.0, 0.0), step=0.1, hint="A point on the axis."
        )
        self._angles = gui.add_text(
            "Around [deg]",
            "0",
            hint="Turns about the axis: 0, 72, 144 or 5 x 72 or 3 x 13 from -28.",
        )
        self._offsets = gui.add_text(
            "Along [mm]",
            "0",
            hint="Places along the axis: 0, 72, 144 or 5 x 72 or 3 x 13 from -28.",
        )
        self._across = gui.add_vector3(
            "Across", (1.0, 0.0, 0.0), step=0.01, hint="The second direction of a grid."
        )
        self._across_offsets = gui.add_text(
            "Across [mm]",
            "0",
            hint="Places along the second direction: 0, 72, 144 or 5 x 72 or 3 x 13 from -28.",
        )
        gui.add_html('<div class="wb-buttons wb-three"></div>')
        self._repeat = gui.add_button("Repeat", icon=viser.Icon.GRID_DOTS)
        self._explode = gui.add_button(
            "Explode", icon=viser.Icon.ARROWS_MAXIMIZE, color="gray", hint="Into single grasps."
        )
        self._single = gui.add_button(
            "Only one", icon=viser.Icon.POINT, color="gray", hint="Forget the pattern."
        )
        self._mirror.on_click(lambda _: self._mirror_grasp())
        self._repeat.on_click(lambda _: self._repeat_grasp())
        self._explode.on_click(lambda _: self._explode_pattern())
        self._single.on_click(lambda _: self._single_out())

    def show(self, entry: Entry | None, *, problem: str) -> None:
        """The chosen grasp is `entry` now."""
        problem, allow = problem or no_grasp(entry), self._visitor.allow
        for button in (self._mirror, self._repeat):
            allow(button, problem)
        single = "" if isinstance(entry, GraspPattern) else "it is a single grasp, no pattern"
        for button in (self._explode, self._single):
            allow(button, problem or single)
        if isinstance(entry, GraspPattern) and _pattern_of(entry) != _pattern_of(self._seen):
            self._fill(entry)
        self._seen = entry

    def _fill(self, pattern: GraspPattern) -> None:
        self._axis.value = shown_vector(pattern.axis)
        self._through.value = shown_vector(pattern.through * 1000)
        self._angles.value = shown_numbers(tuple(np.rad2deg(pattern.angles).tolist()))
        self._offsets.value = shown_numbers(tuple(d * 1000 for d in pattern.offsets))
        self._across.value = shown_vector(pattern.across)
        self._across_offsets.value = shown_numbers(tuple(d * 1000 for d in pattern.across_offsets))

    def duplicate(self) -> None:
        """Add a copy of the chosen grasp."""
        entry = self._editing.entry
        if entry is not None:
            self._add(entry, GraspEditText.DUPLICATED(grasp=entry.name))

    def _mirror_grasp(self) -> None:
        entry, plane = self._editing.entry, self._plane.value
        if entry is not None and plane in PLANES:
            copy = mirror_entry(entry, np.array(PLANES[plane]))
            self._add(copy, GraspEditText.MIRRORED(grasp=entry.name, plane=plane))

    def _add(self, entry: Entry, says: Message) -> None:
        grasp = replace(grasp_of(entry), name=self._editing.free_name(entry.name))
        self._editing.add((with_grasp(entry, grasp),), says)

    def _repeat_grasp(self) -> None:
        entry = self._seen
        if entry is None:
            return
        try:
            pattern = GraspPattern(
                grasp_of(entry),
                axis=direction_in(self._axis.value, "axis"),
                angles=tuple(np.deg2rad(numbers_in(self._angles.value, "around")).tolist()),
                offsets=tuple(d / 1000 for d in numbers_in(self._offsets.value, "along")),
                through=np.array(self._through.value) / 1000,
                across=direction_in(self._across.value, "across"),
                across_offsets=tuple(
                    d / 1000 for d in numbers_in(self._across_offsets.value, "across")
                ),
            )
        except InputError as error:
            self._visitor.notify("Refused", self._visitor.words.render(error.message))
            return
        self._editing.put(
            entry, pattern, GraspEditText.REPEATED(grasp=entry.name, count=pattern.count)
        )

    def _explode_pattern(self) -> None:
        entry = self._seen
        if isinstance(entry, GraspPattern):
            says = GraspEditText.SPLIT(grasp=entry.name, count=entry.count)
            self._editing.remove(entry, grasps_of(entry), says)

    def _single_out(self) -> None:
        entry = self._seen
        if isinstance(entry, GraspPattern):
            self._editing.put(entry, entry.grasp, GraspEditText.SINGLE(grasp=entry.name))


def _pattern_of(entry: Entry | None) -> str:
    """Changes when what the fields show does."""
    if not isinstance(entry, GraspPattern):
        return ""
    lists = (entry.angles, entry.offsets, entry.across_offsets)
    return digest_of((entry.name, entry.axis, entry.through, entry.across, lists))
