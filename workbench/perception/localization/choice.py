"""Which hypotheses are parts: the best first, each by pixels that no accepted part explains."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Protocol

import numpy as np
import open3d as o3d
import pinocchio as pin
from numba import njit

from workbench.model.geometry import Bools, Floats, own
from workbench.model.part import Bin, Part
from workbench.model.scan import Objection
from workbench.perception.bins.bin_fit import SeenBin, inside_by
from workbench.perception.localization.assessment import Assessment
from workbench.perception.localization.outline import LEAST_ENDS
from workbench.perception.matching.likelihood import MOST_FOR_PART, log_likelihood_ratio
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.sightings import Sighting, look
from workbench.perception.parts.part_surface import PartSurface
from workbench.perception.views.motions import motion_of, moved

LEAST_VISIBLE = 0.3
"""Less of the facing surface than this cannot tell a part from a chance likeness."""

PLAUSIBLE = 0.75
"""Of what is seen in the part's place, the part must explain this share to be checked closely."""

HOPELESS = -0.6
"""[nat] A log likelihood ratio below which a close look mends nothing.  Of 520 that were taken in
simulated and real scans, none had less than -0.31 before it."""

LEAST_PIXELS = 40

DEEP, MOST_DEEP = 0.03, 0.02
"""At most a share `MOST_DEEP` of a part's surface may be inside another part, or the bin, by more
than `DEEP` times the diameter."""

SAME_PLACE = 0.15
"""Parts whose middles are closer than this share of the diameter are one place."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A pose (4, 4) [m] of the part in the scanner's frame, and what it predicts and explains."""

    pose: Floats
    sighting: Sighting

    def __post_init__(self) -> None:
        own(self, "pose")


@dataclass(frozen=True, slots=True, eq=False)
class Rejection:
    """A hypothesis that was not taken, why, and the place of the chosen one that it lost to.

    `pose` (4, 4) [m] is in the scanner's frame.
    """

    pose: Floats
    sighting: Sighting
    reason: Objection
    rival: int | None = None

    def __post_init__(self) -> None:
        own(self, "pose")


@dataclass(slots=True)
class Choice:
    """Accepted parts in that order, and rejected hypotheses; grows while it is made.

    `claimed` (pixels,): index of the last accepted part that explains a pixel, or -1.
    """

    claimed: np.ndarray
    chosen: list[Assessment]
    rejected: list[Rejection]

    @classmethod
    def empty(cls, depth_map: DepthMap) -> "Choice":
        """The choice in a scan before anything is accepted."""
        return cls(np.full(depth_map.depth.size, -1), [], [])

    @property
    def poses(self) -> Floats:
        """The poses (k, 4, 4) [m] of accepted parts, then of rejected hypotheses."""
        poses = [each.pose for each in (*self.chosen, *self.rejected)]
        return np.array(poses).reshape(-1, 4, 4)


class AreInside(Protocol):
    """Says which poses may be at all."""

    def __call__(self, surface: PartSurface, poses: Floats, *, tolerance: float) -> Bools:
        """Of poses (k, 4, 4) [m] of a surface, known to a tolerance [m], which may be (k,)."""
        ...


@dataclass(frozen=True, slots=True, eq=False)
class PartSearch:
    """The state of the search for one kind of part: depth maps, tolerances, accepted poses.

    `depth_map` is the scan as an image for this part, `coarse_map` the same with fewer pixels;
    `tolerance` [m] see `sightings.look`, `spread` [m] see `likelihood`.  `least_ends` see
    `outline.has_visible_boundary`, `most` [nat] see `likelihood`; `is_loose` says that they are
    those of `loosening`; `filled` see `scene_model.SceneModel`; `eaten` [pixels] of outlines that
    the background eats, see `eaten`.  `heights` are those of points (n, 3) [m] in the scanner's
    frame over the floor (n,) [m], None where that is not seen.  The surface is `grown` by so much
    [m] over the CAD file, or `scaled`, no unit.
    """

    part: Part
    surface: PartSurface
    depth_map: DepthMap
    coarse_map: DepthMap
    tolerance: float
    spread: float
    are_inside: AreInside
    choice: Choice
    least_ends: float = LEAST_ENDS
    most: float = MOST_FOR_PART
    is_loose: bool = False
    filled: float = 1.0
    eaten: int = 0
    heights: Callable[[Floats], Floats] | None = None
    grown: float = 0.0
    scaled: float = 1.0

    def look(self, pose: Floats) -> Sighting:
        """What the scan shows of the part at a pose (4, 4) [m]."""
        return look(self.depth_map, self.surface, pose, self.tolerance)

    def hypothesis(self, pose: Floats) -> Hypothesis:
        """A hypothesis at a pose (4, 4) [m]."""
        return Hypothesis(pose, self.look(pose))

    @property
    def are_possible(self) -> Callable[[Floats], Bools]:
        """Which poses (k, 4, 4) of the part may be at all, (k,)."""
        tolerance = self.tolerance if self.is_loose else 0.0
        return partial(self.are_inside, self.surface, tolerance=tolerance)


