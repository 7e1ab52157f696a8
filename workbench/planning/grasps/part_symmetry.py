"""Turns that bring a part onto itself, found from its surface, for a person to confirm."""

from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Mesh
from workbench.model.symmetry import Symmetry, SymmetryAxis, turn_about
from workbench.planning.grasps.part_rays import MeshSurface, normals_of, samples_of

SAME_SURFACE_SHARE = 0.004
"""Share of the part's diameter by which the turned surface may differ from the unturned one."""

LEAST_TOLERANCE = 0.0001
"""[m] A difference this small is always allowed."""

EXACT = 0.1
"""Share of the tolerance: a fold that is no further off is exact, and one that is is doubted."""

MOST_FOLD = 24
"""A part that has more turns is round except for the facets of its mesh."""

ROUND_TURNS = (0.21, 0.83, 1.47, 2.19, 2.71)
"""[rad] No fold contains all of these turns: a part that looks the same after each is round."""

FIRST_PAIRS, ALL_PAIRS = 40, 800
"""Pairs of points with which a guess is tried first, and for which it has to hold."""

MOST_WORK = 2e7
"""Points times triangles: on very fine meshes a guess has to hold for fewer points."""

SAME_AXIS = np.deg2rad(3.0)
"""[rad] Axes closer than this are one."""

FACES = 8
"""The normals of this many of the largest faces are tried as axes."""

TURNS_TRIED = 36
"""Turns that stand for any angle."""

SMALL = 0.05
"""Cosine below which an axis is across another."""

AXIS_STEP, MOST_HALVINGS = float(np.deg2rad(0.5)), 6
"""[rad] Steps in which half turns across an axis are tried, and how often they are halved."""

