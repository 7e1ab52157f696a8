"""The proof: everything about a plan is looked at anew, in the scene as it is known, or refused."""

from workbench.model.cell import Cell
from workbench.model.plan import Plan, Proof
from workbench.model.scan import Scene
from workbench.proof.form import form_violations, limit_violations, range_violations
from workbench.proof.robot import tree_of
from workbench.proof.rules import (
    grasp_violations,
    pair_violations,
    roll_violations,
)
from workbench.proof.search import SIGHT
from workbench.proof.walk import Walk

RESOLUTION = 0.0005
"""[m] Where nothing moves further than this, a state that was looked at stands for its
neighbours."""


def prove(
    cell: Cell,
    scene: Scene,
    plan: Plan,
    *,
    resolution: float = RESOLUTION,
    stated: Proof | None = None,
) -> Proof:
    """Check everything that can be checked about a plan, whoever has made it.

    Args:
        cell: as it is now.
        scene: what is known to be in the bin; what the plan says of it is compared.
        plan: as planned, or as read from a file.
        resolution: [m] see `search`; smaller is slower and never admits more.
        stated: a proof of the same plan: its clearances are not searched for, which takes less
            time; that they are not what it says is a violation.

    Returns:
        A proof; `holds` is True when there is no violation.
    """
    violations = list(form_violations(cell, scene, plan))
    walked = None
    arms = [(cell.arm(one.arm), one) for one in plan.arms] if not violations else []
    legs = [(arm, leg) for arm, one in arms for leg in one.legs]
    # Joints that turn a hundred times would be followed for hours.
    violations += [f for arm, leg in legs for f in range_violations(cell, arm, leg)]
    if not violations:
        tree = tree_of(cell)
        violations += [f for arm, leg in legs for f in limit_violations(cell, arm, leg)]
        violations += [f for _, one in arms for f in grasp_violations(cell, tree, plan, one)]
        violations += [f for _, one in arms for f in roll_violations(cell, tree, plan, one)]
        violations += pair_violations(cell, plan)
        walked = Walk(cell, tree, plan, resolution, stated).result()
        violations += walked.violations
    return Proof(
        plan_digest=plan.digest,
        cell_digest=cell.digest,
        scan_digest=plan.scan_digest,
        checks=0 if walked is None else walked.looks,
        resolution=resolution,
        zone=cell.zone,
        clearance=SIGHT if walked is None else walked.clearance,
        nearest=None if walked is None else walked.nearest,
        violations=tuple(violations),
        clearances=() if walked is None else walked.clearances,
        apart=() if walked is None else walked.apart,
    )
