"""Named policies, and the wider one by which a plan is searched as needed."""

from collections.abc import Mapping
from dataclasses import replace

from workbench.model.cell import LIFT_NAMES, MOST_PICKS, Cell, Policy
from workbench.model.messages.cells import CellText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal

LEAST_AIR = 0.0015
"""[m] Left on each side of a part where fingers arrive as open as there is room."""

HEAP_GAP = 0.01
"""[m] Parts nearer to each other than this are of one heap, of which a plan takes one."""

MOST_STIRS = 20
"""Of stirs in a row."""

POLICIES: Mapping[str, Policy] = {
    "thorough": Policy(lifts=LIFT_NAMES, least_air=LEAST_AIR, pair_gap=HEAP_GAP),
    "as-needed": Policy(),
    "quick": Policy(as_needed=False),
}
"""Policies by how bins are emptied: with all lifts, and fingers as open as there is room; so only
where no plan comes out otherwise; or never so, but with the usual lift and as grasps state."""


def widened(policy: Policy) -> Policy:
    """The policy with all lifts, its own first, fingers as open as there is room, and heaps.

    It is for parts that lie close: of a heap a plan takes one.
    """
    others = tuple(name for name in LIFT_NAMES if name not in policy.lifts)
    air = LEAST_AIR if policy.least_air is None else policy.least_air
    gap = policy.pair_gap or HEAP_GAP
    return replace(policy, lifts=(*policy.lifts, *others), least_air=air, pair_gap=gap)


def picks_problem(policy: Policy) -> Message | None:
    """Why a policy cannot ask for this many plans after one scan; None when it can."""
    if not 1 <= policy.picks <= MOST_PICKS:
        return CellText.PICKS(most=MOST_PICKS, count=repr(policy.picks))
    return CellText.PAIR_GAP() if policy.picks > 1 and policy.pair_gap <= 0 else None


def stir_problem(cell: Cell) -> Message | None:
    """Why no hand can stir the parts in the bin of a cell; None when one can."""
    motion = cell.controller.motion
    if not cell.bin.has_walls:
        return Refusal.STIR_NO_WALLS()
    if not motion.takes_share or motion.sends_poses:
        return Refusal.STIR_NO_TIMES(link=motion.link)
    jerky = [arm.name for arm in cell.arms if arm.jerk is not None]
    return Refusal.STIR_JERK(arm=jerky[0]) if jerky else None
