"""The pose of one known part near a believed one: fitted, judged, with its covariance.

The tools are those of localization without the vote: a depth map of what is around the believed
pose, projective ICP from several poses near it, and the dense fit.  The scan is compared pixel by
pixel with what the part predicts.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.by_view import scans_by_view
from workbench.model.geometry import Floats
from workbench.model.part import Bin, Part
from workbench.model.recipes.seen_base import (
    MOST_RISE,
    MOST_SHIFT,
    MOST_TURN,
    SeenBase,
    SightProblem,
)
from workbench.model.scan import Scan
from workbench.model.symmetry import BALL, ROUND
from workbench.perception.bins.bin_fit import OPEN, SeenBin
from workbench.perception.localization.assessment import ROLL_ERROR, refine_at_full_resolution
from workbench.perception.localization.certainty import count_shared, covariance
from workbench.perception.localization.choice import PLAUSIBLE, enough
from workbench.perception.localization.localize import (
    EXPLAINED_SHARE,
    LEAST_SPREAD,
    PIXELS_ACROSS,
    SPREAD_OVER_NOISE,
    TOLERANCE_OVER_NOISE,
)
from workbench.perception.localization.outline import has_visible_boundary
from workbench.perception.localization.settling import is_constrained, refine_poses, roll_error
from workbench.perception.matching.likelihood import (
    CLOSE_AHEAD,
    CLOSE_IN_FRONT,
    ODD,
    log_likelihood_ratio,
)
from workbench.perception.matching.maps import DepthMap, make_map
from workbench.perception.matching.registration import refine
from workbench.perception.matching.sightings import Sighting, closeness, look, tally
from workbench.perception.parts.part_surface import PartSurface, prepare
from workbench.perception.scene.sensor import sensor_model

BEHIND = 0.4
"""[m] Up to this far behind the part, what is measured shows that nothing hides it."""

BEGUN = (-0.8, 0.0, 0.8)
"""Shifts over the bound at which fits begin, along each axis of the scanner."""

WIDEST_GATES = np.array([1.5, 1.5, 1.0, 1.0, 0.6, 0.4])
"""Largest distances of pairs in the iterations of the first fit, over the bound."""

FOLLOWED = 6
"""Fits that are followed, the best first."""

STEP_LENGTHS = (0.06, 0.03, 0.015)
"""Lengths of the steps by which they are brought to rest, over the diameter."""

LEAST_MEASURED = 0.1
"""A part of whose picture less than this share is measured is not in view."""

FIT_SHIFT, FIT_TURN = 0.00025, float(np.deg2rad(0.25))
"""[m, rad] Deviations of a fit, and of a view among others, beyond what covariances state."""

LEAST_ALIKE = 28.0
"""Squared distance over variance of two views of the same pose: of ten thousand such pairs one has
more, by chi squared with six degrees of freedom."""

MOSTLY = 0.5
"""A share of the picture through which the scan looks: the part is gone."""

AGAINST = frozenset(
    {SightProblem.GONE, SightProblem.OTHER, SightProblem.TOO_FAR, SightProblem.OFF_HEIGHT}
)
"""What speaks against a part in one view, whatever others show."""


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """One view of what is around a part: its depth map, and how exactly it is measured.

    `tolerance` [m] see `sightings.look`, `spread` [m] see `likelihood`.
    """

    scan: Scan
    depth_map: DepthMap
    surface: PartSurface
    tolerance: float
    spread: float

    def look(self, pose: Floats) -> Sighting:
        return look(self.depth_map, self.surface, pose, self.tolerance)


def find_standing(scan: Scan, cell: Cell, part: Part, T_world_part: pin.SE3) -> SeenBase:
    """Where a scan shows a part that is believed to stand somewhere.

    It is taken for the same part up to `MOST_SHIFT`, `MOST_RISE` and `MOST_TURN` off.  Turns that
    leave the part as it is, or that the scan does not show, stay as believed.  The same scan and
    pose bring the same result.

    Args:
        scan: organised or not; of a merged one each view counts.
        cell: its scanner says how noisy the points are, if the scan does not.
        part: of a kind that the cell knows.
        T_world_part: where it is believed to stand.

    Raises:
        InputError: the part's mesh has no surface.
    """
    views = scans_by_view(scan)
    found = [_in_view(view, cell, part, T_world_part) for view in views]
    # What one view hides another one may show, but none may speak against the part.
    best = max(found, key=lambda seen: (seen.problem in AGAINST, not seen.problem, seen.visible))
    if best.problem is None and not _are_alike([seen for seen in found if not seen.problem]):
        return SeenBase(scan.digest, visible=best.visible, problem=SightProblem.MOVED)
    return replace(best, scan=scan.digest)


def _are_alike(found: Sequence[SeenBase]) -> bool:
    """Whether all views show a part at one pose, as far as each states its own."""
    floor = np.diag(np.square([FIT_SHIFT] * 3 + [FIT_TURN] * 3))
    for one, other in combinations(found, 2):
        T, U = one.T_world_part, other.T_world_part
        assert T is not None and U is not None
        assert one.covariance is not None and other.covariance is not None
        off = np.append(U.translation - T.translation, pin.log3(U.rotation @ T.rotation.T))
        variance = one.covariance + other.covariance + 2 * floor
        if off @ np.linalg.solve(variance, off) > LEAST_ALIKE:
            return False
    return True


def _in_view(scan: Scan, cell: Cell, part: Part, T_world_part: pin.SE3) -> SeenBase:
    """The same of one view."""
    view = _view_of(scan, cell, part, T_world_part)
    believed = scan.T_world_scanner.actInv(T_world_part).homogeneous
    seen = None if view is None else view.look(believed)
    if view is None or seen is None or _measure(seen) < LEAST_MEASURED * max(seen.shown, 1):
        return SeenBase(scan.digest, problem=SightProblem.NOT_IN_VIEW)
    pose = _fit(view, believed)
    problem, sighting = _problem(view, pose), view.look(pose)
    if problem is not None:
        if problem is not SightProblem.TOO_LITTLE and len(seen.violated) > MOSTLY * seen.shown:
            problem = SightProblem.GONE
        return SeenBase(scan.digest, visible=sighting.visible, problem=problem)
    pose = _nearest_alike(view.surface, pose, believed)
    pose = _with_believed_turn(view, part, pose, believed)
    sighting = view.look(pose)
    shift, turn = _off(view.surface, pose, believed)
    if shift > MOST_SHIFT or turn > MOST_TURN:
        visible, far = sighting.visible, SightProblem.TOO_FAR
        return SeenBase(scan.digest, None, None, shift, turn, visible, far)
    if abs(_rise(scan, view.surface, pose, believed)) > MOST_RISE:
        visible, high = sighting.visible, SightProblem.OFF_HEIGHT
        return SeenBase(scan.digest, None, None, shift, turn, visible, high)
    axes = np.kron(np.eye(2), scan.T_world_scanner.rotation)
    known = covariance(view.depth_map, view.surface, pose, sighting, view.tolerance)
    T_seen = scan.T_world_scanner * pin.SE3(pose)
    return SeenBase(scan.digest, T_seen, axes @ known @ axes.T, shift, turn, sighting.visible)


def _view_of(scan: Scan, cell: Cell, part: Part, T_world_part: pin.SE3) -> _View | None:
    """A map of what is around a part and behind it; None where nothing is measured there."""
    surface = prepare(part)
    middle = T_world_part.act(surface.middle)
    eye = scan.T_world_scanner.translation
    distance = float(np.linalg.norm(eye - middle))
    towards = (eye - middle) / distance
    R = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), towards).matrix()
    width = surface.diameter + 4 * MOST_SHIFT
    size = np.array([width, width, BEHIND + surface.diameter / 2 + MOST_SHIFT])
    box = Bin(pin.SE3(R, middle - BEHIND * towards), size, has_walls=False)
    noise = sensor_model(scan.points).deviation(distance, otherwise=cell.scanner.depth_noise)
    # Nothing of this box is a floor: what lies beneath the part is measured like anything else.
    floor, walls = np.zeros(6), np.tile((OPEN, 0.0, 0.0), (4, 1))
    open_box = SeenBin(floor, walls, noise, 0.0, np.ones(4))
    pitch = surface.diameter / PIXELS_ACROSS
    pitch_behind = pitch * (distance + BEHIND) / distance
    depth_map = make_map(scan, box, open_box, size=surface.diameter, pitch=pitch_behind)
    if depth_map is None:
        return None
    depth_map = replace(depth_map, pitch=distance / depth_map.camera.focal)
    tolerance = max(EXPLAINED_SHARE * surface.diameter, TOLERANCE_OVER_NOISE * noise)
    spread = max(SPREAD_OVER_NOISE * noise, LEAST_SPREAD * tolerance)
    return _View(scan, depth_map, surface, tolerance, spread)


def _measure(sighting: Sighting) -> int:
    """Pixels of a part's picture in which something is measured."""
    ahead = int(np.count_nonzero(~np.isnan(sighting.ahead)))
    return len(sighting.explained) + len(sighting.violated) + ahead


