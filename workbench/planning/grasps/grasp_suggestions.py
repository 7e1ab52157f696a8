"""Grasps that a part's shape suggests: opposite faces for two fingers, even faces for a cup.

Pairs of points with opposite normals are sampled on the surface, and hands put around them from
all sides; the most promising are checked closely (`grasp_check`), unless like better ones.

Source: V.-D. Nguyen, "Constructing force-closure grasps", International Journal of Robotics
Research 7(3), 1988: two contacts hold when the line between them lies in both friction cones.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Tool
from workbench.model.geometry import Floats, Mesh
from workbench.model.part import Grasp, Part, widen_grasp
from workbench.planning.grasps.grasp_check import FRICTION, GraspCheck, GraspChecker
from workbench.planning.grasps.grasp_frames import (
    BEYOND,
    centre_on_grip,
    fitted_opening,
    palm_distance,
    thickness,
)
from workbench.planning.grasps.pads import Pads
from workbench.planning.grasps.part_rays import (
    NO_TRIANGLE,
    centre_of_mass,
    first_hits,
    normals_of,
    samples_of,
)
from workbench.planning.grasps.part_symmetry import TURNS_TRIED

SURFACE_POINTS = 400
"""Points on the surface."""

APPROACH_SIDES = 8
"""Directions from which the hand may come to two points."""

MOST_CHECKED = 400
"""Grasps that are checked closely, at most."""

ALIKE_DISTANCE = 0.12
"""Share of the part's size: grasps nearer to each other, and turned by less, are alike."""

ALIKE_TURN = np.deg2rad(30.0)
"""[rad] See `ALIKE_DISTANCE`."""

PAD = 50e-6
"""[m2] A pad that touches more holds no better."""

WIDEST_AIR = 0.004
"""[m] More room between the open tool and the part is no better."""

SURFACES = 5
"""Of the part that a line from a point is followed through: walls, and what is hollow between."""

THINNEST = 0.0005
"""[m] Nothing thinner is taken between fingers."""


@dataclass(frozen=True, slots=True, eq=False)
class Suggestion:
    """A grasp that a tool can do, ready to be added.

    `score` 0..1; `angle` [rad] between the faces and square to the fingers' travel, or 0 for a cup;
    `lever` [m] from the grasp to the centre of mass; `check` what the close look said.
    """

    grasp: Grasp
    score: float
    angle: float
    lever: float
    check: GraspCheck


@dataclass(frozen=True, slots=True, eq=False)
class _Idea:
    """A pose to look at, promising as `promise` says."""

    T_part_tcp: pin.SE3
    promise: float
    angle: float
    lever: float


def suggest(
    part: Part,
    tool: Tool,
    *,
    most: int = 20,
    seed: int = 0,
    name: str = "suggested",
    acceleration: float | None = None,
    refused: Callable[[GraspCheck], None] = lambda _: None,
) -> tuple[Suggestion, ...]:
    """Grasps for a part, the best first; none like those that its library holds.

    Args:
        part: with its library, which is left as it is.
        tool: with two fingers, or with none: a cup.
        most: that are returned.
        seed: of the samples.
        name: of the grasps, followed by a number that makes it new in the library.
        acceleration: [m/s2] that grips have to hold against; see `GraspChecker`.
        refused: is called with each that nothing but the part's weight speaks against.

    Returns:
        At most `most`; none when the tool cannot take the part.
    """
    checker = GraspChecker(part, tool, acceleration)
    rng = np.random.default_rng(seed)
    if checker.pads is not None:
        ideas = _opposite(checker, checker.pads, rng)
    elif checker.cup is not None:
        ideas = _even(checker, rng)
    else:
        return ()
    kept = _Kept(part, tool)
    for grasp in part.library.grasps:
        if not grasp.tool or grasp.tool == tool.name:
            kept.add(grasp.T_part_tcp)
    found: list[Suggestion] = []
    looks = 0
    for idea in sorted(ideas, key=lambda idea: -idea.promise):
        if len(found) == most or looks == MOST_CHECKED:
            break
        if kept.has_like(idea.T_part_tcp):
            continue
        looks += 1
        suggestion = _looked_at(checker, idea, refused)
        if suggestion is not None:
            kept.add(suggestion.grasp.T_part_tcp)
            found.append(suggestion)
    found.sort(key=lambda rated: -rated.score)
    return tuple(_name(found, {grasp.name for grasp in part.library.grasps}, name))


