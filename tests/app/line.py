"""A state with what it has set in motion: rules, then decisions, as the bench does it."""

from collections.abc import Mapping
from typing import Any

from workbench.app.core.commands import Command, Entry, JobEnded
from workbench.app.core.decide import decide
from workbench.app.core.effects import Effect
from workbench.app.core.rights import RIGHTS, ROBOT_LINK, WORKER
from workbench.app.core.rules import allowed
from workbench.app.core.state import State

NOW = 1_000_000.0


class Line:
    def __init__(self, cell):
        self.state = State(cell)
        self.now = NOW
        self.joints: Mapping[str, float] = {}
        self.effects: list[Effect] = []

    def do(self, command: Command, actor: str = "") -> State:
        machine = WORKER if isinstance(command, JobEnded) else ROBOT_LINK
        actor = actor or (machine if RIGHTS[type(command)].by_machine else "ada")
        allowed(self.state, command, actor, self.now, self.joints)
        entry = Entry(self.state.number + 1, self.now, actor, command, self.joints)
        self.state, effects = decide(self.state, entry)
        self.effects.extend(effects)
        return self.state

    def ended(self, result: Any) -> State:
        """The running job brings this."""
        assert self.state.job is not None
        return self.do(JobEnded(self.state.job.number, result))
