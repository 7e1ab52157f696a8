"""The path of a scanner on an arm to its view, and back: one leg, proven without any scan."""

from collections.abc import Sequence

from workbench.app.core.cycle.arm_scanner import view_named
from workbench.app.empty_hand.proving import proven
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.work import ProgressText
from workbench.model.plan import PlanResult
from workbench.model.robot import HOME
from workbench.model.scan import Obstacle, Scene
from workbench.planning.collision.world import World
from workbench.planning.empty_hand.view_path import route_view
from workbench.planning.planners.clock import processor_time, working_time
from workbench.plugins.progress import Report, silent
from workbench.proof.claims.scene import unseen_bin


def plan_view(
    cell: Cell,
    *,
    view: str = "",
    start: str = HOME,
    placed: Sequence[Obstacle] = (),
    seed: int = 0,
    report: Report = silent,
) -> PlanResult:
    """Plan how an arm takes its scanner to the chosen view, or home from there, and prove it.

    No scan shows the bin yet: it counts as full (`proof.claims.scene.unseen_bin`).

    Args:
        cell: whose scanner an arm carries.
        view: the name of the view; empty: that of the cell; `HOME`: from the view to the home.
        start: where a path to the view begins: at `HOME` or another view.
        placed: parts that were put down, as obstacles.
        seed: of everything random.
        report: progress.

    Raises:
        CommandRefused: the scanner stands, or one of these names is none of its views.
    """
    carrier = view_named(cell, view)
    scene = Scene(digest_of(()), (), (unseen_bin(cell), *placed))
    world, began = World(cell, (), scene.obstacles), working_time()
    world.deadline = processor_time() + cell.policy.seconds
    report(0.1, ProgressText.MOTION())
    begin = carrier.start_of(start)
    if begin is None:
        known = [HOME, *(other.name for other in carrier.other_views)]
        raise CommandRefused(Refusal.OTHER_START(start=f"{start!r:.60}", known=known))
    between = (carrier.view.q, carrier.home) if view == HOME else (begin, carrier.view.q)
    found = route_view(world, carrier.arm, between, scan_digest=scene.scan_digest, seed=seed)
    return proven(cell, scene, found, began, report)
