"""Poses, arrays that cannot change, and the shapes that things are made of.

A pose is a `pinocchio.SE3` named `T_a_b`: the pose of frame b in frame a, so that
`p_a = T_a_b.act(p_b)` and `T_a_c = T_a_b * T_b_c`.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from workbench.model.errors import InputError

Floats = NDArray[np.float64]
Ints = NDArray[np.integer[Any]]
Bools = NDArray[np.bool_]
N = TypeVar("N", bound=np.generic)


def frozen(values: ArrayLike, dtype: Any = np.float64) -> NDArray[Any]:
    """A contiguous copy of `values` (...,), whatever their unit, that refuses to be written to."""
    array = np.array(values, dtype=dtype, order="C")
    array.setflags(write=False)
    return array


def sampled(rows: NDArray[N], most: int) -> NDArray[N]:
    """Every k-th of `rows` (n, ...), whatever their unit, so that at most `most` are left."""
    return rows[:: max(1, -(-len(rows) // most))]


def put(value: Any, **fields: Any) -> None:
    """Set fields of a frozen dataclass while it is being made (in `__post_init__` only)."""
    for name, item in fields.items():
        object.__setattr__(value, name, item)


def own(value: Any, *names: str) -> None:
    """Replace fields of a frozen dataclass by copies of its own (in `__post_init__` only).

    Poses are copied and arrays made read-only (`float64`); None stays.
    """
    for name in names:
        field = getattr(value, name)
        if field is not None:
            copy = copy_pose(field) if isinstance(field, pin.SE3) else frozen(field)
            object.__setattr__(value, name, copy)


def copy_pose(T: pin.SE3) -> pin.SE3:
    """A copy of a pose: SE3 is mutable, and a frozen dataclass does not protect it."""
    # One sum is not finite when any number in it is not; this is called for every pose made.
    if not math.isfinite(float(T.homogeneous.sum())):
        raise InputError("a pose holds a value that is not a finite number")
    return pin.SE3(T)


def transform(T_a_b: pin.SE3, p_b: Floats) -> Floats:
    """Points (..., 3) [m] of frame b in frame a."""
    return p_b @ T_a_b.rotation.T + T_a_b.translation


def shift_and_turn(T: pin.SE3) -> tuple[float, float]:
    """How far a motion shifts [m], and by how much it turns [rad]."""
    return float(np.linalg.norm(T.translation)), float(np.linalg.norm(pin.log3(T.rotation)))


def motions_moved(by: Floats) -> Floats:
    """The matrix (6, 6) that takes small motions at a point to those at one `by` (3,) [m] from it.

    A small motion (6,) [m, rad] is the shift of its point, then a rotation.
    """
    matrix = np.eye(6)
    matrix[:3, 3:] = -pin.skew(by)
    return matrix


def spread_directions(count: int) -> Floats:
    """Unit vectors (count, 3) spread evenly: a Fibonacci spiral on the sphere."""
    k = np.arange(count) + 0.5
    z = 1 - 2 * k / count
    angle = np.pi * (1 + np.sqrt(5)) * k
    radius = np.sqrt(1 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=1)


def pose_from_matrix(matrix: ArrayLike) -> pin.SE3:
    """A pose from a matrix (3, 4) or (4, 4), which is [R | t]: R has no unit, t is in m.

    Raises:
        InputError: wrong shape, not finite, or R is not a rotation (tolerance 1e-3; what
            is within it is replaced by the nearest rotation, as files carry few digits).
    """
    T = np.asarray(matrix, dtype=np.float64)
    if T.shape not in ((3, 4), (4, 4)):
        raise InputError(f"a pose needs a 3 x 4 or 4 x 4 matrix, not one of shape {T.shape}")
    if not np.all(np.isfinite(T)):
        raise InputError("a pose holds a value that is not a finite number")
    if T.shape == (4, 4) and not np.allclose(T[3], (0, 0, 0, 1), atol=1e-9):
        raise InputError(f"the last row of a pose must be 0 0 0 1, not {T[3].tolist()}")
    R = T[:3, :3]
    # Squares of huge numbers would overflow.
    if (
        np.abs(R).max() > 2.0
        or not np.allclose(R @ R.T, np.eye(3), atol=1e-3)
        or np.linalg.det(R) < 0.5
    ):
        raise InputError("the rotation part of a pose is not a rotation matrix")
    if np.abs(R @ R.T - np.eye(3)).max() > 1e-12:
        u, _, vt = np.linalg.svd(R)
        R = u @ vt
    return pin.SE3(R, T[:3, 3].copy())


def pose_from_rpy(xyz: ArrayLike, rpy: ArrayLike = (0.0, 0.0, 0.0)) -> pin.SE3:
    """A pose from a position (3,) [m] and fixed-axis roll, pitch, yaw (3,) [rad], as in URDF."""
    roll, pitch, yaw = np.asarray(rpy, dtype=np.float64)
    return pin.SE3(pin.rpy.rpyToMatrix(roll, pitch, yaw), np.asarray(xyz, dtype=np.float64))


# Every shape carries its kind, so that two kinds with the same measures differ in their digest.


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """A cuboid centred on its frame; `size` (3,) [m]: full lengths along x, y, z."""

    size: Floats
    kind: Literal["box"] = field(default="box", init=False)

    def __post_init__(self) -> None:
        own(self, "size")


@dataclass(frozen=True, slots=True, eq=False)
class Cylinder:
    """A cylinder centred on its frame, axis z."""

    radius: float
    length: float
    kind: Literal["cylinder"] = field(default="cylinder", init=False)


@dataclass(frozen=True, slots=True, eq=False)
class Capsule:
    """A cylinder with half spheres on both ends; `length` [m] is that of the cylinder alone."""

    radius: float
    length: float
    kind: Literal["capsule"] = field(default="capsule", init=False)


@dataclass(frozen=True, slots=True, eq=False)
class Sphere:
    """A ball centred on its frame."""

    radius: float
    kind: Literal["sphere"] = field(default="sphere", init=False)


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """Triangles; `points` (n, 3) [m], `triangles` (m, 3) indices, counter-clockwise outside.

    `is_convex` says that the triangles bound a convex body, which the collision checker may
    then treat as solid.  Where such a body has `pieces`, convex meshes in its frame, it only goes
    around these: what comes too near to it is checked with each of them.
    """

    points: Floats
    triangles: Ints
    is_convex: bool = False
    kind: Literal["mesh"] = field(default="mesh", init=False)
    pieces: "tuple[Mesh, ...]" = field(default=(), metadata={"later": True})

    def __post_init__(self) -> None:
        put(
            self,
            points=frozen(self.points).reshape(-1, 3),
            triangles=frozen(self.triangles, np.int32).reshape(-1, 3),
        )

    @property
    def middle(self) -> Floats:
        """Of the box around it (3,) [m]."""
        return (self.points.min(axis=0) + self.points.max(axis=0)) / 2

    @property
    def diameter(self) -> float:
        """Of the ball about its middle that holds it [m]: no two points are farther apart."""
        return 2 * float(np.linalg.norm(self.points - self.middle, axis=1).max())


Shape = Box | Cylinder | Capsule | Sphere | Mesh


def pieces_of(shape: Shape) -> tuple[Shape, ...]:
    """The convex pieces that a shape goes around; where it has none, itself."""
    return (isinstance(shape, Mesh) and shape.pieces) or (shape,)


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """A named shape fixed in the frame of what owns it (a link, a fixture, a part, a tool)."""

    name: str
    shape: Shape
    T_owner_shape: pin.SE3
    colour: tuple[float, float, float] = (0.7, 0.7, 0.72)

    def __post_init__(self) -> None:
        own(self, "T_owner_shape")

    @property
    def reach(self) -> float:
        """How far [m] its farthest point is, at most, from the origin of what owns it."""
        away = float(np.linalg.norm(self.T_owner_shape.translation))
        match self.shape:
            case Box(size=size):
                return away + float(np.linalg.norm(size)) / 2
            case Sphere(radius=radius):
                return away + radius
            case Cylinder(radius=radius, length=length):
                return away + float(np.hypot(radius, length / 2))
            case Capsule(radius=radius, length=length):
                return away + radius + length / 2
            case Mesh(points=points):
                T = self.T_owner_shape
                return float(np.linalg.norm(transform(T, points), axis=1).max())


def finest(solids: Iterable[Solid]) -> tuple[Solid, ...]:
    """Solids, and instead of those that only go around pieces these pieces."""
    return tuple(
        Solid(solid.name, shape, solid.T_owner_shape, solid.colour)
        for solid in solids
        for shape in pieces_of(solid.shape)
    )


FLAT_CORNER = 0.2
"""Of a corner's largest: below this share of it faces around a corner count as in one plane, here
those of round things: small errors of their normals would move it far."""

NORMAL_DIGITS = 4
"""By which normals are those of one face."""


def outwards(vertices: Floats, triangles: Ints, level: float = FLAT_CORNER) -> Floats:
    """How vertices (n, 3) [m] move while all faces move outwards by one metre, (n, 3), no unit.

    Args:
        vertices: each place once, or the surface has gaps there.
        triangles: (m, 3) their indices.
        level: see `FLAT_CORNER`; less for exact meshes.
    """
    corners = vertices[triangles]
    crossed = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(crossed, axis=1)
    has_area = lengths > 0
    units = np.round(crossed[has_area] / lengths[has_area, None], NORMAL_DIGITS)
    # Of each vertex the directions of its faces, however many triangles a face has.
    numbers = triangles[has_area].reshape(-1, 1)
    rows = np.unique(np.hstack([numbers, np.repeat(units, 3, axis=0)]), axis=0)
    owner, normals = rows[:, 0].astype(int), rows[:, 1:]
    squares, sums = np.zeros((len(vertices), 3, 3)), np.zeros((len(vertices), 3))
    np.add.at(squares, owner, normals[:, :, None] * normals[:, None, :])
    np.add.at(sums, owner, normals)
    # The corner of faces that have moved: along each of their normals by the same distance.
    inverses = np.linalg.pinv(squares, rcond=level**2, hermitian=True)
    moves = np.einsum("nij,nj->ni", inverses, sums)
    return moves
