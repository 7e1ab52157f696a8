"""A state with what it has set in motion: rules, then decisions, as the bench does it."""

from collections.abc import Mapping
from typing import Any

import pytest

from workbench.app.core.command import Command, Entry
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.effects import Effect
from workbench.app.core.people import ROBOT_LINK, WORKER
from workbench.app.core.state import State
from workbench.model.errors import CommandRefused

NOW = 1_000_000.0


class Line:
    def __init__(self, cell):
        self.state = State(cell)
        self.now = NOW
        self.joints: Mapping[str, float] = {}
        self.effects: list[Effect] = []

    def do(self, command: Command, actor: str = "") -> State:
        machine = WORKER if isinstance(command, JobEnded) else ROBOT_LINK
        actor = actor or (machine if command.right.by_machine else "ada")
        check_allowed(self.state, command, actor, self.now, self.joints)
        entry = Entry(self.state.number + 1, self.now, actor, command, self.joints)
        self.state, effects = decide(self.state, entry)
        self.effects.extend(effects)
        return self.state

    def ended(self, result: Any) -> State:
        """The running job brings this."""
        assert self.state.job is not None
        return self.do(JobEnded(self.state.job.number, result))


def send(line: Line, samples: Any, scan: TakeScan | None = None) -> None:
    """A cycle until its plan is on its way."""
    line.do(scan or TakeScan())
    line.ended(samples.scan())
    line.do(FindParts())
    line.ended(samples.detections())
    line.do(MakePlan())
    digest = line.ended(samples.planned(line.state.scene_digest)).plan.digest
    line.do(WatchPlan(digest))
    line.do(Approve(digest))
    line.do(SendPlan(digest))


def planned_line(samples: Any, cell: Any) -> Line:
    line = Line(cell)
    make_plan(samples, line)
    return line


def make_plan(samples: Any, line: Line) -> None:
    """From a scan to its plan, by what samples there are of each."""
    line.do(TakeScan())
    scan = samples.scan()
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.detections())
    line.do(MakePlan(threshold=0.2))
    line.ended(samples.planned(scan.digest))


def refused(line: Line, command: Command, actor: str = "ada") -> str:
    with pytest.raises(CommandRefused) as caught:
        line.do(command, actor)
    return str(caught.value)
