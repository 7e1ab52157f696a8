"""Turns that bring a part onto itself, found from its surface, for a person to confirm."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, Mesh, frozen, put
from workbench.model.part import Symmetry
from workbench.planning.grasps.part_rays import nearest_points, normals_of, samples_of

TOLERANCE = 0.004
"""Share of the part's diameter by which the turned surface may differ from the unturned one."""

LEAST_TOLERANCE = 0.0001
"""[m] A difference this small is always allowed."""

MOST_FOLD = 24
"""A part that has more turns is round but for the facets of its mesh."""

ROUND = (0.21, 0.83, 1.47, 2.19, 2.71)
"""[rad] No fold contains all of these turns: a part that looks the same after each is round."""

FEW, MANY = 40, 800
"""Pairs of points with which a guess is tried first, and for which it has to hold."""

MOST_WORK = 2e7
"""Points times triangles: on very fine meshes a guess has to hold for fewer points."""

SAME = np.deg2rad(3.0)
"""[rad] Axes closer than this are one."""

FACES = 8
"""The normals of so many of the largest faces are tried as axes."""

STEPS = 36
"""Turns that stand for any angle."""


@dataclass(frozen=True, slots=True, eq=False)
class FoundSymmetry:
    """Turns about a line that leave a part as it is.

    `symmetry` has the line's direction and the fold; `point` (3,) [m] is where the line passes
    nearest to the part's origin; `deviation` [m] is how far the turned surface lies from itself at
    most, `off` [m] how far the line passes the origin.
    """

    symmetry: Symmetry
    point: Floats
    deviation: float
    off: float

    def __post_init__(self) -> None:
        put(self, point=frozen(self.point))


def turns_of(symmetry: Symmetry) -> Floats:
    """The rotations (k, 3, 3), no unit, that leave a part as it is; any angle as `STEPS` steps."""
    count = symmetry.fold or STEPS
    axis = np.array(symmetry.axis)
    return np.array([pin.exp3(axis * (2 * np.pi * k / count)) for k in range(count)])


def proposed_symmetry(mesh: Mesh) -> FoundSymmetry | None:
    """The symmetry that a part's author may state: about a line through the origin.

    The one with the most turns, then the most exact; None when there is none.  A line counts as
    passing through the origin when it would leave the turned surface within the tolerance.
    """
    through = [found for found in symmetries_of(mesh) if found.off <= tolerance_of(mesh) / 2]
    return through[0] if through else None


def symmetries_of(mesh: Mesh) -> tuple[FoundSymmetry, ...]:
    """All that are found, the one with the most turns first, also about lines off the origin.

    Lines through the centre of the surface are tried along its principal axes, the part's own axes
    and the normals of its largest faces.
    """
    itself = _Itself(mesh)
    found: list[FoundSymmetry] = []
    for axis in _axes(mesh, itself.centre):
        fold, deviation = itself.fold(axis)
        if fold == 1:
            continue
        point = itself.centre - (itself.centre @ axis) * axis
        off = float(np.linalg.norm(point))
        if off < LEAST_TOLERANCE:
            point, off = np.zeros(3), 0.0
        found.append(FoundSymmetry(Symmetry(axis, fold), point, deviation, off))
        if sum(one.symmetry.fold == 0 for one in found) == 2:  # a ball
            break
    # Rounded, so that equally exact ones keep the order in which the axes were tried.
    found.sort(key=lambda one: (-(one.symmetry.fold or 1000), round(one.deviation, 6)))
    return tuple(found)


def deviation_of(mesh: Mesh, symmetry: Symmetry) -> float:
    """How far the surface lies from itself at most [m] after the turns that somebody stated."""
    itself = _Itself(mesh)
    turns = turns_of(symmetry)[1:]
    return max((itself.deviation(R, np.zeros(3), MANY) for R in turns), default=0.0)


def tolerance_of(mesh: Mesh) -> float:
    """[m] A turned surface that lies no further from itself is the same."""
    return max(TOLERANCE * float(np.linalg.norm(np.ptp(mesh.points, axis=0))), LEAST_TOLERANCE)


class _Itself:
    """A surface to be compared with its own turned points."""

    def __init__(self, mesh: Mesh):
        self.mesh = mesh
        _, areas = normals_of(mesh)
        corners = mesh.points[mesh.triangles]
        self.centre = areas @ corners.mean(axis=1) / areas.sum()
        self.tolerance = tolerance_of(mesh)
        self._many = int(np.clip(MOST_WORK / len(mesh.triangles), FEW, MANY))
        rng = np.random.default_rng(0)
        samples, _ = samples_of(mesh, MANY, rng)
        # Corners show what stands out, however small.
        used = np.unique(mesh.triangles)
        chosen = rng.permutation(used)[:MANY]
        self._points = np.vstack([samples, mesh.points[chosen]])
        self._points = self._points[rng.permutation(len(self._points))]

    def deviation(self, R: Floats, about: Floats, count: int) -> float:
        """How far points lie from the surface at most after a turn about a point [m]."""
        moved = (self._points[: 2 * count] - about) @ R.T + about
        return float(nearest_points(self.mesh, moved)[1].max())

    def fold(self, axis: Floats) -> tuple[int, float]:
        """The number of turns about the centre, 0 for any, 1 for none, and their deviation [m]."""
        is_round, deviation = self._holds(axis, ROUND)
        if is_round:
            return 0, deviation
        for fold in range(MOST_FOLD, 1, -1):
            angles = (2 * np.pi / fold,)
            holds, deviation = self._holds(axis, angles)
            if holds:
                return fold, deviation
        return 1, 0.0

    def _holds(self, axis: Floats, angles: tuple[float, ...]) -> tuple[bool, float]:
        worst = 0.0
        for count in (FEW, self._many):
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
        if length > 0.5 and all(abs(float(axis @ known)) < np.cos(SAME) for known in axes):
            axes.append(axis / length)
    return axes
