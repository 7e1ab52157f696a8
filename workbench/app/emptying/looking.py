"""From where a pile is scanned: by the views of a scanner on an arm, and the paths between them."""

from collections.abc import Sequence
from dataclasses import dataclass

from workbench.app.empty_hand.view_plan import plan_view
from workbench.model.cell import Cell
from workbench.model.derived.by_view import by_each_view, view_name
from workbench.model.scan import Detection, Scan
from workbench.perception.scene.merging import merged
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.planners.clock import working_time


@dataclass(frozen=True, slots=True, eq=False)
class Look:
    """A scan of a pile, and the cell by the view at which the arm stands after it.

    `scans` were taken for it, the motion between their views took `motion` [s], and to merge them
    took `merging` [s].
    """

    cell: Cell
    scan: Scan
    scans: int = 1
    motion: float = 0.0
    merging: float = 0.0


def scan_pile(cell: Cell, lying: Sequence[Detection], *, seed: int) -> Look:
    """A simulated scan; where views are merged, from each to which a proven path leads.

    Args:
        cell: by the view at which the arm stands.
        lying: the parts as they lie.
        seed: of everything random.
    """
    scan, carrier = synthesize(cell, lying, seed=seed), cell.scanner.on_arm
    if carrier is None or not carrier.merges_views:
        return Look(cell, scan)
    look = Look(cell, merged(cell, None, scan, view_name(cell)))
    for following in by_each_view(cell)[1:]:
        seconds = _seconds_between(look.cell, following, seed=seed)
        if seconds is not None:
            scan, began = synthesize(following, lying, seed=seed), working_time()
            whole = merged(following, look.scan, scan, view_name(following))
            merging = look.merging + working_time() - began
            look = Look(following, whole, look.scans + 1, look.motion + seconds, merging)
    return look


def from_next_view(cell: Cell, *, seed: int) -> tuple[Cell, float]:
    """The cell by the next view to which a proven path leads, and how long that takes [s].

    As it is where there is none, and where each scan is merged from all views.
    """
    carrier = cell.scanner.on_arm
    if carrier is not None and not carrier.merges_views:
        for following in by_each_view(cell)[1:]:
            seconds = _seconds_between(cell, following, seed=seed)
            if seconds is not None:
                return following, seconds
    return cell, 0.0


def _seconds_between(cell: Cell, following: Cell, *, seed: int) -> float | None:
    """How long [s] the proven path from one view to another takes; None where there is none."""
    found = plan_view(following, start=view_name(cell), seed=seed)
    if found.plan is None or found.proof is None or not found.proof.holds:
        return None
    return found.plan.cycle_seconds
