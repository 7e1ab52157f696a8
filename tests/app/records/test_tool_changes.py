"""A change of tool on record: computed again, it leads through the same cells."""

from idle import Idle

from workbench.app.core.cell.changes import StateTool
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.empty_hand import PlanToolChange
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import ROBOT_LINK, WORKER, Role
from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal


def changed(bench: Bench, tool: str, ended: LinkEnded) -> None:
    result = plan_tool_change(bench.state.cell, "right", tool)
    assert result.plan is not None and result.proof is not None and result.proof.holds
    state = bench.do(PlanToolChange(tool), "Ada", Role.ENGINEER)
    assert state.job is not None
    bench.do(JobEnded(state.job.number, result), WORKER)
    for command in (WatchPlan, Approve, SendPlan):
        bench.do(command(result.plan.digest), "Ada", Role.ENGINEER)
    bench.do(ended, ROBOT_LINK)


def test_a_session_with_a_change_and_a_failed_one_is_computed_again(tmp_path):
    cell = read_cell(find("robots", "tx2_90") / "tool_changer.toml")
    bench = Bench(cell, Journal(tmp_path), effects=Idle)
    changed(bench, "wide_cup", LinkEnded())
    assert bench.state.cell.arm("right").tool.name == "wide_cup"
    changed(bench, "suction_cup", LinkEnded(fault="stopped"))
    bench.do(AcknowledgeFault(), "Ada", Role.ENGINEER)
    assert bench.state.tools_unknown == ("right",)
    last = bench.do(StateTool("right", "suction_cup"), "Ada", Role.ENGINEER)
    assert last.cell.digest == cell.digest and not last.tools_unknown
    bench.close()
    again = list(replay(Journal(tmp_path), cell))[-1][1]
    assert again.cell.digest == last.cell.digest and again.tools_unknown == last.tools_unknown