def _opposite(checker: GraspChecker, pads: Pads, rng: np.random.Generator) -> list[_Idea]:
    """Hands around pairs of points whose normals are opposite."""
    mesh = checker.part.mesh
    points, inward, widths, angles = opposite_points(checker, SURFACE_POINTS, rng)
    middles = points + widths[:, None] / 2 * inward
    levers = np.linalg.norm(middles - centre_of_mass(mesh), axis=1)
    size = float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    fingers = max(palm_distance(checker), THINNEST)
    # One row for each pair of points and each side.
    z = sides(inward, APPROACH_SIDES).reshape(-1, 3)
    y, middles = (
        np.repeat(inward, APPROACH_SIDES, axis=0),
        np.repeat(middles, APPROACH_SIDES, axis=0),
    )
    angles, levers = np.repeat(angles, APPROACH_SIDES), np.repeat(levers, APPROACH_SIDES)
    over, below = thickness(mesh, middles, -z), thickness(mesh, middles, z)
    promise = 1.0 - angles / FRICTION - 2 * levers / size - 0.3 * over / fingers
    # Fingers mostly travel along y of the TCP; where they do not, the hand is turned by as much.
    R = np.stack([np.cross(y, z), y, z], axis=2) @ pads.R_tcp_closing.T
    p = middles + np.minimum(BEYOND, below)[:, None] * z
    return [
        _Idea(pin.SE3(R[k], p[k]), float(promise[k]), float(angles[k]), float(levers[k]))
        for k in np.flatnonzero(over < fingers)
    ]


def opposite_points(
    checker: GraspChecker, count: int, rng: np.random.Generator
) -> tuple[Floats, Floats, Floats, Floats]:
    """Points of the surface (n, 3) [m] with an opposite one that the tool can close on.

    Of `count` samples those that have one, once for each: a tube is taken by its wall or across
    its outside.  Beside them the directions (n, 3) to it, its distance (n,) [m] and the angle (n,)
    [rad] between the faces.
    """
    mesh, (low, high) = checker.part.mesh, checker.tool.stroke
    normals, _ = normals_of(mesh)
    points, triangles = samples_of(mesh, count, rng)
    inward = -normals[triangles]
    found: list[tuple[Floats, Floats, Floats, Floats]] = []
    widths = np.zeros(len(points))
    for _ in range(SURFACES):
        step, met = first_hits(mesh, points + (widths + 1e-6)[:, None] * inward, inward)
        widths = widths + 1e-6 + step
        facing = np.clip(np.einsum("ij,ij->i", inward, normals[met]), -1.0, 1.0)
        angles = np.where(met == NO_TRIANGLE, np.pi, np.arccos(facing))
        fits = (widths > max(low, THINNEST)) & (widths < high) & (angles < FRICTION)
        found.append((points[fits], inward[fits], widths[fits], angles[fits]))
        on = (met != NO_TRIANGLE) & (widths < high)
        points, inward, widths = points[on], inward[on], widths[on]
    points, inward, widths, angles = (np.concatenate(column) for column in zip(*found, strict=True))
    return points, inward, widths, angles


def sides(y: Floats, count: int) -> Floats:
    """Unit vectors (n, count, 3) square to each of the unit vectors y (n, 3), evenly all around.

    The first is as near to an axis of the part as can be.
    """
    axes = np.eye(3)[np.abs(y).argmin(axis=1)]
    first = axes - np.einsum("ij,ij->i", axes, y)[:, None] * y
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    turns = np.arange(count)[:, None] * 2 * np.pi / count
    return np.cos(turns) * first[:, None] + np.sin(turns) * np.cross(y, first)[:, None]


def _even(checker: GraspChecker, rng: np.random.Generator) -> list[_Idea]:
    """Cups on points, in the middle of the flat faces first."""
    mesh = checker.part.mesh
    normals, _ = normals_of(mesh)
    points, triangles = samples_of(mesh, SURFACE_POINTS, rng)
    flat_points, flat_normals = _flat_faces(mesh)
    points = np.vstack([flat_points, points])
    outward = np.vstack([flat_normals, normals[triangles]])
    size = float(np.linalg.norm(np.ptp(mesh.points, axis=0)))
    levers = np.linalg.norm(np.cross(centre_of_mass(mesh) - points, outward), axis=1)
    x = sides(outward, APPROACH_SIDES)[:, 0]
    R = np.stack([x, np.cross(-outward, x), -outward], axis=2)
    return [
        _Idea(pin.SE3(R[k], points[k]), 1.0 - 2 * lever / size, 0.0, lever)
        for k, lever in enumerate(levers.tolist())
    ]