MARGIN = 1.5
"""Times the tolerance by which products of turns may be off, each of which holds."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundSymmetry:
    """A symmetry, and how far the turned surface lies from itself at most, `deviation` [m]."""

    symmetry: Symmetry
    deviation: float


def proposed_symmetry(mesh: Mesh) -> FoundSymmetry | None:
    """The symmetry that a part's author may state; None when there is none.

    The axis with the most turns, then the most exact, and with it all others that make a group.
    """
    itself = _TurnedSurface(mesh)
    found = _axes_of(itself)
    if not found:
        return None
    symmetry, deviation = found[0]
    if symmetry.fold != 1 and all(
        abs(other_axis.axis @ symmetry.axis) > SMALL for other_axis, _ in found[1:]
    ):
        found += _across(itself, symmetry)
    for other_axis, off in found[1:]:
        larger = replace(
            symmetry, also=(*symmetry.also, SymmetryAxis(other_axis.axis, other_axis.fold))
        )
        try:
            is_larger = len(larger.turns) > len(symmetry.turns)
        except InputError:
            continue
        if is_larger and itself.worst(larger) <= MARGIN * itself.tolerance:
            symmetry, deviation = larger, max(deviation, off)
    point = symmetry.invariant_point(np.zeros(3))
    is_at_origin = float(np.linalg.norm(point)) <= itself.tolerance / 2
    x, y, z = np.zeros(3) if is_at_origin else np.round(point, 7)
    return FoundSymmetry(replace(symmetry, point=(x, y, z)), deviation)


def deviation_of(mesh: Mesh, symmetry: Symmetry) -> float:
    """How far the surface lies from itself at most [m] after the turns that somebody stated."""
    return _TurnedSurface(mesh).worst(symmetry)


def _axes_of(itself: "_TurnedSurface") -> list[tuple[Symmetry, float]]:
    """Axes with turns, the one with the most first, and how far off the turned surface is [m].

    Lines through the centre of the surface are tried along its principal axes, the part's own axes
    and the normals of its largest faces.
    """
    found: list[tuple[Symmetry, float]] = []
    for axis in _axes(itself.mesh, itself.centre):
        fold, deviation = itself.fold(axis)
        if fold == 1:
            continue
        found.append((Symmetry(axis, fold, tuple(itself.centre)), deviation))
        if sum(symmetry.fold == 0 for symmetry, _ in found) == 2:  # a ball
            break
    # Rounded, so that equally exact ones keep the order in which the axes were tried.
    found.sort(key=lambda rated: (-(rated[0].fold or 1000), round(rated[1], 6)))
    return found


def _across(itself: "_TurnedSurface", symmetry: Symmetry) -> list[tuple[Symmetry, float]]:
    """A half turn across an axis, which no face need show: the best of many, if it holds."""
    first = np.linalg.svd(symmetry.axis[None])[2][1]

    def turn_by(angle: float) -> Floats:
        return np.array(turn_about(symmetry.axis, angle) @ first)

    def off(angle: float) -> float:
        return itself.deviation(turn_about(turn_by(angle), np.pi), itself.centre, FIRST_PAIRS)

    best, step = 0.0, AXIS_STEP
    if symmetry.fold:
        best = min(np.arange(0.0, np.pi / symmetry.fold, step), key=off)
    for _ in range(MOST_HALVINGS):
        step /= 2
        best = min((best, best - step, best + step), key=off)
    axis = turn_by(best)
    holds, deviation = itself.holds(axis, (np.pi,))
    return [(replace(symmetry, axis=axis, fold=2), deviation)] if holds else []


def tolerance_of(mesh: Mesh) -> float:
    """[m] A turned surface that lies no further from itself is the same."""
    return max(
        SAME_SURFACE_SHARE * float(np.linalg.norm(np.ptp(mesh.points, axis=0))), LEAST_TOLERANCE
    )


class _TurnedSurface:
    """A surface to be compared with its own turned points."""

    def __init__(self, mesh: Mesh):
        self.mesh = mesh
        self._surface = MeshSurface(mesh)
        _, areas = normals_of(mesh)
        corners = mesh.points[mesh.triangles]
        self.centre = areas @ corners.mean(axis=1) / areas.sum()
        self.tolerance = tolerance_of(mesh)
        self._many = int(np.clip(MOST_WORK / len(mesh.triangles), FIRST_PAIRS, ALL_PAIRS))
        rng = np.random.default_rng(0)
        samples, _ = samples_of(mesh, ALL_PAIRS, rng)
        # Corners show what stands out, however small.
        used = np.unique(mesh.triangles)
        chosen = rng.permutation(used)[:ALL_PAIRS]
        self._points = np.vstack([samples, mesh.points[chosen]])
        self._points = self._points[rng.permutation(len(self._points))]

    def deviation(self, R: Floats, about: Floats, count: int) -> float:
        """How far points lie from the surface at most after a turn about a point [m]."""
        moved = (self._points[: 2 * count] - about) @ R.T + about
        return float(self._surface.nearest(moved)[1].max())

    def worst(self, symmetry: Symmetry) -> float:
        """How far points lie from the surface at most after any turn of a group [m]."""
        about, motions = np.array(symmetry.point), symmetry.motions(TURNS_TRIED)[1:]
        return max((self.deviation(M[:3, :3], about, self._many) for M in motions), default=0.0)

    def fold(self, axis: Floats) -> tuple[int, float]:
        """The number of turns about the centre, 0 for any, 1 for none, and their deviation [m]."""
        is_round, deviation = self.holds(axis, ROUND_TURNS)
        if is_round:
            return 0, deviation
        found = [
            (fold, deviation)
            for fold in range(MOST_FOLD, 1, -1)
            for holds, deviation in [self.holds(axis, (2 * np.pi / fold,))]
            if holds
        ]
        # A small feature may let wrong folds through: exact ones beat them, then the largest.
        exact = [rated for rated in found if rated[1] <= EXACT * self.tolerance]
        return (exact or found or [(1, 0.0)])[0]

    def holds(self, axis: Floats, angles: tuple[float, ...]) -> tuple[bool, float]:
        """Whether some turns [rad] about the centre leave the surface, and their deviation [m]."""
        worst = 0.0
        for count in (FIRST_PAIRS, self._many):
            for angle in angles:
                worst = max(worst, self.deviation(pin.exp3(axis * angle), self.centre, count))
                if worst > self.tolerance:
                    return False, worst
        return True, worst


def _axes(mesh: Mesh, centre: Floats) -> list[Floats]:
    """Directions worth a try, each once, the part's own axes first."""
    normals, areas = normals_of(mesh)
    corners = mesh.points[mesh.triangles] - centre
    sums = corners.sum(axis=1)
    moments = np.einsum("n,nki,nkj->ij", areas, corners, corners)
    moments += np.einsum("n,ni,nj->ij", areas, sums, sums)
    _, principal = np.linalg.eigh(moments)
    rounded, number = np.unique(np.round(normals, 3), axis=0, return_inverse=True)
    whole = np.bincount(number.ravel(), areas, len(rounded))
    faces = [normals[number.ravel() == k][0] for k in np.argsort(-whole, kind="stable")[:FACES]]
    axes: list[Floats] = []
    for axis in (*np.eye(3)[::-1], *principal.T, *faces):
        length = float(np.linalg.norm(axis))
        if length > 0.5 and all(abs(float(axis @ known)) < np.cos(SAME_AXIS) for known in axes):
            axes.append(axis / length)
    return axes
