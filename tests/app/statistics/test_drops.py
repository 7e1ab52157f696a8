"""What arms have dropped back is counted, and is no cycle."""

from dataclasses import replace

from dropping import drop_result
from written import Written

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import PlanDropBack
from workbench.app.statistics.drops import DropCount
from workbench.app.statistics.statistics import statistics, together
from workbench.gui.statistics.views import statistics_html


def test_what_was_dropped_back_is_counted_and_begins_no_cycle(samples):
    motion = replace(samples.cell.controller.motion, keeps_hand=True)
    cell = replace(samples.cell, controller=replace(samples.cell.controller, motion=motion))
    line = Written(cell)
    line.cycle(replace(samples, cell=cell), LinkEnded("stopped by ada"))
    line.do(AcknowledgeFault())
    for held, fault in (("two", ""), ("unknown", ""), ("one", "the cable is out")):
        line.joints = cell.joint_values({arm.name: arm.home for arm in cell.arms})
        line.do(PlanDropBack(held))
        digest = line.ended(drop_result(samples, cell, held)).plan.digest
        line.joints = {}
        for command in (WatchPlan, Approve, SendPlan):
            line.do(command(digest))
        line.do(LinkEnded(fault))
    counted = statistics(line.rows)
    assert counted.drops == DropCount(times=2, parts=2, unknown=1)
    assert len(counted.cycles) == 1 and counted.picked == 0
    assert together([counted, counted]).drops == DropCount(times=4, parts=4, unknown=2)
    assert "2 times, 2 parts; 1 time nobody knows how many" in statistics_html(counted)
