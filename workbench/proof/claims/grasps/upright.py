"""Whether a part that has to stay upright does, from where it lies to its place.

Whatever the controller makes of the waypoints is checked in sets of configurations.  A turn of a
joint tilts what it carries by no more than itself.  So a set tilts a part by no more than the tilt
in its middle and the sum of what the joints turn.  Where that is too much the set is halved.
"""

from collections.abc import Iterator

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.derived.upright import tilt_from_vertical, tilting_axis
from workbench.model.geometry import Floats
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import ArmPlan, Leg, Plan, Violation
from workbench.proof.claims.motion import sweep_path
from workbench.proof.claims.stages import in_hand, tcp
from workbench.proof.claims.tolerances import TILTED
from workbench.proof.engine.robot import Tree

MOST_SETS = 20_000
"""Sets of a leg that are checked; one that needs more is refused."""


def upright_violations(
    cell: Cell, tree: Tree, plan: Plan, arm_plan: ArmPlan
) -> Iterator[Violation]:
    """Where an arm tilts its part farther than the part's file allows."""
    found = plan.detections[arm_plan.detection]
    arm, part = cell.arm(arm_plan.arm), cell.part(found.part)
    if part.upright is None:
        return
    axis, most = tilting_axis(part, found)
    carried = in_hand(cell, tree, plan, arm_plan).rotation @ axis
    for leg in arm_plan.legs:
        if not leg.holding:
            continue
        where = _find_tilted(cell, tree, arm, leg, carried, most + TILTED)
        if where is None:
            continue
        waypoint, q = where
        tilt = _tilt(tree, arm, carried, q) + part.tilt - most
        problem = ProofText.TILTED(tilt=tilt, most=part.tilt)
        if tilt <= part.tilt + TILTED:
            problem = ProofText.TILTS_TOO_LONG()
        yield Violation(problem, arm.name, leg.name, waypoint, q=q)


def _tilt(tree: Tree, arm: Arm, carried: Floats, q: Floats) -> float:
    """The tilt [rad] at a configuration (n,) [rad] of an axis `carried` (3,) in the TCP's frame."""
    return tilt_from_vertical(tcp(tree, tree.rest, arm, q).rotation @ carried)


def _find_tilted(
    cell: Cell, tree: Tree, arm: Arm, leg: Leg, carried: Floats, most: float
) -> tuple[int, Floats] | None:
    """A waypoint with a configuration (n,) [rad] after it that may be tilted too far; else None."""
    columns = tree.columns[arm.name][: len(arm.joints)]
    sets = sweep_path(columns, np.asarray(leg.q), cell.controller.motion, cell.policy.zone)
    sliding = [tree.model.joints[n].idx_q for n, j in tree.joints.items() if j.kind == "prismatic"]
    turning = ~np.isin(columns, sliding)
    waiting = [
        (int(sets.at[group]), corners[:size])
        for corners, size, group in zip(sets.corners, sets.sizes, sets.groups, strict=True)
    ][::-1]
    looks = 0
    while waiting:
        at, corners = waiting.pop()
        middle, looks = corners.mean(axis=0), looks + 1
        turned = float((np.abs(corners - middle).max(axis=0) * turning).sum())
        tilt = _tilt(tree, arm, carried, middle)
        # What is no number is not upright.
        if not tilt <= most or looks > MOST_SETS:
            return at, middle
        if tilt + turned > most and turned > TILTED:
            waiting += [(at, half) for half in _halve(corners)]
    return None


def _halve(corners: Floats) -> list[Floats]:
    """The hull of corners (m, n), cut in two through its longest edge."""
    lengths = np.abs(corners[:, None] - corners[None]).sum(axis=2)
    first, second = np.unravel_index(int(lengths.argmax()), lengths.shape)
    halves = [corners.copy(), corners.copy()]
    middle = (corners[first] + corners[second]) / 2
    halves[0][first], halves[1][second] = middle, middle
    return halves
