"""What a scan shows of the scanner's pose by things whose place is known: bin, fixtures, parts.

The bin is fitted as in every scan.  Each fixture and each placed part is fitted to the points on
its surface (point-to-plane ICP, Chen and Medioni 1992).  The result is its small motion from the
known pose along the directions that its surfaces constrain, and nothing along the others.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Floats, own
from workbench.model.scan import Detection, Scan
from workbench.perception.bins.bin_check import check_bin
from workbench.perception.views.surfaces import add_solids, add_surface, triangles_of

Kind = Literal["bin", "fixture", "part"]

MOST_POINTS = 20_000
"""Points of a scan that are checked, and all around parts; of more every second, third, ..."""

SURFACE_WITHIN, GATES = 0.008, (0.006, 0.004, 0.003, 0.003)
"""[m] Points this near to a surface may belong to it; the same in each step of the fit."""

FACING = 0.3
"""Cosine to the line of sight above which a surface is measured well."""

INSIDE = 1e-4
"""[m] Across its normal, the point of a surface that is nearest to another is no further off: else
it is on an edge, which says nothing of the face."""

FEWEST_POINTS = 60
"""Points on a thing that is believed."""

HELD = 0.01
"""Share of the information of the best direction below which a direction is not held."""

NOISE, SHARED, BIAS = 0.0005, 16.0, 0.0001
"""[m] Deviation of a point; this many count as one; and what no number of points takes out.  Only
how the directions of one thing compare is taken from these: what is stated is measured."""

LYING = np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 1.0])
"""What something level leaves of the error of a part that comes to rest on it."""

BIN_DEVIATION = (0.0001, 0.0005)
"""[m, rad] Deviations of the bin as one scan shows it, to the same end."""


@dataclass(frozen=True, slots=True, eq=False)
class ThingSighting:
    """A thing in a scan: how far from where it was expected, and what that says of the scanner.

    All are small motions (6,) [m, rad]: the shift of the point of the thing at the bin's middle,
    then the turn, along the world's axes.  `off` is that by which the thing is seen elsewhere than
    expected, `information` (6, 6) its inverse covariance, zero along what is not seen.  With the
    scanner moved by x from where the cell has it, `off` is `slopes @ x` (6, 6) on average: -x for
    what stands still, see `put_slopes` for what was taken by what the scanner has seen.  `at`
    [s since the epoch].
    """

    thing: str
    kind: Kind
    at: float
    off: Floats
    information: Floats
    slopes: Floats = field(default_factory=lambda: -np.eye(6))

    def __post_init__(self) -> None:
        own(self, "off", "information", "slopes")


@dataclass(frozen=True, slots=True, eq=False)
class PutPart:
    """A part that stands where the robot has put it.

    `slopes` (6, 6) are those of its sighting, no unit of their own: of [m, rad] in [m, rad].
    """

    detection: Detection
    slopes: Floats


def put_slopes(
    middle: Floats, T_world_found: pin.SE3, T_world_put: pin.SE3, keeps: Floats
) -> Floats:
    """Jacobian (6, 6) of a placed part's apparent error by the scanner's pose error [m, rad].

    The robot moves a part as commanded, from the pose in which the scanner saw it.  The grip keeps
    some of the scanner's error, and the motion carries it along.  As in hand-eye calibration, the
    error shows because it does not commute with the motion.  The part comes to rest on a level
    surface, which removes the remaining errors of height and tilt.

    Args:
        middle: (3,) [m] of the bin, where all motions are reported.
        T_world_found: pose of the part in the scan before the pick.
        T_world_put: pose at which the robot placed it.
        keeps: (6, 6) share of an error that the grip keeps, as a motion at the part's origin in
            `T_world_found`, along the world's axes.
    """
    to_world = pin.SE3(np.eye(3), middle)
    moved = T_world_put * T_world_found.inverse()
    moved = to_world.actInv(moved * to_world)
    carried = np.kron(np.eye(2), moved.rotation)
    carried[:3, 3:] = pin.skew(moved.translation) @ moved.rotation
    kept = _at(T_world_found.translation - middle, keeps)
    rest = _at(T_world_put.translation - middle, LYING)
    return -(np.eye(6) - rest @ carried @ kept)


def sight_things(
    cell: Cell, scan: Scan, put_down: Sequence[PutPart] = (), *, at: float = 0.0
) -> list[ThingSighting]:
    """Everything known that a scan shows well enough to say where it is.

    Args:
        cell: bin and fixtures, and where the scanner is taken to be.
        scan: what was seen.
        put_down: parts that the robot has put where the scanner may see them.
        at: [s since the epoch] when.
    """
    middle = cell.bin.T_world_bin.translation
    found: list[ThingSighting] = []
    T_seen = check_bin(scan, cell.bin).T_world_bin
    if T_seen is not None:
        known = np.repeat(1 / np.square(BIN_DEVIATION), 3)
        if not cell.bin.has_walls:
            known *= [0, 0, 1, 1, 1, 0]
        off = motion_at(T_seen * cell.bin.T_world_bin.inverse(), middle)
        found.append(ThingSighting("bin", "bin", at, off, np.diag(known)))
    surfaces = _Surfaces(cell, put_down)
    points = _looked_at(cell, scan, put_down)
    view = scan.T_world_scanner.translation
    owners = surfaces.owners(points, view)
    for number, (name, kind, slopes) in enumerate(surfaces.things):
        own = points[owners == number]
        fitted = surfaces.fitted(number, own, view) if len(own) >= FEWEST_POINTS else None
        if fitted is not None:
            off, information, place = fitted
            back = np.linalg.inv(moved_to(middle - place))
            off, information = moved_to(middle - place) @ off, back.T @ information @ back
            found.append(ThingSighting(name, kind, at, off, information, slopes))
    return found


def _looked_at(cell: Cell, scan: Scan, put_down: Sequence[PutPart]) -> Floats:
    """Points (n, 3) [m] in the world: all around parts, some of the others."""
    points = scan.points_world
    is_near = np.zeros(len(points), bool)
    is_near[:: -(-len(points) // MOST_POINTS)] = True
    for put_part in put_down:
        reach = (
            np.linalg.norm(cell.part(put_part.detection.part).mesh.points, axis=1).max()
            + SURFACE_WITHIN
        )
        off = points - put_part.detection.T_world_part.translation
        is_near |= np.einsum("ij,ij->i", off, off) < reach**2
    return points[is_near]


def motion_at(T: pin.SE3, point: Floats) -> Floats:
    """A small motion of the world as the shift of a point (3,) [m] and the turn (6,) [m, rad]."""
    return np.concatenate([T.act(point) - point, pin.log3(T.rotation)])


def motion_of(step: Floats, point: Floats) -> pin.SE3:
    """The motion of the world that a step (6,) [m, rad] at a point (3,) [m] means (`motion_at`)."""
    R = pin.exp3(step[3:])
    return pin.SE3(R, point + step[:3] - R @ point)


def moved_to(by: Floats) -> Floats:
    """Motions at a point, as motions at one that is `by` (3,) [m] from it, (6, 6)."""
    found = np.eye(6)
    found[:3, 3:] = -pin.skew(by)
    return found


def _at(place: Floats, matrix: Floats) -> Floats:
    """A matrix (6, 6) of motions at a place (3,) [m], converted to motions at the middle."""
    there = moved_to(place)
    return np.linalg.inv(there) @ matrix @ there


class _Surfaces:
    """All known surfaces, and whose each is: an index into `things`, or -1 of the bin."""

    def __init__(self, cell: Cell, put_down: Sequence[PutPart]):
        self._scene = o3d.t.geometry.RaycastingScene(nthreads=1)
        self.things: list[tuple[str, Kind, Floats]] = []
        owners: list[int] = []
        add_solids(self._scene, cell.bin.solids, cell.bin.T_world_bin)
        owners += [-1] * len(cell.bin.solids)
        for fixture in cell.fixtures:
            add_solids(self._scene, fixture.solids, fixture.T_world_fixture)
            owners += [len(self.things)] * len(fixture.solids)
            self.things.append((fixture.name, "fixture", -np.eye(6)))
        for put_part in put_down:
            mesh = cell.part(put_part.detection.part).mesh
            add_surface(self._scene, triangles_of(mesh), put_part.detection.T_world_part)
            owners.append(len(self.things))
            self.things.append((put_part.detection.part, "part", put_part.slopes))
        self._owners = np.array(owners)

    def owners(self, points: Floats, view: Floats) -> np.ndarray:
        """Of each point (n, 3) [m] in the world; -1 of those on nothing but the bin."""
        owner, _, off, is_on = self._nearest(points, view)
        return np.where(is_on & (np.abs(off) < SURFACE_WITHIN), owner, -1)

    def fitted(
        self, number: int, points: Floats, view: Floats
    ) -> tuple[Floats, Floats, Floats] | None:
        """The motion (6,) of a thing, its information (6, 6), and their reference point (3,).

        None where too few points are left.
        """
        place = points.mean(axis=0)
        size = float(np.sqrt(((points - place) ** 2).sum(axis=1).mean()))
        off, information = np.zeros(6), np.zeros((6, 6))
        scale = np.repeat([1.0, size], 3)
        for gate in GATES:
            T = motion_of(off, place)
            back = (points - T.translation) @ T.rotation
            owner, normals, away, is_on = self._nearest(back, view)
            on = is_on & (owner == number) & (np.abs(away) < gate)
            if np.count_nonzero(on) < FEWEST_POINTS:
                return None
            rows = np.hstack([normals[on], np.cross(back[on] - place, normals[on]) / size])
            weights = (1 - (away[on] / gate) ** 2) ** 2  # Tukey's biweight
            held, axes = np.linalg.eigh((rows * weights[:, None]).T @ rows)
            is_held = held > HELD * held[-1]
            axes, held = axes[:, is_held], held[is_held]
            step = axes @ ((axes.T @ ((rows * weights[:, None]).T @ away[on])) / held)
            off = off + step / scale
            sure = 1 / (NOISE**2 * SHARED / held + BIAS**2)
            information = (axes * sure) @ axes.T * np.outer(scale, scale)
        return off, information, place

    def _nearest(self, points: Floats, view: Floats) -> tuple[np.ndarray, Floats, Floats, Bools]:
        """Owner, normal and height over the nearest face, and whether that is seen and no edge."""
        queries = np.ascontiguousarray(points, dtype=np.float32)
        found = self._scene.compute_closest_points(o3d.core.Tensor(queries), nthreads=1)
        normals = found["primitive_normals"].numpy().astype(np.float64)
        between = points - found["points"].numpy()
        off = (between * normals).sum(axis=1)
        across = np.linalg.norm(between - off[:, None] * normals, axis=1)
        to_view = view - points
        facing = (normals * to_view).sum(axis=1) > FACING * np.linalg.norm(to_view, axis=1)
        owner = self._owners[found["geometry_ids"].numpy().astype(np.int64)]
        return owner, normals, off, facing & (across < INSIDE)
