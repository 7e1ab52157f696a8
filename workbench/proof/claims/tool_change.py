"""What the proof asks of a plan by which an arm changes its tool.

A change is four stretches, and in each the arm carries something else, or is at another slot: with
the old tool to its slot, bare away from it, bare to the slot of the new tool, with that tool home.
Each is proven as a plan of its own, in the cell as it is then: tools that the arm does not carry
stand in their slots.  What may touch there, and how, `table` states.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from workbench.model.cell import Cell, Tool
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import DROP_LEGS, LegName
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.tools.held_body import HeldAmount, with_held
from workbench.model.tools.slots import NO_TOOL

STRETCHES: tuple[tuple[LegName, ...], ...] = (
    ("reach", "stow"),
    ("retract",),
    ("cross", "dock"),
    ("undock", "home"),
)
"""The legs of each stretch."""


def change_violations(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a plan does nothing else than a change that the arm's slots allow."""
    arm = cell.arm(arm_plan.arm)
    does_more = plan.detections or arm_plan.takes_part or arm_plan.grasp or arm_plan.station
    if len(plan.arms) > 1 or does_more or arm_plan.tcp or arm_plan.found is not None:
        yield Violation(ProofText.NOT_ONLY_CHANGE(), arm.name)
    if arm_plan.tool == arm.tool.name:
        yield Violation(ProofText.SAME_TOOL(tool=arm_plan.tool), arm.name)
    if all(tool.name != arm_plan.tool for tool in arm.tools):
        yield Violation(ProofText.UNKNOWN_TOOL(tool=arm_plan.tool), arm.name)
    for tool in (arm.tool.name, arm_plan.tool):
        if all(slot.tool != tool for slot in arm.tool_slots):
            yield Violation(ProofText.NO_SLOT(tool=tool), arm.name)


def by_stretches(cell: Cell, plan: Plan) -> Iterator[tuple[Cell, Plan]]:
    """The cell as it is on each stretch of a plan, and the plan of that stretch.

    The plan of a stretch names the tool of the slot that it is at.  A plan by which a hand drops
    what it holds has one stretch with that in the hand, and one without.  Others are one stretch.
    """
    if plan.is_drop_plan:
        yield from _by_drop(cell, plan)
        return
    if not plan.is_tool_plan:
        yield cell, plan
        return
    (arm_plan,) = plan.arms
    arm = cell.arm(arm_plan.arm)
    new = next(tool for tool in arm.tools if tool.name == arm_plan.tool)
    at = (arm.tool, arm.tool, new, new)
    carried = (arm.tool, NO_TOOL, NO_TOOL, new)
    for names, slot_tool, tool in zip(STRETCHES, at, carried, strict=True):
        then = replace(arm_plan, tool=slot_tool.name)
        yield _carrying(cell, arm.name, tool), _stretch(plan, then, names)


def _by_drop(cell: Cell, plan: Plan) -> Iterator[tuple[Cell, Plan]]:
    (arm_plan,) = plan.arms
    holding = with_held(cell, arm_plan.arm, HeldAmount(arm_plan.held))
    yield holding, _stretch(plan, arm_plan, DROP_LEGS[:-1])
    yield cell, _stretch(plan, arm_plan, DROP_LEGS[-1:])


def _stretch(plan: Plan, arm_plan: ArmPlan, names: Sequence[LegName]) -> Plan:
    """The plan of the legs of these names."""
    legs = tuple(leg for leg in arm_plan.legs if leg.name in names)
    steps = tuple(step for step in plan.sequence if step.runs[0][1] in names)
    return replace(plan, arms=(replace(arm_plan, legs=legs),), sequence=steps)


def _carrying(cell: Cell, name: str, tool: Tool) -> Cell:
    arms = (replace(arm, tool=tool) if arm.name == name else arm for arm in cell.arms)
    return replace(cell, arms=tuple(arms))
