"""A plan for the first of three parts that is on its way, and ends of it."""

from dataclasses import replace

from line import Line

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.model.release import PartReport

HOME = {"joint_1": 0.0}
MISSED = PartReport("right", 0, False, "closed to 0 mm", True)
PICKED = PartReport("right", 0, True)
END = LinkEnded("", 0, (MISSED,), (), may_have_moved=(0, 1))


def with_policy(cell, **policy):
    return replace(cell, policy=replace(cell.policy, **policy))


def sending(samples, cell, picks=1, made=Line):
    """A plan for the first of three parts, or a row for each of them, on its way."""
    samples = replace(samples, cell=cell, always=False)
    line = made(cell)
    line.joints = HOME
    line.do(TakeScan())
    scan = samples.scan()
    line.ended(scan)
    line.do(FindParts())
    line.ended(samples.row(scan.digest).plan.detections)
    line.do(MakePlan())
    result = samples.row(scan.digest)
    if picks == 1:
        result = replace(result, row=(), row_ends=None)
    digest = line.ended(result).plan.digest
    row = tuple(proven.plan.digest for proven in line.state.row)
    line.do(WatchPlan(digest, row=row))
    line.do(Approve(digest, row=row))
    line.do(SendPlan(digest))
    line.effects.clear()
    return line
