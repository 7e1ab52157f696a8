"""Both arms as one: ways of all their joints past a bin, ours beside OMPL over the same checker.

It is what a plan does where two arms can move neither side by side nor one behind the other
(`planning/picking/synchronized_motion.py`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.model.candidate import Verdict
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.planning.collision.motion import segment
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.execution import compute_times
from workbench.planning.picking.search import curve_check
from workbench.planning.picking.synchronized_motion import columns_of, pace_in_step, way_in_step
from workbench.planning.planners.clock import processor_time
from workbench.planning.planners.ompl_planners import RRT_CONNECT
from workbench.plugins.progress import Report

OMPL_ITERATIONS = 1_000_000
"""For OMPL time alone is the limit: it draws from all of the joints' range."""

OURS, OMPL = "rrtconnect", "OMPL RRT-Connect"

BESIDE_BIN, ABOVE_FLOOR = 0.25, 0.3
"""[m] Tools begin and end no further beside the bin, and no higher above its floor."""


@dataclass(frozen=True, slots=True, eq=False)
class Ends:
    """Where both arms begin and end (n,) [rad], and whether it is clear straight ahead."""

    start: Floats
    goal: Floats
    is_straight: bool


@dataclass(frozen=True, slots=True, eq=False)
class PlanningAttempt:
    """One planner, one pair of ends: `processor` [s] it took, and the path (m, n) [rad] or None.

    `seconds` is how long the robot would take along the path.
    """

    planner: str
    ends: Ends
    processor: float
    path: Floats | None
    seconds: float | None


class BothArms:
    """The first two arms of a cell with an empty bin.

    Concurrency: one thread at a time.
    """

    def __init__(self, cell: Cell) -> None:
        """Make ready a world for each planner.

        Raises:
            InputError: the cell has one arm.
        """
        if len(cell.arms) < 2:
            raise InputError(f"cell {cell.name} has one arm; this measures two, so take another")
        self.cell = cell
        self.arms = [arm.name for arm in cell.arms[:2]]
        patient = replace(cell.policy, planner=OURS, iterations=OMPL_ITERATIONS)
        self.worlds = {
            OURS: World(cell, (), policy=replace(cell.policy, planner=OURS)),
            OMPL: World(cell, (), policy=patient),
        }
        for world in self.worlds.values():
            world.enter(LegPhase(frozenset(self.arms)))
        self.columns = columns_of(self.worlds[OURS], self.arms)

    def ends(self, seed: int) -> Ends:
        """A start and a goal that touch nothing, the bin between them.

        Each arm by itself is drawn in all of its joints' range until its tool is beside or over the
        bin: at the start on one side of the bin's middle, at the goal on the other.
        """
        rng = np.random.default_rng(seed)
        sides = rng.choice((-1.0, 1.0), len(self.arms))
        start, goal = self._draw(sides, rng), self._draw(-sides, rng)
        world = self.worlds[OURS]
        check = curve_check(world, self.columns, world.configuration({}))
        return Ends(start, goal, check(segment(start, goal)) is None)

    def _draw(self, sides: Floats, rng: np.random.Generator) -> Floats:
        world = self.worlds[OURS]
        while True:
            both = [
                self._beside(arm, side, rng)
                for arm, side in zip(self.arms, sides.tolist(), strict=True)
            ]
            state = dict(zip(self.arms, both, strict=True))
            if world.contact(world.configuration(state)) is None:
                return np.concatenate(both)

    def _beside(self, arm: str, side: float, rng: np.random.Generator) -> Floats:
        """A configuration (n,) [rad] of one arm, as it can be sent, with its tool on that side."""
        world, box = self.worlds[OURS], self.cell.bin
        chain, reach = world.chains[arm], box.size[:2] / 2 + BESIDE_BIN
        while True:
            q = np.clip(
                world.motion.rounded(rng.uniform(chain.lower, chain.upper)),
                chain.lower,
                chain.upper,
            )
            p = box.T_world_bin.actInv(chain.pose(q).translation)
            is_beside = np.all(np.abs(p[:2]) <= reach) and 0.0 <= p[2] <= ABOVE_FLOOR
            if is_beside and side * p[1] > 0.0:
                return q

    def attempt(self, planner: str, ends: Ends, seed: int, seconds: float) -> PlanningAttempt:
        """Plan once, at most this many seconds of processor time, by `OURS` or `OMPL`."""
        world, rng = self.worlds[planner], np.random.default_rng(seed)
        began = processor_time()
        world.deadline = began + seconds
        other = RRT_CONNECT if planner == OMPL else None
        found = way_in_step(world, self.arms, ends.start[None], ends.goal, rng, planner=other)
        used = processor_time() - began
        if isinstance(found, Verdict):
            return PlanningAttempt(planner, ends, used, None, None)
        pace = pace_in_step(world, self.arms)
        times = compute_times(found, pace.velocity, pace.acceleration, world.policy.zone, pace.jerk)
        return PlanningAttempt(planner, ends, used, found, float(times[-1]))


def compare(
    both: BothArms, *, pairs: int, seed: int, seconds: float, report: Report
) -> list[PlanningAttempt]:
    """Every planner at every pair of ends, one after the other.

    The first is planned once before the clock starts: compiled code is loaded.

    Args:
        both: the arms.
        pairs: how many pairs of ends.
        seed: of the first; the others count on.
        seconds: [s] of processor time that a plan may take.
        report: progress.
    """
    attempts: list[PlanningAttempt] = []
    for number in range(-1, pairs):
        report(max(0, number) / pairs, "both arms")
        at = seed + max(0, number)
        ends = both.ends(at)
        made = [both.attempt(planner, ends, at, seconds) for planner in (OURS, OMPL)]
        attempts += made if number >= 0 else []
    return attempts


def summary(attempts: Sequence[PlanningAttempt]) -> list[dict[str, Any]]:
    """One row for each planner and kind of ends; see `figures`."""
    kinds = (
        ("all", attempts),
        ("not straight ahead", [attempt for attempt in attempts if not attempt.ends.is_straight]),
    )
    return [
        {"planner": planner, "ends": name}
        | figures([attempt for attempt in some if attempt.planner == planner])
        for planner in (OURS, OMPL)
        for name, some in kinds
    ]


def figures(attempts: Sequence[PlanningAttempt]) -> dict[str, Any]:
    """What attempts came to: processor time in ms, of all of them; `motion` in s, None for none."""
    ms = np.array([attempt.processor for attempt in attempts]) * 1000
    motions = [attempt.seconds for attempt in attempts if attempt.seconds is not None]
    return {
        "pairs": len(attempts),
        "solved": len(motions),
        "median_ms": float(np.median(ms)) if len(ms) else None,
        "mean_ms": float(ms.mean()) if len(ms) else None,
        "p95_ms": float(np.percentile(ms, 95)) if len(ms) else None,
        "motion": float(np.mean(motions)) if motions else None,
    }
