"""A plan is proven with the scan or the poses that there are."""

from collections.abc import Sequence

from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.plan import Plan, Proof
from workbench.model.scan import Detection, Scan, Scene
from workbench.perception.scene.unexplained import unexplained
from workbench.proof import prove as layer


def prove(
    cell: Cell,
    plan: Plan,
    *,
    detections: Sequence[Detection] | None = None,
    scan: Scan | None = None,
    resolution: float = layer.RESOLUTION,
) -> Proof:
    """Look at everything about a plan anew, by code that shares nothing with planning.

    What that promises, and what it does not, is said in `docs/proof.md`.

    A part of which the plan knows nothing is something in the scan that no part explains, and so an
    obstacle that the plan leaves out.

    Args:
        cell: as it is now.
        plan: as planned, or as another program made it.
        detections: the parts known to be in the bin; None takes the plan's word for them.
        scan: in which they were found; without it the plan's word for other obstacles is taken.
        resolution: [m] see `docs/proof.md`.
    """
    found = plan.detections if detections is None else tuple(detections)
    digest = digest_of(found)
    # A plan for poses is named after these, also where a scan shows what else there is.
    if scan is not None and plan.scan_digest != digest:
        digest = scan.digest
    elif detections is None:
        digest = plan.scan_digest
    obstacles = plan.obstacles if scan is None else unexplained(cell, scan, found)
    return layer.prove(cell, Scene(digest, found, obstacles), plan, resolution=resolution)
