"""From which step on a plan's arms and held parts are out of the scanner's view.

The scanner's view is a pyramid and counts as a fixture.  The plan's last steps are checked for
contacts with it as in planning: continuously, for all motions that the controller may make of the
waypoints.  So the robot hides nothing, and no point of it counts as an obstacle.
"""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Fixture, ScannerMount
from workbench.model.derived.by_tcp import by_plan
from workbench.model.geometry import Floats, Mesh, Solid
from workbench.model.plan import LegName, Plan
from workbench.planning.collision.legs import Stretch, stretches
from workbench.planning.collision.motion import path_contact
from workbench.planning.collision.world import World

CLEAR_OF_VIEW = 0.02
"""[m] Margin of arms to the view, for calibration errors and the width of lenses."""

AT_THE_PARTS: frozenset[LegName] = frozenset({"reach", "approach", "extract", "stir"})
"""Legs before or at the taking of a part, or among the parts: the scene is not yet what the next
plan is for."""

VIEW = "scanner_view"


def sees_from(cell: Cell, plan: Plan) -> int:
    """The step of a plan, from 1, from which on the scanner's view is free; 0: none.

    From this step on no arm, finger or held part comes within `CLEAR_OF_VIEW` of the view, and no
    part is taken any more.  Fixed parts of the robot are as in every scan.  A scanner that cannot
    scan while arms move has no such step.  Neither has a change of tool, as it changes the cell.

    For a scanner whose lenses and lights are apart, the view is that from its frame alone.

    Args:
        cell: the cell with the scanner.
        plan: a proven plan, the last before the scan.
    """
    if not cell.scanner.while_moving or not plan.sequence or plan.is_tool_plan:
        return 0
    seen = replace(cell, fixtures=(*cell.fixtures, _view(cell.scanner)))
    # A finger moves by half of the stroke at most, so that it is never further than half of that
    # from one of the two ends of its way, which are both looked at, or from its middle.
    room = CLEAR_OF_VIEW + max(arm.tool.stroke[1] / 4 for arm in cell.arms)
    policy = replace(cell.policy, margin=room, near_margin=room)
    world = World(by_plan(seen, plan), plan.detections, (), policy)
    first = 0
    steps = list(enumerate(stretches(plan), 1))
    for number, stretch in reversed(steps):
        if any(leg.name in AT_THE_PARTS for _, leg in stretch.runs) or not _is_out(world, stretch):
            break
        first = number
    return first


def seconds_seen(plan: Plan, first: int) -> float:
    """Duration [s] of a plan from the start of its step `first`, counted from 1."""
    if not first:
        return 0.0
    steps = plan.sequence[first - 1 :]
    return sum(max(plan.arm(arm).leg(leg).seconds for arm, leg in step.runs) for step in steps)


def _is_out(world: World, stretch: Stretch) -> bool:
    """Whether no arm or held part is in the view during a step and after it."""
    # Arms that stand count as those that move; how fingers were left may be unknown.
    openings = {arm.name: arm.tool.stroke[1] / 2 for arm in world.cell.arms}
    openings |= stretch.phase.openings
    world.enter(replace(stretch.phase, moving=frozenset(openings), openings=openings))
    pairs = world.with_fixture(VIEW)
    base = world.configuration(
        {**stretch.standing, **{arm_plan.arm: leg.q[0] for arm_plan, leg in stretch.runs}}
    )
    if world.contact(base, pairs) is not None:
        return False
    for arm_plan, leg in stretch.runs:
        columns = world.kinematics.columns[arm_plan.arm]
        if path_contact(world, columns, base, np.asarray(leg.q), pairs) is not None:
            return False
    return True


def _view(scanner: ScannerMount) -> Fixture:
    """The scanner's view up to its largest range, as a pyramid with its tip at the scanner."""
    columns, rows = scanner.resolution
    half = scanner.far * np.tan(scanner.field_of_view / 2)
    x, y = half, half * rows / columns
    corners = [(-x, -y), (x, -y), (x, y), (-x, y)]
    points: Floats = np.array([(0.0, 0.0, 0.0), *((*corner, scanner.far) for corner in corners)])
    sides = [(0, 2, 1), (0, 3, 2), (0, 4, 3), (0, 1, 4), (1, 2, 3), (1, 3, 4)]
    shape = Mesh(points, np.array(sides), is_convex=True)
    solid = Solid(VIEW, shape, pin.SE3.Identity())
    return Fixture(VIEW, scanner.T_world_scanner, (solid,))
