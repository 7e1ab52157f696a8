"""A hand that stirs the parts in the bin, planned and proven: for parts that nothing can take."""

from workbench.app.empty_hand.proving import proven
from workbench.model.cell import Cell
from workbench.model.messages.work import ProgressText
from workbench.model.plan import PlanResult
from workbench.model.scan import Scene
from workbench.planning.collision.world import World
from workbench.planning.empty_hand.stirring import route_stir
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.progress import Report, silent
from workbench.proof.claims.stirring import content_of


def plan_stir(cell: Cell, scene: Scene, *, seed: int = 0, report: Report = silent) -> PlanResult:
    """Plan how one arm stirs the parts in the bin, and prove it.

    Where parts lie is not known from then on: boxes stand for all of them
    (`proof.claims.stirring`).

    Args:
        cell: with the bin.
        scene: what is known to be in it.
        seed: of everything random.
        report: progress.
    """
    content, began = content_of(cell, scene), working_time()
    world = World(cell, (), (*content.boxes, *content.others))
    world.deadline = processor_time() + cell.policy.seconds
    report(0.1, ProgressText.MOTION())
    found = route_stir(world, content.top, scene, seed=seed)
    return proven(cell, scene, found, began, report)
