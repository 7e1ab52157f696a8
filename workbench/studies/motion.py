"""Motion problems planned as a free leg of a plan is, ours beside OMPL over the same checker.

Each problem becomes a cell with one arm, nothing in its hand, and the obstacles as fixtures.  Times
are from two configurations to waypoints rounded to the wire and checked; the cell is made before.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.app.picking.pipeline import Report
from workbench.formats.robots.motion_problems import MotionProblem, MotionSet
from workbench.model.candidate import Verdict
from workbench.model.cell import Arm, Bin, Cell, Fixture, Policy, ScannerMount, Tool
from workbench.model.geometry import Floats, Solid
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.motion import Curves, chain_contact
from workbench.planning.collision.pairing import Phase
from workbench.planning.collision.world import World
from workbench.planning.picking.route import free_path
from workbench.planning.picking.search import joint_weights, searched
from workbench.planning.planners.clock import working_time
from workbench.planning.planners.ompl_planners import RRT_CONNECT
from workbench.plugins.robot_link import controller_by, usual_link

OMPL_ITERATIONS = 1_000_000
"""For OMPL time alone is the limit: it draws from all of the joints' range."""

OMPL = "OMPL RRT-Connect"

ARM = "arm"


class _NoBin(Bin):
    """A cell without a bin."""

    @property
    def solids(self) -> tuple[Solid, ...]:
        return ()


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """A problem made ready: its world, the ends (n,) [rad] as they can be sent, what is wrong.

    `name` is that of its set, in which it is the `number`-th; `problem` is its own.  `invalid` says
    why nobody can solve it; it is empty where somebody may.
    """

    name: str
    robot: str
    number: int
    problem: str
    world: World
    start: Floats
    goal: Floats
    invalid: str


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


def case_of(name: str, robot: str, number: int, problem: MotionProblem, policy: Policy) -> Case:
    """A problem of the set `name`, the `number`-th in it."""
    world = World(_cell_of(problem, policy), ())
    world.enter(Phase(frozenset({ARM})))
    chain = world.chains[ARM]
    limits = problem.robot.limits(problem.joints)[:2]
    invalid, ends = "", []
    for end, q in (("start", problem.start), ("goal", problem.goal)):
        # Rounding a joint at its limit must not carry it beyond.
        ends.append(np.clip(world.motion.rounded(q), chain.lower, chain.upper))
        if np.any(q < limits[0]) or np.any(q > limits[1]):
            invalid = invalid or f"its {end} is beyond the limits of a joint"
        contact = world.contact(world.configuration({ARM: ends[-1]}))
        if contact is not None:
            invalid = invalid or f"at its {end} {' and '.join(contact.pair)} touch"
    return Case(name, robot, number, problem.name, world, ends[0], ends[1], invalid)


def _cell_of(problem: MotionProblem, policy: Policy) -> Cell:
    robot, joints = problem.robot, problem.joints
    moving = tuple(range(len(joints)))
    identity = pin.SE3.Identity()
    arm = Arm(
        name=ARM,
        controller_id="A",
        flange=robot.joint(joints[-1]).child,
        joints=joints,
        axis_order=moving,
        axis_signs=(1,) * len(joints),
        home=problem.start,
        acceleration=np.ones(len(joints)),
        tool=Tool("none", identity, ()),
    )
    fixtures = (Fixture("obstacles", identity, problem.obstacles),)
    return Cell(
        name=problem.name,
        robot=robot,
        T_world_robot=identity,
        arms=(arm,),
        bin=_NoBin(identity, np.ones(3)),
        scanner=ScannerMount(identity),
        controller=controller_by(usual_link()),
        parts=(),
        fixtures=fixtures,
        policy=policy,
    )


def cases_of(sets: Sequence[MotionSet], policy: Policy) -> list[Case]:
    """All problems made ready, to be planned by that policy."""
    return [
        case_of(one.name, one.robot, number, problem, policy)
        for one in sets
        for number, problem in enumerate(one.problems)
    ]


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
    """Plan once, at most so many seconds, by the policy's planner or by `OMPL`."""
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

    def check(curves: Curves) -> tuple[Contact, Floats] | None:
        found = chain_contact(world, columns, base, curves)
        return None if found is None else found[:2]

    return searched(
        case.start,
        case.goal,
        (chain.lower, chain.upper),
        joint_weights(len(case.goal), world.policy),
        check,
        replace(world.policy, iterations=OMPL_ITERATIONS),
        world.motion,
        rng,
        world.deadline,
        planner=RRT_CONNECT,
    )


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
        made = [one for one in attempts if (one.robot, one.name) == (robot, name)]
        rows.append(
            {"set": name, "robot": robot} | figures(of, [a for a in made if a.planner == planner])
        )
    return rows


def figures(cases: Sequence[Case], attempts: Sequence[Attempt]) -> dict[str, Any]:
    """What one planner came to on these cases; see `summary`.  Times are None without attempts."""
    paths = [one.path for one in attempts if one.path is not None]
    return {
        "problems": len(cases),
        "invalid": sum(bool(case.invalid) for case in cases),
        "solved": len(paths),
        **_times("", [one.processor for one in attempts]),
        **_times("wall_", [one.seconds for one in attempts]),
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
