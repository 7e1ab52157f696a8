"""However a part lies in the bin: which of its grasps can take it, and where none can.

The part is put into the bin in orientations spread evenly, at some places, alone.  A grasp works
there when the tool by itself fits between the walls, on arrival and as closed, and the arm reaches
it; whether the arm's links are clear, and a path leads there, is for planning to say.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Tool
from workbench.model.derived.by_tcp import by_each_tcp
from workbench.model.geometry import Bools, Floats, own, spread_directions
from workbench.model.messages.message import Message
from workbench.model.messages.work import ProgressText
from workbench.model.part import Grasp, Part, widen_grasp
from workbench.planning.grasps.grasp_suggestions import Suggestion, suggest
from workbench.planning.grasps.grasp_trial import Trial
from workbench.planning.grasps.part_rays import NO_TRIANGLE, first_hits, normals_of
from workbench.planning.grasps.resting import ways_to_lie
from workbench.planning.kinematics.quickness import tool_acceleration

UP_DIRECTIONS = 60
"""Of the part that point up, spread over the sphere."""

VERTICAL_TURNS = 4
"""Of the part about the vertical, for each of them."""

PLACES = ((0.0, 0.0), (-0.25, -0.25), (0.25, 0.25))
"""In the bin, as shares of its length and width from the middle."""

REGION = np.deg2rad(35.0)
"""Directions this near belong to one region of the sphere."""


@dataclass(frozen=True, slots=True, eq=False)
class MissingGrasp:
    """Where a part cannot be taken, and what would help.

    `direction` (3,) of the part points up there; `share` of the poses around it in which some grasp
    works.  The ray down along it meets the part at `point` (3,) [m], on a face with `normal` (3,).
    `suggestion` is a grasp that would work in `would_work` of those poses, None if none was found.
    """

    direction: Floats
    share: float
    point: Floats
    normal: Floats
    suggestion: Suggestion | None
    arm: str
    would_work: float

    def __post_init__(self) -> None:
        own(self, "direction", "point", "normal")


@dataclass(frozen=True, slots=True, eq=False)
class Coverage:
    """What the grasps of a part can do in a cell.

    `directions` (n, 3): unit vectors of the part, pointing up; `shares` (n,) of the poses with that
    direction up in which any grasp works with any arm, `arm_shares` (n, a) with each arm.
    `grasp_shares` (g, a): of all poses, for each grasp of the library and arm.  `poses` is how many
    were checked; fewer when the search was ended.  `lying_share` is that of the ways in which a
    part comes to lie on the floor by itself, each by how often it does; None where that is unknown.
    """

    part: str
    arms: tuple[str, ...]
    grasps: tuple[str, ...]
    directions: Floats
    shares: Floats
    arm_shares: Floats
    grasp_shares: Floats
    poses: int
    missing: MissingGrasp | None
    lying_share: float | None = None

    def __post_init__(self) -> None:
        own(self, "directions", "shares", "arm_shares", "grasp_shares")

    @property
    def share(self) -> float:
        """Of all poses, those in which some grasp works."""
        return float(self.shares.mean()) if len(self.shares) else 0.0


def coverage(
    cell: Cell,
    part: Part,
    *,
    directions: int = UP_DIRECTIONS,
    turns: int = VERTICAL_TURNS,
    places: tuple[tuple[float, float], ...] = PLACES,
    advise: bool = True,
    report: Callable[[float, Message], None] = lambda done, note: None,
    cancelled: Callable[[], bool] = lambda: False,
) -> Coverage:
    """Try every grasp of a part in orientations spread evenly.

    Args:
        cell: whose bin and arms are used; the part need not be one of its parts.
        part: with its grasps.
        directions: of the part that point up.
        turns: about the vertical, for each direction.
        places: in the bin, as shares of its length and width from the middle.
        advise: look for a grasp that would help where fewest work.
        report: takes the share done and what is being done.
        cancelled: True ends the search with what is known by then.
    """
    ups = spread_directions(directions)
    trials = [Trial(each, part) for each in by_each_tcp(cell)]
    trial = trials[0]
    grasps = part.library.grasps
    arriving = tuple(widen_grasp(grasp, part.tolerance) for grasp in grasps)
    usable = [each.usable(grasps) for each in trials]
    poses = [trial.poses(up, k, turns, places) for k, up in enumerate(ups)]
    # (directions, poses of each, grasps, arms)
    works = np.zeros((len(ups), turns * len(places), len(grasps), len(cell.arms)), bool)
    seen = np.zeros(len(ups), bool)
    # In an order that jumps about, so that what is known early covers the sphere.
    for done, k in enumerate(np.argsort(np.arange(len(ups)) * 0.6180339887 % 1.0).tolist()):
        if cancelled():
            break
        report(0.9 * done / len(ups), ProgressText.DIRECTIONS(done=done, count=len(ups)))
        works[k] = _works(trials, poses[k], arriving, usable)
        seen[k] = True
    works, ups = works[seen], ups[seen]
    any_arm = np.any(works, axis=2)
    shares = np.any(any_arm, axis=2).mean(axis=1) if len(ups) else np.empty(0)
    lying = _lying_share(trials, arriving, usable, turns, places, cancelled) if len(ups) else None
    missing = None
    if advise and len(ups) and not cancelled():
        report(0.9, ProgressText.WHAT_TO_ADD())
        missing = _missing(trial, ups, shares, [poses[k] for k in np.flatnonzero(seen)], cancelled)
    return Coverage(
        part.name,
        tuple(arm.name for arm in cell.arms),
        tuple(grasp.name for grasp in grasps),
        ups,
        shares,
        any_arm.mean(axis=1) if len(ups) else np.empty((0, len(cell.arms))),
        works.mean(axis=(0, 1)) if len(ups) else np.zeros(works.shape[2:]),
        int(seen.sum()) * turns * len(places),
        missing,
        lying,
    )


def _works(
    trials: Sequence[Trial],
    poses: Sequence[pin.SE3],
    grasps: Sequence[Grasp],
    usable: Sequence[Bools],
) -> Bools:
    """True (p, g, a) where a grasp works with an arm by any TCP of its tool; see `Trial.works`."""
    pairs = zip(trials, usable, strict=True)
    return np.any([trial.works(poses, grasps, able) for trial, able in pairs], axis=0)


def _lying_share(
    trials: Sequence[Trial],
    grasps: tuple[Grasp, ...],
    usable: Sequence[Bools],
    turns: int,
    places: tuple[tuple[float, float], ...],
    cancelled: Callable[[], bool],
) -> float | None:
    """The share of the ways to lie in which some grasp works; None where it is not known."""
    trial = trials[0]
    ups, often = ways_to_lie(trial.part)
    share = 0.0
    for k, (up, frequency) in enumerate(zip(ups, often, strict=True)):
        if cancelled():
            return None
        works = _works(trials, trial.poses(up, k, turns, places), grasps, usable)
        share += float(frequency) * float(works.any(axis=(1, 2)).mean())
    return share


def rank_for_bin(
    cell: Cell, part: Part, tool: Tool, found: Sequence[Suggestion]
) -> tuple[tuple[Suggestion, float], ...]:
    """Suggestions by what the bin admits, the most useful first.

    Args:
        cell: whose bin and arms are used.
        part: that the suggestions are for, with its tolerance.
        tool: that the suggestions are for; arms with it are tried.
        found: the suggestions, which stay in their order where they are equally useful.

    Returns:
        Each with its share, 0 to 1, of the ways in which the part comes to lie in the bin.  Hand
        and arm fit there, see `Trial.works`; the part lies at three places, turned four ways.
    """
    if not found:
        return ()
    trials = [Trial(each, part) for each in by_each_tcp(cell)]
    grasps = tuple(widen_grasp(suggestion.grasp, part.tolerance) for suggestion in found)
    carries = np.array([arm.tool.name == tool.name for arm in cell.arms])
    usable = [each.usable(grasps) & carries for each in trials]
    shares = np.zeros(len(found))
    for k, (up, frequency) in enumerate(zip(*ways_to_lie(part), strict=True)):
        poses = trials[0].poses(up, k, VERTICAL_TURNS, PLACES)
        works = _works(trials, poses, grasps, usable)
        shares += float(frequency) * works.any(axis=2).mean(axis=0)
    order = np.argsort(-np.round(shares, 6), kind="stable").tolist()
    return tuple((found[number], float(shares[number])) for number in order)


def _missing(
    trial: Trial,
    ups: Floats,
    shares: Floats,
    poses: list[list[pin.SE3]],
    cancelled: Callable[[], bool],
) -> MissingGrasp | None:
    """The region in which fewest grasps work, and what would; None when all poses work."""
    near = ups @ ups.T > np.cos(REGION)
    around = (near @ shares) / near.sum(axis=1)
    worst = int(np.argmin(np.round(around, 6)))
    if around[worst] >= 1.0 - 1e-9:
        return None
    up = ups[worst]
    point, normal = _top(trial.part, up)
    wanting = np.flatnonzero(near[worst] & (shares < 1.0 - 1e-9))
    there = [T for k in wanting.tolist() for T in poses[k]]
    best, arm_name, best_share = _best_suggestion(trial, up, there, cancelled)
    return MissingGrasp(up, float(around[worst]), point, normal, best, arm_name, best_share)


def _top(part: Part, up: Floats) -> tuple[Floats, Floats]:
    """What points up: where a ray down through the middle meets the part, and the normal there."""
    middle = (part.mesh.points.min(axis=0) + part.mesh.points.max(axis=0)) / 2
    far = 2 * float(np.linalg.norm(np.ptp(part.mesh.points, axis=0)))
    start = middle + far * up
    distances, met = first_hits(part.mesh, start[None], -up[None])
    if met[0] == NO_TRIANGLE:
        # Through a gap or beside: the face that shows most of itself instead.
        normals, areas = normals_of(part.mesh)
        most = int(np.argmax(areas * (normals @ up)))
        return part.mesh.points[part.mesh.triangles[most]].mean(axis=0), normals[most]
    return start - distances[0] * up, normals_of(part.mesh)[0][met[0]]


SUGGESTIONS_TRIED = 12
"""Suggestions that are tried where a grasp is missing."""


def _best_suggestion(
    trial: Trial, up: Floats, poses: list[pin.SE3], cancelled: Callable[[], bool]
) -> tuple[Suggestion | None, str, float]:
    """The suggestion that works in most of the poses, with which arm, and in which share."""
    best: tuple[Suggestion | None, str, float] = (None, "", 0.0)
    of_tool: dict[str, tuple[Suggestion, ...]] = {}
    for a, arm in enumerate(trial.cell.arms):
        if arm.tool.name not in of_tool:
            of_tool[arm.tool.name] = suggest(
                trial.part,
                arm.tool,
                most=60,
                acceleration=tool_acceleration(trial.cell, arm.tool),
            )
        found = sorted(
            of_tool[arm.tool.name],
            key=lambda suggestion: float(suggestion.grasp.T_part_tcp.rotation[:, 2] @ up),
        )
        for suggestion in found[:SUGGESTIONS_TRIED]:
            if cancelled():
                return best
            usable = np.arange(len(trial.cell.arms))[None] == a
            share = float(trial.works(poses, (suggestion.grasp,), usable)[:, 0, a].mean())
            if share > best[2] + 1e-9:
                best = (suggestion, arm.name, share)
    return best
