"""What a grasp is besides its pose: name, fingers, ways in and out, tolerances, who may use it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import viser

from workbench.formats.parts.grasp_files import keys_of
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.views import no_grasp
from workbench.gui.shared.typed_lists import direction_in, shown_vector
from workbench.gui.shared.visitor import Visitor, whole
from workbench.gui.texts.grasps import GraspText
from workbench.model.errors import InputError
from workbench.model.messages.commands import GraspEditText
from workbench.model.part import Entry, Grasp
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.planning.grasps.grasp_frames import fitted_opening

AS_THE_CELL, ITS_OWN = "as the cell lifts", "its own way"
ANY = "any"


class GraspFields:
    """The fields of the chosen grasp; what is typed is not lost until it is applied or reverted.

    Concurrency: callbacks of viser and the renderer's thread; handles, and the entry as this
    browser has seen it, which an edit replaces.
    """

    def __init__(self, visitor: Visitor, editing: Editing):
        """Add the controls."""
        self._visitor, self._editing = visitor, editing
        self._seen: Entry | None = None
        gui = visitor.gui
        self._name = gui.add_text("Name", "")
        self._is_enabled = gui.add_checkbox("Enabled", True, hint="Whether it is tried at all.")
        self._priority = gui.add_number(
            "Priority", 0, step=1, hint="Higher ones are tried first, whatever their way."
        )
        self._arms = {
            arm.name: gui.add_checkbox(visitor.words.render(GraspText.BY_ARM(arm=arm.name)), True)
            for arm in visitor.cell.arms
        }
        tools = (ANY, *editing.tools)
        self._tool = gui.add_dropdown("For the tool", tools, hint="Arms with another one refuse.")
        tcps, hint = self._tcps(ANY), "Any: plans try each of the tool."
        self._tcp = gui.add_dropdown("For the TCP", tcps, hint=hint)
        self._opening = gui.add_number(
            "Opening [mm]", 0.0, step=0.1, hint="Between the fingers on arrival."
        )
        self._grip = gui.add_number(
            "Grip [mm]", 0.0, step=0.1, hint="Between the fingers when closed on the part."
        )
        self._approach = gui.add_vector3(
            "Approach along",
            (0.0, 0.0, 1.0),
            step=0.01,
            hint="Direction of travel, in the tool's frame.",
        )
        self._approach_length = gui.add_number("Approach [mm]", 60.0, step=1.0)
        self._way_out = gui.add_dropdown(
            "Retreat", (AS_THE_CELL, ITS_OWN), hint="Up and to the middle of the bin, or its own."
        )
        self._retreat = gui.add_vector3(
            "Retreat along",
            (0.0, 0.0, -1.0),
            step=0.01,
            hint="Direction of travel, in the tool's frame.",
        )
        self._retreat_length = gui.add_number("Retreat [mm]", 100.0, step=1.0)
        self._free = gui.add_number(
            "Free turn [deg]", 0.0, step=1.0, hint="About the tool's z, either way."
        )
        self._tilt = gui.add_number(
            "Tilt [deg]", 0.0, step=1.0, hint="About the axis in which fingers close, either way."
        )
        self._slide = gui.add_number(
            "Slide [mm]", 0.0, step=0.5, hint="Along the tool's x, either way."
        )
        gui.add_html('<div class="wb-buttons wb-three"></div>')
        self._apply = gui.add_button("Apply", icon=viser.Icon.CHECK)
        self._measure = gui.add_button(
            "Measure",
            icon=viser.Icon.RULER,
            color="gray",
            hint="Fills in opening and grip from the part between the fingers; Apply takes them.",
        )
        self._revert = gui.add_button("Revert", icon=viser.Icon.ARROW_BACK_UP, color="gray")
        self._apply.on_click(lambda _: self._take())
        self._measure.on_click(lambda _: self._fit())
        self._revert.on_click(lambda _: self._fill(self._seen))

    def show(self, entry: Entry | None, *, problem: str) -> None:
        """The chosen grasp is `entry` now; what was typed for it stays."""
        self._offer(self._tool.value, self._tcp.value)
        for button in (self._apply, self._measure, self._revert):
            self._visitor.allow(button, problem or no_grasp(entry))
        is_same_grasp = (
            entry is not None and self._seen is not None and entry.name == self._seen.name
        )
        if is_same_grasp and self.is_typed():
            return
        if entry is not self._seen:
            self._fill(entry)

    def _offer(self, tool: str, tcp: str) -> None:
        """The tools and TCPs there are, and those chosen, which may be none that this cell has."""
        tools = tuple(dict.fromkeys((ANY, *self._editing.tools, tool)))
        if self._tool.options != tools:
            self._tool.options = tools
        tcps = self._tcps(tcp)
        self._tcp.visible = len(tcps) > 1
        if self._tcp.options != tcps:
            self._tcp.options = tcps

    def _tcps(self, chosen: str) -> tuple[str, ...]:
        """The TCPs of all tools by name, after `ANY`, and the one chosen."""
        named = (tcp.name for tool in self._editing.tools.values() for tcp in tool.tcps)
        return tuple(dict.fromkeys((ANY, *named, chosen)))

    def on_typed(self, observer: Callable[[], None]) -> None:
        """Have something called after what stands in a field has changed."""
        fields = (
            *(self._name, self._is_enabled, self._priority, *self._arms.values()),
            *(self._tool, self._tcp, self._opening, self._grip),
            *(self._approach, self._approach_length, self._way_out),
            *(self._retreat, self._retreat_length, self._free, self._tilt, self._slide),
        )
        for field in fields:
            field.on_update(lambda _: observer())

    def is_typed(self) -> bool:
        """Whether something was typed that is not applied."""
        if self._seen is None:
            return False
        try:
            typed = self._typed_grasp(self._seen)
        except InputError:
            return True
        # The pose has controls of its own, which may have moved it meanwhile.
        return keys_of(with_grasp(self._seen, typed)) != keys_of(self._seen)

    def _fill(self, entry: Entry | None) -> None:
        self._seen = entry
        if entry is None:
            return
        grasp = grasp_of(entry)
        self._name.value = grasp.name
        self._is_enabled.value = grasp.is_enabled
        self._priority.value = grasp.priority
        for name, box in self._arms.items():
            box.value = not grasp.arms or name in grasp.arms
        self._offer(grasp.tool or ANY, grasp.tcp or ANY)
        self._tool.value = grasp.tool or ANY
        self._tcp.value = grasp.tcp or ANY
        self._opening.value, self._grip.value = _mm(grasp.opening), _mm(grasp.grip)
        self._approach.value = shown_vector(grasp.approach)
        self._approach_length.value = _mm(grasp.approach_length)
        self._way_out.value = AS_THE_CELL if grasp.retreat is None else ITS_OWN
        if grasp.retreat is not None:
            self._retreat.value = shown_vector(grasp.retreat)
        self._retreat_length.value = _mm(grasp.retreat_length)
        self._free.value, self._tilt.value = _deg(grasp.free_rotation), _deg(grasp.tilt)
        self._slide.value = _mm(grasp.slide)

    def _typed_grasp(self, entry: Entry) -> Grasp:
        """The grasp with what stands in the fields; its pose is not among them.

        Raises:
            InputError: a direction has no length, or no arm is left.
        """
        is_own = self._way_out.value == ITS_OWN
        return replace(
            grasp_of(entry),
            name=self._name.value.strip(),
            is_enabled=bool(self._is_enabled.value),
            priority=whole(self._priority.value),
            arms=self._typed_arms(grasp_of(entry).arms),
            tool="" if self._tool.value == ANY else self._tool.value,
            tcp="" if self._tcp.value == ANY else self._tcp.value,
            opening=self._opening.value / 1000,
            grip=self._grip.value / 1000,
            approach=direction_in(self._approach.value, "approach"),
            approach_length=self._approach_length.value / 1000,
            retreat=direction_in(self._retreat.value, "retreat") if is_own else None,
            retreat_length=self._retreat_length.value / 1000,
            free_rotation=float(np.deg2rad(self._free.value)),
            tilt=float(np.deg2rad(self._tilt.value)),
            slide=self._slide.value / 1000,
        )

    def _typed_arms(self, were: tuple[str, ...]) -> tuple[str, ...]:
        """The arms that may use the grasp; those of other cells have no box and stay."""
        elsewhere = [name for name in were if name not in self._arms]
        arms = (*(name for name, box in self._arms.items() if box.value), *elsewhere)
        if not arms:
            raise InputError("no arm may use it; disable the grasp instead")
        if set(arms) == set(were):
            return were
        return () if arms == tuple(self._arms) else arms

    def _take(self) -> None:
        entry = self._seen
        if entry is None:
            return
        try:
            grasp = self._typed_grasp(entry)
        except InputError as error:
            self._visitor.notify("Refused", str(error))
            return
        current = self._editing.entry
        if current is not None and current.name == entry.name and _differ_in_pose(current, entry):
            # This browser's own gizmo has moved it since the fields were filled.
            entry = current
            grasp = replace(grasp, T_part_tcp=grasp_of(current).T_part_tcp)
        if self._editing.put_grasp(entry, grasp, GraspEditText.EDITED(grasp=entry.name)):
            self._fill(self._editing.entry)

    def _fit(self) -> None:
        """Fill in opening and grip as the part is between the fingers."""
        entry = self._seen
        if entry is None:
            return
        T = grasp_of(entry).T_part_tcp
        fitted = self._editing.with_checker(lambda checker: fitted_opening(checker, T))
        if fitted is None:
            self._visitor.notify("Measure", "there is nothing between the fingers")
            return
        self._opening.value, self._grip.value = _mm(fitted.opening), _mm(fitted.grip)


def _differ_in_pose(entry: Entry, other: Entry) -> bool:
    """Whether two versions of an entry differ in where the hand is, and in nothing else."""
    T = grasp_of(other).T_part_tcp
    same = with_grasp(entry, replace(grasp_of(entry), T_part_tcp=T))
    return keys_of(same) == keys_of(other) and keys_of(entry) != keys_of(other)


def _mm(length: float) -> float:
    return round(length * 1000, 4) + 0.0


def _deg(angle: float) -> float:
    return round(float(np.rad2deg(angle)), 4) + 0.0
