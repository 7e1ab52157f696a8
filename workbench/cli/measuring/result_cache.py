"""Tasks whose results are known: what was asked before is answered from memory.

The same scan, seed and cell give the same result on any machine, so the worker would only say it
again.  Everything around a task is as ever: rules, states, journal, observers, the robot link.
"""

from collections.abc import Hashable
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from workbench.app.core.command import Command
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.effects import Effect, StartJob
from workbench.app.core.people import WORKER
from workbench.app.core.state import State
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.live import Live
from workbench.app.runtime.robot_link import Clock, Do
from workbench.app.runtime.worker import Question
from workbench.model.cell import Cell
from workbench.model.digest import digest_of


class Recalled:
    """Effects that remember; each task is run once.  The cell must stay the same.

    Lifetime: from construction until `close`.

    Concurrency: as `EffectRunner`; results from memory are reported from a thread of their own.
    """

    def __init__(self, cell: Cell, do: Do, now: Clock) -> None:
        """As `EffectRunner`."""
        self._do = do
        self._asked: dict[int, Hashable] = {}
        self._known: dict[Hashable, Any] = {}
        self._answers = ThreadPoolExecutor(1, "recalled")
        self._effects = EffectRunner(cell, self._take, now)

    @property
    def live(self) -> Live:
        """What goes on at this moment."""
        return self._effects.live

    def run(self, effect: Effect) -> None:
        """Begin an effect, or answer it."""
        if isinstance(effect, StartJob):
            asked = (effect.name, digest_of(effect.arguments))
            if asked in self._known:
                ended = JobEnded(effect.number, self._known[asked])
                self._answers.submit(self._do, ended, WORKER)
                return
            self._asked[effect.number] = asked
        self._effects.run(effect)

    def ask(self, question: Question) -> None:
        """As `EffectRunner`; no answer is remembered."""
        self._effects.ask(question)

    def close(self) -> None:
        """As `EffectRunner`."""
        self._answers.shutdown()
        self._effects.close()

    def _take(self, command: Command, actor: str) -> State:
        if isinstance(command, JobEnded):
            asked = self._asked.pop(command.number)
            if not isinstance(command.result, Exception):
                self._known[asked] = command.result
        return self._do(command, actor)
