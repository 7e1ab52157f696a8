"""What sessions of assemblies have in common: bench, tasks carried out, parts in the bin."""

from assembling import assembly_cell, standing_spacer
from idle import Idle

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import StartJob
from workbench.app.core.people import ROBOT_LINK, WORKER
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.app.runtime.work import JOBS
from workbench.model.cell import PlanOverrides
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import PlanResult
from workbench.model.release import PartReport
from workbench.model.scan import Detection
from workbench.plugins.progress import never, silent

CELL = assembly_cell()


class Remembering(Idle):
    """Effects that are remembered, for tests that carry them out; the robot stands at home."""

    def __init__(self, cell, do, now):
        super().__init__(cell, do, now)
        self.live = Live(joints=cell.joint_values({arm.name: arm.home for arm in cell.arms}))
        self.started = []

    def run(self, effect):
        if isinstance(effect, StartJob):
            self.started.append(effect)


def lying() -> tuple[Detection, ...]:
    """A bolt on its side and a spacer on its end, apart from each other."""
    bolt = pose_from_rpy((0.0, -0.09, 0.0135), (0.0, 1.5708, 0.5))
    spacer = CELL.bin.T_world_bin * pose_from_rpy((0.0, 0.07, 0.0105))
    return (
        Detection("bolt", CELL.bin.T_world_bin * bolt),
        Detection(standing_spacer(CELL).part, spacer),
    )


def plan(bench: Bench, detections, picks: int = 1) -> PlanResult:
    bench.do(UseDetections(detections), "ada")
    bench.do(MakePlan(threshold=None, overrides=PlanOverrides(picks=picks)), "ada")
    job = bench.remembered[-1]
    result = JOBS[job.name](bench.state.cell, job.arguments, silent, never)
    bench.do(JobEnded(bench.state.job.number, result), WORKER)
    return result


def carry_out(bench: Bench, result: PlanResult) -> None:
    digest = result.plan.digest
    for command in (WatchPlan(digest), Approve(digest), SendPlan(digest)):
        bench.do(command, "ada")
    (pick,) = result.plan.picks
    parts = (PartReport(pick.arm, pick.detection, True),)
    bench.do(LinkEnded(parts_placed=1, parts=parts), ROBOT_LINK)
