"""How candidates would be judged where a thing is dragged to, asked again and again meanwhile."""

import logging
import threading
import time
from collections.abc import Mapping
from typing import Any

import pinocchio as pin

from workbench.app.core.cycle.outcomes import avoided_parts
from workbench.app.core.state import State
from workbench.app.picking.glance import Glance
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.worker import Question
from workbench.gui.shared.own import Dragged
from workbench.gui.shared.visitor import Visitor
from workbench.model.messages.message import Message
from workbench.model.scan import Obstacle

log = logging.getLogger(__name__)


class LiveVerdicts:
    """The verdicts of one drag after the other in one browser; nobody else sees them.

    They are of the scene in which the drag began: once that is another, no more come until the next
    drag.  What is shown is never older than what was shown before, and gone when the drag is over.

    Concurrency: any thread; `answered` comes from that of the worker's owner.
    """

    def __init__(self, visitor: Visitor, command: type):
        """Nothing is dragged.

        Args:
            visitor: whose browser.
            command: that the drags end in; who may not give it is shown nothing.
        """
        self._visitor, self._command = visitor, command
        self._lock = threading.RLock()
        self._state: State | None = None
        self._avoided: tuple[tuple[int, Message], ...] = ()
        self._drag = self._asked = self._shown = 0
        self._brought: tuple[State, tuple[Obstacle, ...]] | None = None
        visitor.on_end(self.end)

    def prepare(self) -> None:
        """A drag may begin soon: work out once what takes the first answer a second."""
        with self._lock:
            self.begin()
            self.ask({}, pin.SE3.Identity())
            self.end()

    def begin(self) -> None:
        """A drag begins, in the scene as it is now."""
        with self._lock:
            self.end()
            state = self._visitor.bench.state
            if state.detections:
                self._state = state
                self._avoided = avoided_parts(state, time.time())

    def ask(self, otherwise: Mapping[str, Any], T_world_words: pin.SE3) -> None:
        """Somebody drags: report what that would come to.

        Returns at once.  What was asked before and nobody has begun with is not answered any more.

        Args:
            otherwise: what is other than in the state: `detections`, or `change` of the cell.
            T_world_words: where in the scene it is reported.
        """
        with self._lock:
            state, bench = self._state, self._visitor.bench
            if state is None or not isinstance(bench, Bench):
                return
            if not self._is_true(state):
                self.end()
                return
            self._asked += 1
            drag, number = self._drag, self._asked
            arguments = {
                "change": {},
                "detections": state.detections,
                "avoided": self._avoided,
                "obstacles": self._obstacles_known(state),
                "around": None,
                **otherwise,
            }
            if arguments["obstacles"] is None:
                around = state.scan, state.detections, state.placed, state.scene_digest
                arguments["around"] = around

        def take_answer(result: Any) -> None:
            self._take_answer(drag, number, state, result, T_world_words)

        bench.ask(Question(self._visitor.number, "glance", arguments, take_answer))

    def end(self) -> None:
        """The drag is over: what is shows again, and late answers are not taken."""
        with self._lock:
            self._state = None
            self._drag += 1
            if self._visitor.own.now.dragged is not None:
                self._visitor.own.change(dragged=None)

    def _is_true(self, state: State) -> bool:
        visitor, now = self._visitor, self._visitor.bench.state
        is_free = not visitor.obstacle(now, self._command) and not visitor.look.now.is_playing
        return is_free and is_same_scene(state, now)

    def _obstacles_known(self, state: State) -> tuple[Obstacle, ...] | None:
        """What stands around besides, where planning has said it or an answer has brought it."""
        if state.candidates is not None:
            return state.obstacles
        brought = self._brought
        return brought[1] if brought is not None and is_same_view(brought[0], state) else None

    def _take_answer(
        self, drag: int, number: int, state: State, result: Any, T_world_words: pin.SE3
    ) -> None:
        with self._lock:
            if isinstance(result, Glance):
                self._brought = state, result.obstacles
            if drag != self._drag or number < self._shown:
                return
            if not isinstance(result, Glance):
                log.warning("no verdicts while something is dragged: %s", result)
                self.end()
                return
            if not self._is_true(state):
                self.end()
                return
            self._shown = number
            self._visitor.own.change(dragged=Dragged(result, T_world_words, state))


def is_same_view(first: State, second: State) -> bool:
    """Whether the same parts were found in the same scan, with the same cell around but grasps."""
    a, b = first.cell, second.cell
    return (
        first.scan is second.scan
        and first.detections is second.detections
        and first.placed is second.placed
        and a.bin is b.bin
        and a.fixtures is b.fixtures
    )


def is_same_scene(first: State, second: State) -> bool:
    """Whether verdicts about one are true of the other: nothing was changed, found or begun."""
    return first is second or (
        first.cell is second.cell
        and first.scan is second.scan
        and first.detections is second.detections
        and first.candidates is second.candidates
        and first.plan is second.plan
        and first.placed is second.placed
        and first.job is second.job
        and first.phase is second.phase
    )
