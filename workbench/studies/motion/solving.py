"""Motion problems planned as a free leg of a plan is, ours beside OMPL over the same checker.

Times are from two configurations to waypoints rounded to the wire and checked.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from workbench.model.candidate import Verdict
from workbench.model.geometry import Floats
from workbench.planning.picking.route import free_path
from workbench.planning.picking.search import PathQuery, curve_check, joint_weights, search_path
from workbench.planning.planners.clock import working_time
from workbench.planning.planners.ompl_planners import RRT_CONNECT
from workbench.plugins.progress import Report
from workbench.studies.motion.problems import ARM, Case

OMPL_ITERATIONS = 1_000_000
"""For OMPL time alone is the limit: it draws from all of the joints' range."""

OMPL = "OMPL RRT-Connect"
KLAMPT = "Klamp't sbl"


@dataclass(frozen=True, slots=True, eq=False)
class Attempt:
    """One planner, one problem: `seconds` of the clock, `processor` [s], and what was found.

    `path` (m, n) [rad] is what would be sent, None when there is none.
    """

    planner: str
    name: str
    robot: str
    number: int
    seconds: float
    processor: float
    path: Floats | None


def compare(
    cases: Sequence[Case], *, with_ompl: bool, seed: int, seconds: float, report: Report
) -> list[Attempt]:
    """Every case that is not invalid, by our planner and, one after the other, by OMPL's.

    The first is planned once before the clock starts: compiled code is loaded.

    Args:
        cases: made by `cases_of`.
        with_ompl: or by ours alone.
        seed: of everything random.
        seconds: [s] that a plan may take.
        report: progress.
    """
    valid = [case for case in cases if not case.invalid]
    attempts: list[Attempt] = []
    for case in (*valid[:1], *valid):
        report(len(attempts) / max(1, len(valid) * (1 + with_ompl)), case.name)
        attempts.append(attempt(case, case.world.policy.planner, seed, seconds))
        if with_ompl:
            attempts.append(attempt(case, OMPL, seed, seconds))
    return attempts[1 + with_ompl :]


def attempt(case: Case, planner: str, seed: int, seconds: float) -> Attempt:
    """Plan once, at most this many seconds, by the policy's planner or by `OMPL`."""
    world, rng = case.world, np.random.default_rng([seed, case.number])
    used, began = time.process_time(), working_time()
    world.deadline = began + seconds
    found = _by_ompl(case, rng) if planner == OMPL else _by_us(case, rng)
    taken, used = working_time() - began, time.process_time() - used
    path = None if isinstance(found, Verdict) else found
    return Attempt(planner, case.name, case.robot, case.number, taken, used, path)


def _by_us(case: Case, rng: np.random.Generator) -> Floats | Verdict:
    return free_path(case.world, case.world.arm(ARM), case.start[None], case.goal, rng)


def _by_ompl(case: Case, rng: np.random.Generator) -> Floats | Verdict:
    """The same way to a path, with OMPL's RRT-Connect in the place of our search."""
    world = case.world
    columns, base = world.kinematics.columns[ARM], world.configuration({})
    chain = world.chains[ARM]
    query = PathQuery(
        curve_check(world, columns, base),
        (chain.lower, chain.upper),
        joint_weights(len(case.goal), world.policy),
        replace(world.policy, iterations=OMPL_ITERATIONS),
        world.motion,
        world.deadline,
        planner=RRT_CONNECT,
    )
    return search_path(query, case.start, case.goal, rng)


def summary(
    cases: Sequence[Case], attempts: Sequence[Attempt], planner: str
) -> list[dict[str, Any]]:
    """One row for each set, in order, of one planner's attempts; times in ms, of all attempts.

    `median_ms`, `mean_ms` and `p95_ms` are processor time, those with `wall_` the clock's;
    `way` [rad] is the mean length of the paths found in joint space.
    """
    rows: list[dict[str, Any]] = []
    for robot, name in dict.fromkeys((case.robot, case.name) for case in cases):
        of = [case for case in cases if (case.robot, case.name) == (robot, name)]
        made = [trial for trial in attempts if (trial.robot, trial.name) == (robot, name)]
        rows.append(
            {"set": name, "robot": robot} | figures(of, [a for a in made if a.planner == planner])
        )
    return rows


def figures(cases: Sequence[Case], attempts: Sequence[Attempt]) -> dict[str, Any]:
    """What one planner came to on these cases; see `summary`.  Times are None without attempts."""
    paths = [trial.path for trial in attempts if trial.path is not None]
    return {
        "problems": len(cases),
        "invalid": sum(bool(case.invalid) for case in cases),
        "solved": len(paths),
        **_times("", [trial.processor for trial in attempts]),
        **_times("wall_", [trial.seconds for trial in attempts]),
        "way": float(np.mean([_way(path) for path in paths])) if paths else None,
    }


def _times(prefix: str, seconds: Sequence[float]) -> dict[str, float | None]:
    if not seconds:
        return {f"{prefix}{name}_ms": None for name in ("median", "mean", "p95")}
    ms = np.array(seconds) * 1000
    return {
        f"{prefix}median_ms": float(np.median(ms)),
        f"{prefix}mean_ms": float(ms.mean()),
        f"{prefix}p95_ms": float(np.percentile(ms, 95)),
    }


def _way(path: Floats) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())
