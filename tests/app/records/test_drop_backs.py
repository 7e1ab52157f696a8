"""A drop back on record: computed again, it begins where the arm was reported."""

from dataclasses import replace

from dropping import OVER_BIN
from idle import Idle

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import PlanDropBack
from workbench.app.core.people import ROBOT_LINK, WORKER, Role
from workbench.app.core.state import Phase
from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.tools.held_body import HeldAmount


class Standing(Idle):
    """The right arm is reported over the bin, the other one at home."""

    def __init__(self, cell, do, now):
        super().__init__(cell, do, now)
        joints = cell.joint_values({"right": OVER_BIN, "left": cell.arm("left").home})
        self.live = replace(self.live, joints=joints)


def test_a_session_with_a_drop_back_is_computed_again(tmp_path):
    cell = read_cell("yumi")
    bench = Bench(cell, Journal(tmp_path), effects=Standing)
    result = plan_drop_back(cell, "right", OVER_BIN, HeldAmount.ONE)
    state = bench.do(PlanDropBack("one", "right"), "Ada", Role.ENGINEER)
    bench.do(JobEnded(state.job.number, result), WORKER)
    for command in (WatchPlan, Approve, SendPlan):
        bench.do(command(result.plan.digest), "Ada", Role.ENGINEER)
    last = bench.do(LinkEnded(), ROBOT_LINK)
    bench.close()
    entries = list(replay(Journal(tmp_path), cell))
    again = entries[-1][1]
    assert again.phase is last.phase is Phase.DONE and again.plan.digest == result.plan.digest
    asked = next(entry for entry, _ in entries if isinstance(entry.command, PlanDropBack))
    arm = cell.arm("right")
    assert [asked.joints[name] for name in arm.joints] == OVER_BIN.tolist()
