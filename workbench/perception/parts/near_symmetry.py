"""Motions that bring a part nearly onto itself: the poses that a localizer may mix up."""

from dataclasses import dataclass

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.geometry import Floats, own

SYMMETRIC_WITHIN = 0.02
"""Mean distance of the moved surface from itself, over the diameter, that still counts."""

MOSTLY = 0.75
"""Or this share of the surface lies on itself, since the rest may be out of sight: of a cup that
lies nobody sees from the side which end is open."""

TURNS_TRIED = 18
"""Turns tried about the main axis."""

ACROSS = 12
"""Directions across the main axis tried for half turns when none is distinguished."""

EQUAL_INERTIA = 0.05
"""Relative difference below which two moments of inertia distinguish no direction."""

SURFACE_POINTS = 400


@dataclass(frozen=True, slots=True, eq=False)
class NearSymmetry:
    """Motions (k, 4, 4) in the part's frame, the identity first.

    If rotations by any angle about a line are among them, `axis` (2, 3) holds a point of that line
    [m] and its direction.  Then the first `TURNS_TRIED` motions are the rotations about it in equal
    steps.  Otherwise `axis` is None.
    """

    motions: Floats
    axis: Floats | None = None

    def __post_init__(self) -> None:
        own(self, "motions", "axis")

    @property
    def turns(self) -> Floats:
        """The motions (m, 4, 4) that are turns about the axis; none when there is no axis."""
        return self.motions[: 0 if self.axis is None else TURNS_TRIED]


def find_near_symmetry(
    scene: o3d.t.geometry.RaycastingScene, points: Floats, diameter: float
) -> NearSymmetry:
    """Try turns about the main axis of inertia, and half turns across it.

    Bodies of cubic symmetry have no main axis, so theirs is not found.

    Args:
        scene: the surface, for distances, in the part's frame.
        points: (n, 3) [m] spread over it.
        diameter: of the part [m].
    """
    itself = _MovedSurface(scene, points[:: max(1, len(points) // SURFACE_POINTS)], diameter)
    middle = points.mean(axis=0)
    moments, axes = np.linalg.eigh(np.cov(points.T))
    # The main axis is the one whose moment stands apart: that of a disc or of a rod.
    main = 0 if moments[1] - moments[0] > moments[2] - moments[1] else 2
    others = [k for k in (2, 1, 0) if k != main]
    turns, axis = _turns(itself, middle, axes[:, main])
    first, second = (axes[:, k] for k in others)
    larger, smaller = (moments[k] for k in others)
    angles = (
        np.arange(ACROSS) * np.pi / ACROSS
        if axis is None and larger - smaller < EQUAL_INERTIA * larger
        else np.array([0.0, np.pi / 2])
    )
    for angle in angles:
        across = np.cos(angle) * first + np.sin(angle) * second
        flip = itself.settled(_turn(middle, across, np.pi))
        if itself.is_near(flip):
            return NearSymmetry(np.array(turns + [flip @ turn for turn in turns]), axis)
    return NearSymmetry(np.array(turns), axis)


def _turns(
    itself: "_MovedSurface", middle: Floats, direction: Floats
) -> tuple[list[Floats], Floats | None]:
    """The turns about one axis that are near-symmetries, and the axis if all of them are."""
    half = itself.settled(_turn(middle, direction, np.pi))
    centre = (middle + half[:3, :3] @ middle + half[:3, 3]) / 2  # lies on the axis of a half turn
    turned = pin.log3(half[:3, :3])
    axis = turned / np.linalg.norm(turned)
    angles = np.arange(1, TURNS_TRIED) * 2 * np.pi / TURNS_TRIED
    about = [_turn(centre, axis, angle) for angle in angles]
    if itself.is_near(half) and all(itself.is_near(turn) for turn in about):
        return [np.eye(4), *about], np.stack([centre, axis])
    settled = (itself.settled(_turn(middle, direction, angle)) for angle in angles)
    return [np.eye(4), *(turn for turn in settled if itself.is_near(turn))], None


def _turn(centre: Floats, direction: Floats, angle: float) -> Floats:
    motion = np.eye(4)
    motion[:3, :3] = pin.exp3(direction * angle)
    motion[:3, 3] = centre - motion[:3, :3] @ centre
    return motion


@dataclass(frozen=True, slots=True, eq=False)
class _MovedSurface:
    """A surface to compare with its own moved points."""

    scene: o3d.t.geometry.RaycastingScene
    points: Floats
    diameter: float

    def is_near(self, motion: Floats) -> bool:
        moved = self.points @ motion[:3, :3].T + motion[:3, 3]
        distances = self.scene.compute_distance(o3d.core.Tensor(moved.astype(np.float32))).numpy()
        if float(distances.mean()) < SYMMETRIC_WITHIN * self.diameter:
            return True
        return float(np.mean(distances < SYMMETRIC_WITHIN * self.diameter)) > MOSTLY

    def settled(self, motion: Floats) -> Floats:
        """The motion after robust point-to-plane ICP: led by what agrees, not by features."""
        for gate in np.geomspace(0.1, 0.02, 8) * self.diameter:
            moved = self.points @ motion[:3, :3].T + motion[:3, 3]
            nearest = self.scene.compute_closest_points(o3d.core.Tensor(moved.astype(np.float32)))
            normals = nearest["primitive_normals"].numpy().astype(np.float64)
            off = np.sum((nearest["points"].numpy() - moved) * normals, axis=1)
            weights = np.maximum(1 - (off / gate) ** 2, 0.0) ** 2
            centre = moved.mean(axis=0)
            rows = np.concatenate(
                [np.cross((moved - centre) / self.diameter, normals), normals], axis=1
            )
            A = (rows * weights[:, None]).T @ rows
            A += 1e-4 * np.trace(A) * np.eye(6)
            step = np.linalg.solve(A, rows.T @ (weights * off))
            change = np.eye(4)
            change[:3, :3] = pin.exp3(step[:3] / self.diameter)
            change[:3, 3] = step[3:] + centre - change[:3, :3] @ centre
            motion = change @ motion
        return motion
