"""An arm that drops back what it holds, planned and proven without any scan: the bin is full."""

from collections.abc import Sequence

import numpy as np

from workbench.app.empty_hand.proving import proven
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.work import ProgressText
from workbench.model.plan import PlanResult
from workbench.model.scan import Obstacle, Scene
from workbench.model.tools.held_body import HeldAmount, drop_problem, tool_problem
from workbench.planning.empty_hand.drop_back import DropTask, route_drop
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.progress import Report, silent
from workbench.proof.claims.drop_back import drop_point
from workbench.proof.claims.stirring import unseen_content


def plan_drop_back(
    cell: Cell,
    arm: str,
    q: Floats,
    held: HeldAmount,
    *,
    placed: Sequence[Obstacle] = (),
    seed: int = 0,
    report: Report = silent,
) -> PlanResult:
    """Plan how an arm drops back what it holds, and prove it.

    Args:
        cell: with the bin.
        arm: its name.
        q: (n,) [rad, m] where it stands, chain order.
        held: what its hand may hold.
        placed: parts that were put down, as obstacles.
        seed: of everything random.
        report: progress.

    Raises:
        InputError: the robot link cannot begin such a plan, the cell has no parts, or the tool has
            several TCPs.
    """
    if problem := drop_problem(cell) or tool_problem(cell.arm(arm).tool):
        raise InputError(problem)
    scene = Scene(digest_of(()), (), tuple(placed))
    content, began = unseen_content(cell, scene), working_time()
    deadline = processor_time() + cell.policy.seconds
    report(0.1, ProgressText.MOTION())
    task = DropTask(arm, held, np.asarray(q, dtype=np.float64), drop_point(cell, held))
    found = route_drop(cell, task, scene, content.boxes, seed=seed, deadline=deadline)
    return proven(cell, scene, found, began, report)
