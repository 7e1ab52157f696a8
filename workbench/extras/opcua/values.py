"""What a PLC sees of the state: a flat list of simple variables."""

from collections.abc import Mapping
from typing import Any

from asyncua import ua

from workbench.app.core.cell.kits import lacks_of
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.rows import plans_sent
from workbench.app.core.rights import obstacle
from workbench.app.core.state import State
from workbench.app.runtime.live import Live
from workbench.model.derived.by_recipe import kit_of, strategies_of
from workbench.model.derived.by_view import view_name, views_of

VARIABLES: Mapping[str, ua.VariantType] = {
    "Number": ua.VariantType.UInt32,
    "Phase": ua.VariantType.String,
    "Message": ua.VariantType.String,
    "Fault": ua.VariantType.String,
    "Control": ua.VariantType.String,
    "Recipe": ua.VariantType.UInt32,
    "Recipes": ua.VariantType.String,
    "Bin": ua.VariantType.String,
    "Bins": ua.VariantType.String,
    "EmptyBins": ua.VariantType.String,
    "View": ua.VariantType.String,
    "Views": ua.VariantType.String,
    "KitLacks": ua.VariantType.String,
    "KitIsComplete": ua.VariantType.Boolean,
    "KitsComplete": ua.VariantType.UInt32,
    "KitsIncomplete": ua.VariantType.UInt32,
    "PartsFound": ua.VariantType.UInt32,
    "PlanDigest": ua.VariantType.String,
    "Plans": ua.VariantType.UInt32,
    "PlansSent": ua.VariantType.UInt32,
    "RowEnds": ua.VariantType.String,
    "MayGoOn": ua.VariantType.Boolean,
    "Strategy": ua.VariantType.String,
    "Strategies": ua.VariantType.String,
    "Holds": ua.VariantType.Boolean,
    "ApprovedBy": ua.VariantType.String,
    "PartsPlaced": ua.VariantType.UInt32,
    "Job": ua.VariantType.String,
    "JobDone": ua.VariantType.Double,
    "Head": ua.VariantType.String,
}
"""By name; texts are empty and numbers 0 while there is nothing to say."""


def values_of(state: State, live: Live, head: tuple[int, str]) -> Mapping[str, Any]:
    """The value of each variable; `head` is number and hash of the journal's last entry."""
    job, lacks = state.job, lacks_of(state)
    return {
        "Number": state.number,
        "Phase": str(state.phase),
        "Message": str(state.message),
        "Fault": str(state.fault),
        "Control": state.control,
        "Recipe": state.cell.recipe,
        "Recipes": ", ".join(f"{r.number} {r.name}" for r in state.cell.recipes),
        "Bin": state.cell.bin.name,
        "Bins": ", ".join(box.name for box in state.cell.bins),
        "EmptyBins": ", ".join(b.name for b in state.cell.bins if b.name in state.empty_bins),
        "View": view_name(state.cell),
        "Views": ", ".join(view.name for view in views_of(state.cell)),
        "KitLacks": ", ".join(f"{count} {part}" for part, count in lacks.items()),
        "KitIsComplete": bool(kit_of(state.cell)) and not lacks,
        "KitsComplete": state.kit.complete,
        "KitsIncomplete": state.kit.incomplete,
        "PartsFound": len(state.detections or ()),
        "PlanDigest": "" if state.plan is None else state.plan.digest,
        "Plans": len(state.plans),
        "PlansSent": plans_sent(state),
        "RowEnds": "" if state.row_ends is None else str(state.row_ends),
        "MayGoOn": not obstacle(state, GoOn),
        "Strategies": ", ".join(strategies_of(state.cell)),
        "Strategy": "" if state.plan is None else str(state.plan.strategy),
        "Holds": state.proof is not None and state.proof.holds,
        "ApprovedBy": "" if state.approval is None else ", ".join(state.approval.people),
        "PartsPlaced": state.parts_placed,
        "Job": "" if job is None else job.name,
        "JobDone": 0.0 if job is None else live.progress_of(job.number)[0],
        "Head": f"{head[0]} {head[1]}",
    }
