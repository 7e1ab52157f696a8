"""An arm that changes its tool, planned and proven without any scan: the bin counts as full."""

from collections.abc import Sequence

from workbench.app.empty_hand.proving import proven
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.messages.work import ProgressText
from workbench.model.plan import PlanResult
from workbench.model.scan import Obstacle, Scene
from workbench.model.tools.slots import change_problem
from workbench.planning.empty_hand.tool_change import route_change
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.progress import Report, silent
from workbench.proof.claims.scene import unseen_bin


def plan_tool_change(
    cell: Cell,
    arm: str,
    tool: str,
    *,
    placed: Sequence[Obstacle] = (),
    seed: int = 0,
    report: Report = silent,
) -> PlanResult:
    """Plan how an arm puts down its tool and takes another one, and prove it.

    Args:
        cell: with slots for both tools.
        arm: its name.
        tool: that it carries afterwards.
        placed: parts that were put down, as obstacles.
        seed: of everything random.
        report: progress.

    Raises:
        InputError: there is no such arm or tool, a slot is missing, or the robot link couples none.
    """
    if problem := change_problem(cell, arm, tool):
        raise InputError(problem)
    scene = Scene(digest_of(()), (), (unseen_bin(cell), *placed))
    began, deadline = working_time(), processor_time() + cell.policy.seconds
    report(0.1, ProgressText.MOTION())
    found = route_change(cell, arm, tool, scene, seed=seed, deadline=deadline)
    return proven(cell, scene, found, began, report)
