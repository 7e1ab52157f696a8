"""However the part lies in the bin: where no grasp works, drawn around it, and what to add."""

import logging
import threading

import numpy as np
import viser

from workbench.gui.grasps.editing import Editing
from workbench.gui.scene.stage import GraspStage
from workbench.gui.shared.colours import BAD, BUSY, GOOD, rgb_of
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.grasps import GraspText
from workbench.gui.texts.statistics import StatisticsText
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import WorkbenchError
from workbench.model.geometry import Floats
from workbench.model.messages.commands import GraspEditText
from workbench.model.messages.message import Message, as_message, plain
from workbench.model.part import Part
from workbench.planning.grasps.coverage import Coverage, coverage

log = logging.getLogger(__name__)

CHECK = "Check coverage"


class CoverageControls:
    """Looks how the part can lie, in a thread of its own, and shows what came of it.

    Concurrency: callbacks of viser and the renderer's thread; one thread looks at a time.
    """

    def __init__(self, visitor: Visitor, editing: Editing, stage: GraspStage):
        """Add the controls."""
        self._visitor, self._editing, self._stage = visitor, editing, stage
        self._found: tuple[str, Coverage] | None = None
        self._cancelled = threading.Event()
        self._is_looking = False
        gui = visitor.gui
        self._line = gui.add_html("")
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._look = gui.add_button(
            CHECK,
            icon=viser.Icon.SPHERE,
            hint="Every grasp, however the part lies in the bin: tool against bin, reach of the "
            "arms. No paths are planned, and other parts are left out.",
        )
        self._add = gui.add_button("Add what helps", icon=viser.Icon.PLUS, disabled=True)
        self._look.on_click(lambda _: self._press())
        self._add.on_click(lambda _: self._add_missing())
        visitor.on_end(self._cancelled.set)

    def show(self, part: Part, *, problem: str) -> None:
        """The part is this one now; what was found for other grasps of it is gone."""
        found = self._found
        if found is not None and found[0] != _key(part, self._visitor.cell):
            self._found = found = None
            self._stage.hide_sphere()
        missing = found[1].missing if found is not None else None
        if found is None:
            problem = problem or "press Check coverage first"
        elif missing is None or missing.suggestion is None:
            problem = problem or "no grasp was found that would help"
        self._visitor.allow(self._add, problem)
        if self._is_looking:
            return
        if found is None:
            self._line.content = line("Not checked since the grasps were changed.", kind="hint")
            return
        self._line.content = "".join(
            line(self._visitor.words.render(text)) for text in coverage_texts(found[1])
        )
        if self._stage.is_open:
            self._stage.show_sphere(found[1].directions, sphere_colours(found[1]))

    def _press(self) -> None:
        """Begin to look, or stop looking."""
        if self._is_looking:
            self._cancelled.set()
            return
        self._cancelled.clear()
        self._is_looking, self._look.label = True, "Cancel"
        threading.Thread(target=self._work, name="coverage", daemon=True).start()

    def _work(self) -> None:
        part, cell = self._editing.part, self._visitor.cell  # as they are when it begins
        try:
            found = coverage(cell, part, report=self._report, cancelled=self._cancelled.is_set)
            if not self._cancelled.is_set():
                self._found = _key(part, cell), found
        except WorkbenchError as error:
            self._visitor.notify("Coverage", self._visitor.words.render(error.message))
        except Exception as error:
            # A rim: what cannot be looked at leaves the page as it is.
            log.exception("the coverage of a part could not be found")
            self._visitor.notify("Internal error", f"{type(error).__name__}: {error}")
        self._is_looking, self._look.label = False, CHECK
        self._editing.notify()

    def _report(self, done: float, note: Message | str) -> None:
        progress = StatisticsText.PROGRESS(done=done, note=as_message(note))
        self._line.content = line(self._visitor.words.render(progress), kind="hint")

    def _add_missing(self) -> None:
        missing = self._found[1].missing if self._found is not None else None
        if missing is not None and missing.suggestion is not None:
            grasp = missing.suggestion.grasp
            self._editing.add((grasp,), GraspEditText.ADDED_FOR_COVERAGE(grasp=grasp.name))


def _key(part: Part, cell: Cell) -> str:
    """What a coverage is about."""
    return digest_of((part.digest, cell.digest))


def coverage_texts(found: Coverage) -> list[Message | str]:
    """How the part can lie so that a grasp works, and where none does."""
    arms = [
        GraspText.ARM_SHARE(arm=arm, share=float(share))
        for arm, share in zip(found.arms, found.arm_shares.mean(axis=0), strict=True)
    ]
    covered = GraspText.COVERED(share=found.share, poses=found.poses, arms=arms)
    missing = found.missing
    if missing is None:
        return [covered, "There is no way to lie in which none works."]
    direction = axis_message(missing.direction)
    worst = GraspText.WORST(direction=direction, share=missing.share)
    if missing.suggestion is None:
        return [covered, worst, "No grasp was found that would help there."]
    return [covered, worst, GraspText.HELPS(arm=missing.arm, share=missing.would_work)]


def axis_message(direction: Floats) -> Message:
    """The axis of the part that is nearest to a unit direction (3,), and how far it is off."""
    k = int(np.abs(direction).argmax())
    off = float(np.arccos(min(abs(float(direction[k])), 1.0)))
    name = f"{'+' if direction[k] >= 0 else '-'}{'xyz'[k]}"
    if off < np.radians(0.5):
        return plain(name)
    return GraspText.AXIS_OFF(axis=name, angle=off)


def sphere_colours(found: Coverage) -> np.ndarray:
    """A colour (n, 3) 0..255 for each direction: red where nothing works, green where all does."""
    shares = np.asarray(found.shares)
    stops = np.array([rgb_of(BAD), rgb_of(BUSY), rgb_of(GOOD)], dtype=float)
    channels = [np.interp(shares, [0.0, 0.5, 1.0], stops[:, k]) for k in range(3)]
    return np.stack(channels, axis=1).astype(np.uint8)