def _fit(view: _View, believed: Floats) -> Floats:
    """The pose (4, 4) [m] in the scanner's frame that is seen best near a believed one."""
    shifts = MOST_SHIFT * np.stack(np.meshgrid(BEGUN, BEGUN, BEGUN), axis=-1).reshape(-1, 3)
    begun = np.tile(believed, (len(shifts), 1, 1))
    begun[:, :3, 3] += shifts
    depth_map, surface, tolerance = view.depth_map, view.surface, view.tolerance
    fitted, errors = refine(depth_map, begun, surface.coarse, WIDEST_GATES * MOST_SHIFT)
    tried = np.concatenate([believed[None], fitted[np.isfinite(errors)], begun])
    seen = closeness(tally(depth_map, surface, tried, 2 * tolerance))
    best = tried[np.argsort(-seen, kind="stable")[:FOLLOWED]]
    steps = tuple(step * surface.diameter for step in STEP_LENGTHS)
    rested = refine_poses(depth_map, surface, best, 2 * tolerance, steps)
    rested = refine_at_full_resolution(depth_map, surface, rested, tolerance)
    return rested[int(np.argmax(closeness(tally(depth_map, surface, rested, tolerance))))]


def _problem(view: _View, pose: Floats) -> SightProblem | None:
    """What speaks against a part at a pose (4, 4) [m]; None where nothing does."""
    sighting = view.look(pose)
    explained, violated = len(sighting.explained), len(sighting.violated)
    if explained < enough(sighting):
        # What is close to the part's surface hides it as something in its place does.
        is_hidden = _far_ahead(view, sighting) >= sighting.shown / 2
        return SightProblem.TOO_LITTLE if is_hidden else SightProblem.OTHER
    if explained < PLAUSIBLE * (explained + violated) or _likeness(view, sighting) < 0.0:
        return SightProblem.OTHER
    nothing = np.zeros(view.depth_map.depth.size, np.bool_)
    is_whole = has_visible_boundary(
        view.depth_map, view.surface, pose, view.tolerance, nothing, most_bent=1.0
    )
    if not is_whole:
        return SightProblem.OTHER
    is_held = is_constrained(view.depth_map, view.surface, pose, view.tolerance)
    return None if is_held else SightProblem.TOO_LITTLE


