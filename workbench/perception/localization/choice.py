"""Which hypotheses are parts: the best first, each by pixels that no accepted part explains."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import open3d as o3d
import pinocchio as pin
from numba import njit

from workbench.model.geometry import Bools, Floats, frozen, put
from workbench.model.part import Bin
from workbench.model.scan import Objection
from workbench.perception.bins.bin_fit import SeenBin, inside_by
from workbench.perception.localization.assessment import Assessment
from workbench.perception.matching.likelihood import log_likelihood_ratio
from workbench.perception.matching.sightings import Sighting
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
        put(self, pose=frozen(self.pose))


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
        put(self, pose=frozen(self.pose))


@dataclass(slots=True)
class Choice:
    """Accepted parts in that order, and rejected hypotheses; grows while it is made.

    `claimed` (pixels,): index of the last accepted part that explains a pixel, or -1.
    """

    claimed: np.ndarray
    chosen: list[Assessment]
    rejected: list[Rejection]


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
    choice: Choice,
    surface: PartSurface,
    hypothesis: Hypothesis,
    assess: Callable[[Hypothesis], Assessment],
    spread: float,
    tolerance: float,
    are_possible: Callable[[Floats], Bools],
) -> Assessment | None:
    """Take a hypothesis if it holds after a close look beside those that were taken before.

    It must explain enough of what it shows, and reach neither into a chosen one nor out of the
    bin.  The close look may have moved it there.

    Args:
        choice: what was taken before; the hypothesis is added to it, or to what was rejected.
        surface: the part.
        hypothesis: a possible pose, fitted roughly.
        assess: looks closely at a hypothesis and returns a better one.
        spread: [m] deviation of a part's points from its surface.
        tolerance: [m] see `sightings.look`.
        are_possible: which of poses (k, 4, 4) may be at all, (k,).

    Returns:
        What was taken, None if it was not.
    """

    def ratio(sighting: Sighting) -> float:
        return log_likelihood_ratio(
            sighting, choice.claimed >= 0, spread, tolerance, is_all_known=False
        )

    rejected = _objection(choice, surface, hypothesis)
    if rejected is None and ratio(hypothesis.sighting) < HOPELESS:
        rejected = Rejection(hypothesis.pose, hypothesis.sighting, Objection.UNKNOWN)
    if rejected is None:
        assessment = assess(hypothesis)
        rejected = _objection(choice, surface, assessment) or _overlap(choice, surface, assessment)
        if rejected is None and not are_possible(assessment.pose[None])[0]:
            rejected = Rejection(assessment.pose, assessment.sighting, Objection.OUTSIDE)
        if rejected is None and not assessment.is_constrained:
            rejected = Rejection(assessment.pose, assessment.sighting, Objection.NOT_HELD)
        if rejected is None and ratio(assessment.sighting) < 0.0:
            rejected = Rejection(assessment.pose, assessment.sighting, Objection.UNKNOWN)
        if rejected is None:
            choice.claimed[assessment.sighting.explained] = len(choice.chosen)
            choice.chosen.append(assessment)
            return assessment
    choice.rejected.append(rejected)
    return None


def gain(sighting: Sighting, claimed: np.ndarray) -> float:
    """`Sighting.gain` [px] less what it explains that is `claimed` (pixels,): not -1 there."""
    return sighting.gain - float(np.count_nonzero(claimed[sighting.explained] >= 0))


def enough(seen: Sighting) -> float:
    """Pixels of a picture that must be explained, or it shows too little."""
    return max(LEAST_PIXELS, LEAST_VISIBLE * seen.shown)


def _objection(
    choice: Choice, surface: PartSurface, hypothesis: Hypothesis | Assessment
) -> Rejection | None:
    """Why too little is explained that is not claimed, if so."""
    seen = hypothesis.sighting
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


def _overlap(choice: Choice, surface: PartSurface, assessment: Assessment) -> Rejection | None:
    """The first of the chosen parts that this one reaches into, if any."""
    for rival, other in enumerate(choice.chosen):
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