def _flat_faces(mesh: Mesh) -> tuple[Floats, Floats]:
    """The middles (n, 3) [m] of the flat faces and their normals (n, 3), the largest first."""
    normals, areas = normals_of(mesh)
    middles = mesh.points[mesh.triangles].mean(axis=1)
    height = np.einsum("ij,ij->i", normals, middles)
    planes = np.column_stack([np.round(normals, 2), np.round(height, 4)])
    _, number = np.unique(planes, axis=0, return_inverse=True)
    number = number.ravel()
    whole = np.bincount(number, areas)
    largest = np.argsort(-whole, kind="stable")[:50]
    sums = np.stack([np.bincount(number, areas * middles[:, k]) for k in range(3)], axis=1)
    first = np.array([int(np.flatnonzero(number == face)[0]) for face in largest])
    # Slivers have no normal to go by.
    good = (whole[largest] > 1e-9) & (np.linalg.norm(normals[first], axis=1) > 0.5)
    largest, first = largest[good], first[good]
    return sums[largest] / whole[largest][:, None], normals[first]


def _looked_at(
    checker: GraspChecker, idea: _Idea, refused: Callable[[GraspCheck], None]
) -> Suggestion | None:
    """The grasp of an idea with its score; None when something speaks against it."""
    if checker.pads is not None:
        T_part_tcp = centre_on_grip(checker, idea.T_part_tcp)
        fingers = fitted_opening(checker, T_part_tcp)
        if fingers is None or fingers.grip > checker.tool.stroke[1]:
            return None
        grasp = Grasp("", T_part_tcp, fingers.opening, fingers.grip)
        wide = widen_grasp(grasp, checker.part.tolerance).opening
        if checker.clearance(T_part_tcp, wide, within=0.0)[0] < 0.0:
            return None
    else:
        grasp = Grasp("", idea.T_part_tcp, 0.0, 0.0, free_rotation=np.pi)
        if checker.seal_findings(grasp):
            return None
    check = checker.check(grasp)
    if check.findings:  # also what is no problem: there are better ones
        if all(finding.kind == "weight" for finding in check.findings):
            refused(check)
        return None
    size = float(np.linalg.norm(np.ptp(checker.part.mesh.points, axis=0)))
    near = max(0.0, 1 - 2 * idea.lever / size)
    if check.hold is None:
        return Suggestion(grasp, 0.3 + 0.7 * near, idea.angle, idea.lever, check)
    angle = max(check.hold.slants)
    room = min(max(check.clearance, 0.0) / WIDEST_AIR, 1.0)
    area = min(min(check.hold.areas) / PAD, 1.0)
    score = 0.35 * (1 - angle / FRICTION) + 0.3 * near + 0.15 * room + 0.2 * area
    return Suggestion(grasp, score, angle, idea.lever, check)


def _name(found: list[Suggestion], taken: set[str], name: str) -> list[Suggestion]:
    named: list[Suggestion] = []
    number = 0
    for suggestion in found:
        number += 1
        while f"{name}-{number}" in taken:
            number += 1
        named.append(replace(suggestion, grasp=replace(suggestion.grasp, name=f"{name}-{number}")))
    return named


class _Kept:
    """Grasps that count already, with all that are the same grip for the part's symmetry."""

    def __init__(self, part: Part, tool: Tool):
        self._motions = part.symmetry.motions(TURNS_TRIED)
        self._size = float(np.linalg.norm(np.ptp(part.mesh.points, axis=0)))
        self._is_round = not tool.fingers
        self._changes = len(tool.fingers) == 2
        self._R, self._p = np.empty((0, 3, 3)), np.empty((0, 3))

    def add(self, T: pin.SE3) -> None:
        """From now on what is like this grasp is known."""
        R = self._motions[:, :3, :3] @ T.rotation
        if self._changes:
            R = np.concatenate([R, R * [-1.0, -1.0, 1.0]])
        p = self._motions[:, :3, :3] @ T.translation + self._motions[:, :3, 3]
        self._R = np.concatenate([self._R, R])
        self._p = np.concatenate([self._p, np.resize(p, (len(R), 3))])

    def has_like(self, T: pin.SE3) -> bool:
        """Whether a grasp is like one of them."""
        near = np.linalg.norm(self._p - T.translation, axis=1) < ALIKE_DISTANCE * self._size
        R = self._R[near]
        if self._is_round:
            cosines = R[:, :, 2] @ T.rotation[:, 2]
        else:
            cosines = (np.einsum("nij,ij->n", R, T.rotation) - 1) / 2
        return bool((cosines > np.cos(ALIKE_TURN)).any())
