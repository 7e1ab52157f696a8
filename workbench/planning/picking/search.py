"""One free motion: searched by a planner, shortened, rounded, checked as it is run."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Policy
from workbench.model.geometry import Floats, Ints
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.motion import MotionModel
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.motion import Curves, bound_curves, chain_contact, segment
from workbench.planning.collision.sweeping.edges import Edges
from workbench.planning.collision.world import World
from workbench.planning.kinematics.quickness import Pace
from workbench.planning.kinematics.upright import Uprightness
from workbench.planning.planners.asking import CompiledCheck
from workbench.planning.planners.clock import processor_time
from workbench.planning.planners.ease import ease_corners
from workbench.planning.planners.projected import projected_planner
from workbench.planning.planners.shorten import (
    merge_corners,
    resample,
    shorten_path,
    skip_waypoints,
)
from workbench.plugins.planner import EdgeCheck, Planner, planner_named

LAST_RESOLUTION = 0.0001
"""[m] The resolution of the last look at a path, whose corners have been moved up to what they
would touch: five times finer than that of the proof, which looks at other configurations."""

PATHS_TRIED = 3
"""Free paths searched before giving up: rounding to the wire and the corners may spoil one."""


def joint_weights(count: int, policy: Policy) -> Floats:
    """How much each joint of an arm counts in the metric: (count,), no unit."""
    weights: Floats = np.power(policy.metric, np.arange(count, dtype=np.float64))
    return weights * math.sqrt(count / float(weights @ weights))


Check = Callable[[Curves], tuple[Contact | None, Floats] | None]
"""Whether a motion is clear, None; or what is met, and where; nothing where a part is tilted."""


@dataclass(frozen=True, slots=True, eq=False)
class PathQuery:
    """In what a free path of n joints is searched, and how it will be run.

    Attributes:
        check: what a motion meets.
        limits: of the joints, two (n,) [rad].
        weights: (n,) of the joints in the metric.
        policy: planner, its iterations, waypoints and corners.
        motion: how the controller runs a path.
        deadline: [s] on the clock of `processor_time`; it ends the search, in compiled code within
            some hundred edges.
        edges: answer for straight motions what `check` would, where they are known.
        pace: of the joints; the path is made quicker by it, where it is known.
        planner: instead of the planner of the policy.
        upright: what keeps parts upright that are carried.
    """

    check: Check
    limits: tuple[Floats, Floats]
    weights: Floats
    policy: Policy
    motion: MotionModel
    deadline: float = math.inf
    edges: Edges | None = None
    pace: Pace | None = None
    planner: Planner | None = None
    upright: Uprightness | None = None

    def keeping_upright(self) -> "PathQuery":
        """The same, in which a motion that tilts a part too far is not clear."""
        upright, check = self.upright, self.check
        if upright is None:
            return self

        def check_both(curves: Curves) -> tuple[Contact | None, Floats] | None:
            tilted = upright.find_tilted(curves.points)
            return check(curves) if tilted is None else (None, tilted)

        planner = projected_planner(upright.project)
        return replace(self, check=check_both, edges=None, planner=planner, upright=None)


def search_path(
    query: PathQuery,
    start: Floats,
    goal: Floats,
    rng: np.random.Generator,
    before: Floats | None = None,
) -> Floats | Verdict:
    """A path between two clear configurations (n,), rounded and checked as it will be run.

    Args:
        query: in what it is searched.
        start: where it begins (n,) [rad].
        goal: where it ends (n,) [rad].
        rng: of everything random.
        before: the waypoint (n,) from which the arm comes to the start: the corner there belongs
            to what is checked.  Without it the arm begins at the start.

    Returns:
        Waypoints (m, n) [rad]; or why there are none, with what was met last.
    """
    query = query.keeping_upright()
    policy, motion = query.policy, query.motion
    is_clear = edge_check(query.check, query.deadline, query.edges)
    met: tuple[Contact | None, Floats] | None = None
    try:
        for number in range(PATHS_TRIED + 1):
            path = np.array([start, goal])  # straight ahead first
            if number:
                search = query.planner or planner_named(policy.planner)
                path = search(
                    start,
                    goal,
                    *query.limits,
                    query.weights,
                    is_clear,
                    iterations=policy.iterations,
                    rng=rng,
                ).path
            if path is None:
                break
            for sent in _forms(path, is_clear, policy, motion, query.pace):
                met = query.check(_walked_from(before, sent, motion, policy.zone))
                if met is None:
                    return sent
    except _Late:
        return Verdict(Reason.OUT_OF_TIME, Stage.ROUTE)
    if met is None:
        return Verdict(Reason.NO_PATH, Stage.ROUTE)
    contact, q = met
    if contact is None:
        return Verdict(Reason.NO_PATH, Stage.ROUTE, q=q, note=VerdictNote.WOULD_TILT())
    return contact.refuse(Reason.NO_PATH, Stage.ROUTE, q)


def onward(
    query: PathQuery, lead: Floats, goal: Floats, rng: np.random.Generator
) -> Floats | Verdict:
    """A path beginning with `lead` (k, n) [rad], from its last waypoint on; see `search_path`.

    All of it has as many waypoints as other paths, or as many as it needs.
    """
    count = len(lead) - 1
    before = lead[-2] if count else None
    fewer = replace(query.policy, free_points=max(2, query.policy.free_points - count))
    path = search_path(replace(query, policy=fewer), lead[-1], goal, rng, before)
    return path if isinstance(path, Verdict) else np.vstack([lead[:-1], path])


def _walked_from(before: Floats | None, path: Floats, motion: MotionModel, zone: float) -> Curves:
    """All curves of a path, with the corner at its start where it comes from `before`."""
    if before is None:
        return bound_curves(path, motion, zone)
    curves = bound_curves(np.vstack([before, path]), motion, zone)
    return Curves(curves.points[1:], curves.waypoints[1:])


class _Late(Exception):
    """The deadline has passed; raised through the planners, which know nothing of it."""


def curve_check(world: World, columns: Ints, base: Floats) -> Check:
    """Whether motions of the joints `columns` (n,) are clear, others at `base` (nq,) [rad, m]."""

    def check(curves: Curves) -> tuple[Contact | None, Floats] | None:
        found = chain_contact(world, columns, base, curves, LAST_RESOLUTION)
        return None if found is None else found[:2]

    return check


def edge_check(
    check: Check, deadline: float = math.inf, edges: Edges | None = None
) -> CompiledCheck:
    """Whether one straight joint motion is clear, by a check of whole motions, or by `edges`."""

    def on_time() -> None:
        if processor_time() > deadline:
            raise _Late

    def is_clear(a: Floats, b: Floats) -> bool:
        on_time()
        return check(segment(a, b)) is None

    return CompiledCheck(is_clear, on_time, edges)


def _forms(
    path: Floats, is_clear: EdgeCheck, policy: Policy, motion: MotionModel, pace: Pace | None
) -> Iterator[Floats]:
    """A path (m, n) [rad] in the forms in which it may be sent, the quickest first.

    With its corners where it takes less time, and nothing between them, so that they are rounded
    widely; then with corners cut and narrow, which touch less.  Where it is streamed, wide corners
    might be cut by half of what is beside them.
    """
    if len(path) > 2 and pace is not None:
        limits = pace.velocity, pace.acceleration
        quick = ease_corners(skip_waypoints(path, is_clear), is_clear, *limits, policy.zone)
        if len(quick) > 2 and motion.corners != "streamed":
            yield _round(quick, motion)
        yield as_sent(quick, is_clear, policy.free_points, motion)
    yield as_sent(path, is_clear, policy.free_points, motion)


def as_sent(path: Floats, is_clear: EdgeCheck, count: int, motion: MotionModel) -> Floats:
    """A path (m, n) [rad] shortened, divided into `count` waypoints or what it needs, rounded."""
    path = merge_corners(shorten_path(path, is_clear, most=count), is_clear)
    return _round(resample(path, count), motion)


def _round(path: Floats, motion: MotionModel) -> Floats:
    """A path (m, n) [rad] as the wire carries it.

    Waypoints that rounding makes equal become one.  A path that ends where it starts keeps two.
    """
    path = motion.rounded(path)
    moves = np.any(np.diff(path, axis=0) != 0, axis=1)
    return path[np.concatenate([[True], moves])] if moves.any() else path[[0, -1]]