def _likeness(view: _View, sighting: Sighting) -> float:
    """What speaks for the part [nat], a pixel of it in the mean; see `likelihood`.

    What hides it from afar says nothing: nobody knows what that is.
    """
    nothing = np.zeros(view.depth_map.depth.size, np.bool_)
    ratio = log_likelihood_ratio(sighting, nothing, view.spread, view.tolerance, is_all_known=False)
    ahead = sighting.ahead[~np.isnan(sighting.ahead)]
    close = np.count_nonzero((ahead > view.tolerance) & (ahead <= CLOSE_IN_FRONT * view.tolerance))
    odd = np.count_nonzero(ahead <= view.tolerance)
    return ratio - float(CLOSE_AHEAD * close + ODD * odd) / len(sighting.explained)


def _far_ahead(view: _View, sighting: Sighting) -> int:
    """Pixels in which something far in front hides the part, or nothing is measured."""
    return int(np.count_nonzero(~(sighting.ahead <= CLOSE_IN_FRONT * view.tolerance)))


def _nearest_alike(surface: PartSurface, pose: Floats, believed: Floats) -> Floats:
    """Of poses (4, 4) [m] that the part's stated symmetry makes alike, the least turned one."""
    alike = pose @ surface.stated
    traces = np.einsum("ji,kji->k", believed[:3, :3], alike[:, :3, :3])
    return alike[int(np.argmax(traces))]


def _with_believed_turn(view: _View, part: Part, pose: Floats, believed: Floats) -> Floats:
    """A pose (4, 4) [m] with the turn about the part's axis as believed, where none is seen."""
    axis = _free_axis(view, part, pose)
    if axis is None:
        return pose
    point, direction = axis
    turned = believed[:3, :3].T @ pose[:3, :3]
    from_axis, to_axis = direction, turned @ direction
    R = pin.Quaternion.FromTwoVectors(from_axis, to_axis).matrix()
    kept = np.array(pose)
    kept[:3, :3] = believed[:3, :3] @ R
    if part.symmetry.form == BALL:
        kept[:3, :3] = believed[:3, :3]
    kept[:3, 3] = pose[:3, :3] @ point + pose[:3, 3] - kept[:3, :3] @ point
    return kept


def _free_axis(view: _View, part: Part, pose: Floats) -> tuple[Floats, Floats] | None:
    """A point (3,) [m] and a direction (3,) of the part about which no turn is seen, if any."""
    symmetry = part.symmetry
    if symmetry.form in (ROUND, BALL):
        axis = symmetry.axes[0].axis if symmetry.form == ROUND else symmetry.axis
        return np.array(symmetry.point), np.array(axis)
    if view.surface.symmetry.axis is None:
        return None
    sighting = view.look(pose)
    alike = count_shared(sighting, view.depth_map.depth.shape[1])
    deviation = float(np.sqrt(alike * np.mean(sighting.off**2)))
    error = roll_error(view.depth_map, view.surface, pose, view.tolerance, deviation)
    point, direction = view.surface.symmetry.axis
    return None if error < ROLL_ERROR else (np.array(point), np.array(direction))


def _off(surface: PartSurface, pose: Floats, believed: Floats) -> tuple[float, float]:
    """How far a part at a pose (4, 4) [m] is off a believed one: its middle [m], its turn [rad]."""
    apart = (pose - believed) @ np.append(surface.middle, 1.0)
    turn = pin.log3(np.array(believed[:3, :3].T @ pose[:3, :3]))
    return float(np.linalg.norm(apart[:3])), float(np.linalg.norm(turn))


def _rise(scan: Scan, surface: PartSurface, pose: Floats, believed: Floats) -> float:
    """How far up [m] a part's middle at a pose (4, 4) [m] is over a believed one, in the world."""
    apart = (pose - believed) @ np.append(surface.middle, 1.0)
    return float(scan.T_world_scanner.rotation[2] @ apart[:3])