Compete = Callable[[Sequence[PartSearch], Sequence[list[Hypothesis]]], None]
"""Accepts the hypotheses of each kind that hold together."""


def are_in_bin(
    surface: PartSurface,
    poses: Floats,
    T_scanner_bin: pin.SE3,
    bin: Bin,
    seen: SeenBin,
    *,
    tolerance: float = 0.0,
) -> np.ndarray:
    """Which poses (k, 4, 4) [m] do not reach through floor or walls; they may stick out above.

    Poses are known to `tolerance` [m] only.
    """
    points = surface.table.model.points
    # What lies far from the middle reaches out first: then few points have to be moved.
    distances = np.sum((points - surface.middle) ** 2, axis=1)
    return _are_in_bin(
        np.ascontiguousarray(T_scanner_bin.inverse().homogeneous),
        np.array(poses, order="C"),
        points[np.argsort(-distances, kind="stable")],
        bin.size,
        seen.floor,
        seen.walls,
        max(DEEP * surface.diameter, tolerance),
    )


@njit(cache=True)
def _are_in_bin(
    T_bin_scanner: Floats,
    poses: Floats,
    points: Floats,
    size: Floats,
    floor: Floats,
    walls: Floats,
    allowed: float,
) -> Bools:  # pragma: no cover (compiled)
    inside = np.empty(len(poses), np.bool_)
    for k in range(len(poses)):
        motion = motion_of(T_bin_scanner @ poses[k])
        outside = 0
        for m in range(len(points)):
            if outside > MOST_DEEP * len(points):
                break
            x, y, z = moved(motion, (points[m, 0], points[m, 1], points[m, 2]))
            height, left = inside_by(floor, walls, size, x, y, z)
            outside += height < -allowed or (left < -allowed and height < size[2])
        inside[k] = outside <= MOST_DEEP * len(points)
    return inside


def take(
    search: PartSearch, hypothesis: Hypothesis, assess: Callable[[Hypothesis], Assessment]
) -> Assessment | None:
    """Accept a hypothesis if it holds after a close look, together with the accepted parts.

    It must explain enough of what it shows, and reach neither into an accepted part nor out of the
    bin.  The close look may have moved it there.

    Args:
        search: its choice gets the accepted part, or the rejected hypothesis.
        hypothesis: a possible pose, fitted roughly.
        assess: looks closely at a hypothesis and returns a better one.

    Returns:
        The accepted part, None if the hypothesis is rejected.
    """
    choice, found = search.choice, _examine(search, hypothesis, assess)
    if isinstance(found, Rejection):
        choice.rejected.append(found)
        return None
    choice.claimed[found.sighting.explained] = len(choice.chosen)
    choice.chosen.append(found)
    return found


