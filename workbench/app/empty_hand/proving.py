"""What planning without a part brings: the plan with its proof, or the verdict."""

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Cell
from workbench.model.messages.work import ProgressText
from workbench.model.plan import Plan, PlanResult
from workbench.model.scan import Scene
from workbench.planning.planners.clock import working_time
from workbench.plugins.progress import Report
from workbench.proof.claims.prove import prove


def proven(
    cell: Cell, scene: Scene, found: Plan | Verdict, began: float, report: Report
) -> PlanResult:
    """The result of a planning, with the proof of its plan.

    Args:
        cell: for which it was planned.
        scene: what is known to be in the bin.
        found: the plan, or why there is none.
        began: when planning began [s], by `working_time`.
        report: progress.
    """
    routed = working_time()
    if isinstance(found, Verdict):
        plan, proof, verdict = None, None, found
    else:
        report(0.9, ProgressText.PROOF())
        proof = prove(cell, scene, found)
        plan, verdict = found, Verdict(Reason.OK, Stage.ROUTE)
    seconds = {"route": routed - began, "prove": working_time() - routed}
    return PlanResult((), plan, proof, verdict, seconds, scene.obstacles, cell.policy.planner)
