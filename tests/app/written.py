"""A line whose entries are counted."""

from line import Line

from workbench.app.core.command import Entry
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Sent
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.records.record import command_form, entry_record
from workbench.journal.journal import Row
from workbench.model.release import Receipt


class Written(Line):
    """A line whose entries are written as the bench writes them; each takes a second."""

    def __init__(self, cell):
        super().__init__(cell)
        self.rows: list[Row] = []

    def do(self, command, actor=""):
        self.now += 1
        state = super().do(command, actor)
        entry = Entry(state.number, self.now, actor or "ada", command)
        record = entry_record(entry, command_form(command), state)
        files = tuple(record.files)
        self.rows.append(Row(state.number, record.kind, record.body, files, "", ""))
        return state

    def plan(self, samples, *, is_possible=True):
        self.do(TakeScan())
        self.now += 1
        self.ended(samples.scan())
        self.do(FindParts())
        self.now += 2
        self.ended(samples.detections())
        self.do(MakePlan())
        self.now += 3
        scene = self.state.scene_digest
        return self.ended(samples.planned(scene) if is_possible else samples.refused())

    def cycle(self, samples, end=None):
        digest = self.plan(samples).plan.digest
        self.do(WatchPlan(digest))
        self.do(Approve(digest))
        self.do(SendPlan(digest))
        for number in range(3):
            self.do(Sent(Receipt(self.now, "right", "in", "inR#", number + 1, 3)))
        self.do(end or LinkEnded(parts_placed=1))
