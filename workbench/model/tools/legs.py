"""What an arm carries on the legs of a change of its tool."""

from workbench.model.motion import LegName
from workbench.model.plan import ArmPlan

BARE_LEGS: frozenset[LegName] = frozenset({"retract", "cross", "dock"})
"""Legs without any tool."""

NEW_TOOL_LEGS: frozenset[LegName] = frozenset({"undock", "home"})
"""Legs with the tool that it has taken, in a plan that changes one."""


def carried_on(arm_plan: ArmPlan, leg: LegName) -> str | None:
    """The name of the tool on a leg, empty: a bare flange; None: the one that is mounted."""
    if not arm_plan.tool:
        return None
    if leg in BARE_LEGS:
        return ""
    return arm_plan.tool if leg in NEW_TOOL_LEGS else None
