"""A bin with many parts: simulated, searched, judged, planned and proven."""

from workbench.app.core.state import State
from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.model.cell import Cell
from workbench.model.scan import Scene
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts
from workbench.proof.claims.prove import prove
from workbench.studies.scale.growth import Costs, processor_seconds

SEED = 1


def measure_bin(cell: Cell, count: int) -> tuple[Costs, State]:
    """Processor times [s] of a bin with `count` parts of one kind, and a state with its plan.

    Plans are made of the poses that the simulation has, so that their number is the count.

    Args:
        cell: its bin has room for the parts, which are of its first kind.
        count: parts that fall.
    """
    kind = cell.parts[0].name
    pile = pile_of(cell, kind, count, seed=SEED)
    scan = synthesize(cell, pile, seed=SEED)
    find_parts(scan, cell, seed=SEED)
    result = plan_pick(cell, pile, scan.digest, seed=SEED)
    scene = Scene(scan.digest, pile)
    costs = {
        "simulate the pile, s": processor_seconds(lambda: pile_of(cell, kind, count, seed=SEED)),
        "simulate the scan, s": processor_seconds(lambda: synthesize(cell, pile, seed=SEED)),
        "find the parts, s": processor_seconds(lambda: find_parts(scan, cell, seed=SEED)),
        "judge all candidates, s": processor_seconds(lambda: judge(cell, pile, seed=SEED)),
        "plan and prove, s": processor_seconds(
            lambda: plan_pick(cell, pile, scan.digest, seed=SEED)
        ),
    }
    plan = result.plan
    if plan is not None:
        costs["prove, s"] = processor_seconds(lambda: prove(cell, scene, plan))
    state = State(
        cell,
        number=1,
        saved=cell.digest,
        scan=scan,
        detections=pile,
        candidates=result.candidates,
        plan=plan,
        proof=result.proof,
    )
    return costs, state