def _examine(
    search: PartSearch, hypothesis: Hypothesis, assess: Callable[[Hypothesis], Assessment]
) -> Assessment | Rejection:
    """The part at a hypothesis after a close look, or why there is none."""
    rejection = _objection(search, hypothesis)
    if rejection is not None:
        return rejection
    if _ratio(search, hypothesis.sighting) < HOPELESS:
        return Rejection(hypothesis.pose, hypothesis.sighting, Objection.UNKNOWN)
    found = assess(hypothesis)
    rejection = _objection(search, found) or _overlap(search, found)
    if rejection is not None:
        return rejection
    if not search.are_possible(found.pose[None])[0]:
        return Rejection(found.pose, found.sighting, Objection.OUTSIDE)
    if not found.is_constrained:
        return Rejection(found.pose, found.sighting, Objection.NOT_HELD)
    if _ratio(search, found.sighting) < 0.0:
        return Rejection(found.pose, found.sighting, Objection.UNKNOWN)
    return found


def _ratio(search: PartSearch, sighting: Sighting) -> float:
    """The log likelihood ratio [nat] of a pose; hidden parts of the scan are unknown."""
    return log_likelihood_ratio(
        sighting,
        search.choice.claimed >= 0,
        search.spread,
        search.tolerance,
        is_all_known=False,
    )


def gain(sighting: Sighting, claimed: np.ndarray) -> float:
    """`Sighting.gain` [px] less what it explains that is `claimed` (pixels,): not -1 there."""
    return sighting.gain - float(np.count_nonzero(claimed[sighting.explained] >= 0))


def enough(seen: Sighting) -> float:
    """Pixels of a picture that must be explained, or it shows too little."""
    return max(LEAST_PIXELS, LEAST_VISIBLE * seen.shown)


def _objection(search: PartSearch, hypothesis: Hypothesis | Assessment) -> Rejection | None:
    """Why too little is explained that is not claimed, if so."""
    choice, surface, seen = search.choice, search.surface, hypothesis.sighting
    owners = choice.claimed[seen.explained]
    explained = int(np.count_nonzero(owners < 0))
    least = enough(seen)
    if len(seen.explained) < least:
        return Rejection(hypothesis.pose, seen, Objection.TOO_LITTLE)
    if len(seen.explained) < PLAUSIBLE * (len(seen.explained) + len(seen.violated)):
        return Rejection(hypothesis.pose, seen, Objection.FREE_SPACE)
    if explained < least or explained < PLAUSIBLE * (explained + len(seen.violated)):
        rival = int(np.bincount(owners[owners >= 0]).argmax())
        apart = _between(choice.chosen[rival].pose, hypothesis.pose) @ [*surface.middle, 1.0]
        is_same = np.linalg.norm(apart[:3] - surface.middle) < SAME_PLACE * surface.diameter
        return Rejection(
            hypothesis.pose, seen, Objection.TWIN if is_same else Objection.CLAIMED, rival
        )
    return None


def _overlap(search: PartSearch, assessment: Assessment) -> Rejection | None:
    """The first of the accepted parts that this one reaches into, if any."""
    surface = search.surface
    for rival, other in enumerate(search.choice.chosen):
        if reaches_into(surface, surface, _between(other.pose, assessment.pose)):
            return Rejection(assessment.pose, assessment.sighting, Objection.REACHES_INTO, rival)
    return None


def reaches_into(surface: PartSurface, host: PartSurface, T_host_part: Floats) -> bool:
    """Whether a part at a pose (4, 4) [m] is inside another one, the host, as no two parts can be.

    It is not known of a host whose mesh is open, which has no inside.
    """
    R, t = T_host_part[:3, :3], T_host_part[:3, 3]
    apart = float(np.linalg.norm(R @ surface.middle + t - host.middle))
    if not host.is_closed or apart > (surface.diameter + host.diameter) / 2:
        return False
    points = (surface.coarse.points @ R.T + t).astype(np.float32)
    most = MOST_DEEP * len(points)
    # Few points of two parts that touch are within the box around the host at all.
    low, high = host.vertices.min(axis=0), host.vertices.max(axis=0)
    points = points[((points > low) & (points < high)).all(axis=1)]
    if len(points) <= most:
        return False
    depth = host.scene.compute_signed_distance(o3d.core.Tensor(points)).numpy()
    deep = DEEP * min(surface.diameter, host.diameter)
    return int(np.count_nonzero(depth < -deep)) > most


def _between(pose: Floats, other: Floats) -> Floats:
    """The pose (4, 4) of the other part in the frame of the first."""
    return np.linalg.inv(pose) @ other
