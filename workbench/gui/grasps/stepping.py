"""All that the chosen grasp stands for, one grip after the other, with the hand at it."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.core.state import State
from workbench.gui.grasps.editing import Editing
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.model.cell import Tool
from workbench.model.digest import digest_of
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.part import TURN_MARK, Entry, Grasp, GraspPattern, Part, grasps_of
from workbench.model.part_edits import grasp_of
from workbench.planning.collision.legs import grips

NO_TURN, NO_SHIFT = np.deg2rad(0.05), 5e-5
"""[rad, m] Turns and shifts below this are shown as 0."""


def copies_of(part: Part, entry: Entry, tool: Tool) -> tuple[Grasp, ...]:
    """The grips that planning tries for an entry, each as a grasp with the hand there.

    They are those of a pattern, what the part's symmetry makes of each; and what each leaves free
    in the steps in which it is tried; named as in the table of candidates.
    """
    names = {grasp.name for grasp in grasps_of(entry)}
    return tuple(
        replace(grasp, T_part_tcp=grasp.T_part_tcp * T_tcp_grip)
        for grasp in part.grasps
        if grasp.name.split(TURN_MARK)[0] in names
        for T_tcp_grip in grips(tool, grasp)
    )


def way_to(copy: Grasp, entry: Entry, part: Part) -> Message:
    """How the hand comes from where an entry was put to a copy: by which turn, and how far along.

    As a screw: a turn about some axis and a shift along it.  The turn is counted about the
    pattern's axis, or else the first of the part's symmetry, from 0 to 360 degrees.
    """
    T_first_copy = copy.T_part_tcp * grasp_of(entry).T_part_tcp.inverse()
    turn = np.asarray(pin.log3(T_first_copy.rotation))
    angle, shift = float(np.linalg.norm(turn)), T_first_copy.translation
    if angle < NO_TURN:
        far = float(np.linalg.norm(shift))
        return GraspText.MOVED(distance=far) if far > NO_SHIFT else GraspText.UNMOVED()
    along = abs(float(turn @ shift)) / angle
    if angle < np.pi - NO_TURN and turn @ _axis(entry, part) < 0:
        angle = 2 * np.pi - angle
    if along > NO_SHIFT:
        return GraspText.TURNED_MOVED(angle=angle, distance=along)
    return GraspText.TURNED(angle=angle)


def _axis(entry: Entry, part: Part) -> Floats:
    """The axis (3,) about which turns are counted."""
    if isinstance(entry, GraspPattern):
        return entry.axis
    has_turns = any(axis.fold != 1 for axis in part.symmetry.axes)
    return part.symmetry.axis if has_turns else grasp_of(entry).T_part_tcp.rotation[:, 2]


def judgement_of(copy: Grasp, part: Part, state: State) -> Message | None:
    """What became of a grasp for the parts found, arm by arm; None where nothing was judged.

    What it leaves free is tried within one candidate, so the verdict is of all of that together.
    """
    found = state.detections or ()
    reasons = Counter(
        candidate.verdict.reason
        for candidate in state.candidates or ()
        if candidate.grasp.name == copy.name and found[candidate.detection].part == part.name
    )
    verdicts = [
        GraspText.VERDICTS(verdict=reason.message, count=count)
        for reason, count in reasons.most_common()
    ]
    return GraspText.IN_BIN(verdicts=verdicts) if verdicts else None


class CopySteps:
    """Steps through the copies of the chosen grasp.

    Concurrency: callbacks of viser and the renderer's thread; handles, and which copy is shown.
    """

    def __init__(
        self,
        visitor: Visitor,
        editing: Editing,
        step: Callable[[], None],
        is_alone: Callable[[], bool],
    ):
        """Add the controls.

        Args:
            visitor: whose browser.
            editing: what it has in hand.
            step: has the hand drawn anew, with the part alone.
            is_alone: whether the part is seen alone; otherwise keys do nothing.
        """
        self._editing, self._step = editing, step
        self._copies: Sequence[Grasp] = ()
        self._place: int | None = None
        self._of = ""
        gui, self._visitor = visitor.gui, visitor
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._back = gui.add_button(
            "Previous copy",
            color="gray",
            hint="All that the grasp stands for: of a pattern, of symmetry, and what is left free.",
        )
        self._forth = gui.add_button("Next copy", color="gray")
        self._line = gui.add_html("")
        self._back.on_click(lambda _: self._go(-1))
        self._forth.on_click(lambda _: self._go(1))
        visitor.on_key(
            "B", "Copy of the grasp before this one", lambda: is_alone() and self._go(-1)
        )
        visitor.on_key("C", "Next copy of the grasp", lambda: is_alone() and self._go(1))

    def show(self, state: State, part: Part, entry: Entry | None) -> Grasp | None:
        """The chosen grasp is `entry` now; the copy that is viewed, None: the grasp itself."""
        tool = self._editing.tool
        of = digest_of((part.digest, tool.name, "" if entry is None else entry.name))
        if of != self._of:
            self._of, self._place = of, None
            self._copies = () if entry is None else copies_of(part, entry, tool)
        count, place = len(self._copies), self._place
        self._back.visible = self._forth.visible = count > 1
        if entry is None or place is None:
            self._line.content = ""
            return None
        copy = self._copies[place]
        words, verdict = self._visitor.words, judgement_of(copy, part, state)
        text = GraspText.COPY(
            number=place + 1, count=count, name=copy.name, pose=way_to(copy, entry, part)
        )
        hint = "" if verdict is None else line(words.render(verdict), kind="hint")
        self._line.content = line(words.render(text), kind="result") + hint
        return copy

    def _go(self, step: int) -> None:
        """To the next copy, or the one before; the first press shows the first, or the last."""
        count = len(self._copies)
        if count > 1:
            place = -1 if self._place is None and step > 0 else self._place or 0
            self._place = (place + step) % count
            self._step()
