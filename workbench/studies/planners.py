"""The thesis' comparison of planners: one arm, from home to random tool poses in a bin.

Targets that no configuration reaches, and those where every configuration touches something, are
counted apart: no planner can solve them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.planning.collision.motion import RESOLUTION, bound_curves
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.picking.search import (
    PATHS_TRIED,
    as_sent,
    curve_check,
    edge_check,
    joint_weights,
)
from workbench.planning.planners.clock import working_time
from workbench.plugins.planner import planner_named
from workbench.plugins.progress import Report
from workbench.studies.targets import Target, drawn_poses, judge_targets

POINTS_A_SEGMENT = 20
"""Points at which the tool's way is measured, on each segment of a path."""


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """One planner, one target, this many iterations allowed and used; None for another program.

    `search` [s] finds a path; `finish` [s] shortens it, divides it into the waypoints that are
    sent, and checks those.  `tool_way` [m] is of what is sent, None when nothing is.
    """

    planner: str
    target: int
    allowed: int | None
    iterations: int | None
    search: float
    finish: float
    tool_way: float | None


class Course:
    """One arm of a cell with an empty bin, and the targets it is sent to from home.

    Concurrency: one thread at a time.
    """

    def __init__(self, cell: Cell, count: int, seed: int):
        """Draw and judge the targets.

        Args:
            cell: its first arm is used, its bin, its margins.
            count: how many targets.
            seed: of the targets.
        """
        self.arm: Arm = cell.arms[0]
        self.world = World(cell, ())
        self.world.enter(LegPhase(frozenset({self.arm.name})))
        self.start = self.world.motion.rounded(np.asarray(self.arm.home))
        poses = drawn_poses(cell.bin, count, seed)
        self.targets: list[Target] = judge_targets(self.world, self.arm, poses, seed)

    @property
    def goals(self) -> list[tuple[int, Floats]]:
        """Number and configuration (n,) [rad] of the targets that can be taken up."""
        return [(k, target.q) for k, target in enumerate(self.targets) if target.q is not None]

    def attempt(self, planner: str, number: int, goal: Floats, allowed: int) -> Attempt:
        """Plan once from home to a goal (n,) [rad], seeded by the target's number."""
        world, policy = self.world, self.world.policy
        columns, base = world.kinematics.columns[self.arm.name], world.configuration({})
        check = curve_check(world, columns, base)

        edges = world.edges(columns, base, RESOLUTION)
        chain, is_clear = world.chains[self.arm.name], edge_check(check, edges=edges)
        weights, rng = joint_weights(len(goal), policy), np.random.default_rng([number])
        search = finish = 0.0
        iterations, path = 0, None
        for _ in range(PATHS_TRIED):
            began = working_time()
            found, used = planner_named(planner)(
                self.start,
                goal,
                chain.lower,
                chain.upper,
                weights,
                is_clear,
                iterations=allowed,
                rng=rng,
            )
            middle = working_time()
            search, iterations = search + middle - began, iterations + used
            if found is None:
                break
            sent = as_sent(found, is_clear, policy.free_points, world.motion)
            is_spoiled = check(bound_curves(sent, self.world.motion, policy.zone)) is not None
            finish += working_time() - middle
            if not is_spoiled:
                path = sent
                break
        return Attempt(
            planner,
            number,
            allowed,
            iterations,
            search,
            finish,
            None if path is None else self.tool_way(path),
        )

    def tool_way(self, path: Floats) -> float:
        """How far the tool centre point moves along straight joint segments (m, n) [m]."""
        chain = self.world.chains[self.arm.name]
        shares = np.linspace(0.0, 1.0, POINTS_A_SEGMENT + 1)[1:, None]
        points = [chain.pose(path[0]).translation]
        for a, b in pairwise(path):
            points += [chain.pose(q).translation for q in a + shares * (b - a)]
        return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


def compare(
    course: Course, planners: Sequence[str], allowed: Sequence[int], report: Report
) -> list[Attempt]:
    """Every planner at every target with every number of iterations.

    Each planner goes once to the first target before the clock starts: compiled code is loaded.
    """
    goals = course.goals
    for planner in planners if goals else ():
        course.attempt(planner, *goals[0], max(allowed))
    attempts: list[Attempt] = []
    whole = len(planners) * len(allowed) * len(goals)
    for planner in planners:
        for most in allowed:
            for number, goal in goals:
                report(len(attempts) / whole, f"{planner}, {most} iterations")
                attempts.append(course.attempt(planner, number, goal, most))
    return attempts


def summary(attempts: Sequence[Attempt]) -> list[dict[str, Any]]:
    """One row a planner and number of iterations; times in s, of all attempts."""
    groups: dict[tuple[str, int | None], list[Attempt]] = {}
    for attempt in attempts:
        groups.setdefault((attempt.planner, attempt.allowed), []).append(attempt)
    return [_row(planner, allowed, group) for (planner, allowed), group in groups.items()]


def _row(planner: str, allowed: int | None, group: Sequence[Attempt]) -> dict[str, Any]:
    whole = np.array([attempt.search + attempt.finish for attempt in group])
    used = [attempt.iterations for attempt in group if attempt.iterations is not None]
    ways = [attempt.tool_way for attempt in group if attempt.tool_way is not None]
    return {
        "planner": planner,
        "allowed": allowed,
        "attempts": len(group),
        "success": len(ways) / len(group),
        "search_mean": float(np.mean([attempt.search for attempt in group])),
        "mean": float(whole.mean()),
        "median": float(np.median(whole)),
        "p95": float(np.percentile(whole, 95)),
        "iterations_mean": float(np.mean(used)) if used else None,
        "tool_way_mean": float(np.mean(ways)) if ways else None,
    }
