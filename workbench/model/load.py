"""What an arm carries: mass, centre of gravity and inertia of its tool, and of a part in it.

Everything here follows from the cell and from how a part lies in the hand.  What a tool does not
state is estimated from its solids, and a part's mass is spread evenly over its mesh.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.cell import Tool
from workbench.model.digest import LATER
from workbench.model.errors import InputError
from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Floats,
    Mesh,
    Shape,
    Solid,
    Sphere,
    finest,
    own,
)
from workbench.model.messages.cells import LoadText
from workbench.model.messages.message import Message
from workbench.model.part import Part

ROUNDING = 1e-6
"""[share] Rounding that a matrix of inertia may have."""

Moments = tuple[float, Floats, Floats]
"""Volume [m3], its middle (3,) [m], and the integral (3, 3) [m5] of p p^T over it."""


@dataclass(frozen=True, slots=True, eq=False)
class Load:
    """A rigid body on a flange: `mass` [kg], its `centre` (3,) [m] of gravity in the flange frame.

    `inertia` (3, 3) [kg m2] is about that centre, along the axes of the flange frame.
    """

    mass: float
    centre: Floats
    inertia: Floats

    def __post_init__(self) -> None:
        own(self, "centre", "inertia")
        if problem := load_problem(self.mass, self.centre, self.inertia):
            raise InputError(LoadText.IMPOSSIBLE(problem=problem))

    @property
    def words(self) -> Message:
        """For people: `0.23 kg, centre of gravity 0, 0, 62 mm from the flange`."""
        x, y, z = (f"{1000 * value + 0.0:.0f}" for value in self.centre)
        return LoadText.LOAD(mass=f"{self.mass:.3g}", x=x, y=y, z=z)

    def seen_from(self, T_flange_owner: pin.SE3) -> "Load":
        """The same body in the flange frame, where this one is in the frame of its owner."""
        R = T_flange_owner.rotation
        inertia = R @ self.inertia @ R.T
        return Load(self.mass, T_flange_owner.act(self.centre), (inertia + inertia.T) / 2)


@dataclass(frozen=True, slots=True, eq=False)
class Loads:
    """What an arm carries: its `tool`, and the `part` in it, both in the flange frame.

    `part` is None of an arm that takes no part; of one that drops back what it holds it stands for
    that.  `new_tool` is what it changes its tool for.
    """

    tool: Load
    part: Load | None
    new_tool: Load | None = field(default=None, metadata=LATER)

    def carried(self, holding: bool) -> Load:
        """The tool alone, or the tool with the part in it."""
        if not holding or self.part is None:
            return self.tool
        return together((self.tool, self.part))

    @property
    def words(self) -> Message:
        """For people."""
        if self.part is None:
            return self.tool.words
        return LoadText.BOTH(tool=self.tool.words, both=self.carried(True).words)


def load_problem(mass: float, centre: Floats, inertia: Floats) -> Message | None:
    """Why no body has this mass [kg], centre (3,) [m] and inertia (3, 3) [kg m2]; else None."""
    if not (np.isfinite(mass) and mass > 0):
        return LoadText.MASS(mass=repr(mass))
    if np.shape(centre) != (3,) or not np.all(np.isfinite(centre)):
        return LoadText.CENTRE()
    if np.shape(inertia) != (3, 3) or not np.all(np.isfinite(inertia)):
        return LoadText.INERTIA()
    slack = ROUNDING * float(np.abs(inertia).max())
    if float(np.abs(inertia - inertia.T).max()) > slack:
        return LoadText.SYMMETRY()
    low, middle, high = np.linalg.eigvalsh(inertia)
    if low < -slack or low + middle < high - 3 * slack:
        return LoadText.MOMENTS()
    return None


def loads_of(tool: Tool, part: Part, T_tcp_part: pin.SE3) -> Loads | None:
    """What an arm carries, by its tool and by how a part lies in it.

    Args:
        tool: on the arm's flange.
        part: that it takes.
        T_tcp_part: where the part is in the hand.

    Returns:
        None where the mass of the tool is not stated: nobody knows what the arm carries.
    """
    mine = tool_load(tool)
    if mine is None:
        return None
    return Loads(mine, part_load(part).seen_from(tool.T_flange_tcp * T_tcp_part))


def tool_loads(tool: Tool) -> Loads | None:
    """What an arm carries that takes no part; None where the mass of the tool is not stated."""
    mine = tool_load(tool)
    return None if mine is None else Loads(mine, None)


def change_loads(old: Tool, new: Tool) -> Loads | None:
    """What an arm carries that changes its tool; None where a mass is not stated."""
    before, after = tool_load(old), tool_load(new)
    return None if before is None or after is None else Loads(before, None, after)


def tool_load(tool: Tool) -> Load | None:
    """The load of a tool as it is stated, and estimated from its solids where it is not.

    Fingers count as they are when closed.  Returns None where its mass is not stated.
    """
    if tool.mass is None:
        return None
    solids = (*tool.body, *(finger.solid for finger in tool.fingers))
    even = uniform_load(solids, tool.mass)
    return Load(
        tool.mass,
        even.centre if tool.centre_of_gravity is None else tool.centre_of_gravity,
        even.inertia if tool.inertia is None else tool.inertia,
    )


@lru_cache(maxsize=64)
def part_load(part: Part) -> Load:
    """The load of a part in its own frame, its mass spread evenly.

    Where its surface is open its convex pieces count.
    """
    if is_closed(part.mesh):
        return uniform_load((Solid(part.name, part.mesh, pin.SE3.Identity()),), part.mass)
    return uniform_load(finest(part.pieces), part.mass)


def uniform_load(solids: Iterable[Solid], mass: float) -> Load:
    """The load of solids of one density in the frame of their owner; overlaps count twice.

    Args:
        solids: one or more.
        mass: of all together [kg].
    """
    whole, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for solid in solids:
        volume, middle, square = _moments(solid.shape)
        R, p = solid.T_owner_shape.rotation, solid.T_owner_shape.translation
        turned, mixed = R @ middle, np.outer(p, R @ middle)
        whole += volume
        first += volume * (turned + p)
        second += R @ square @ R.T + volume * (np.outer(p, p) + mixed + mixed.T)
    centre = first / whole
    about = second / whole - np.outer(centre, centre)
    inertia = mass * (np.trace(about) * np.eye(3) - about)
    return Load(mass, centre, (inertia + inertia.T) / 2)


def together(loads: Iterable[Load]) -> Load:
    """Several bodies that are fixed to each other, as one."""
    those = tuple(loads)
    mass = sum(load.mass for load in those)
    centre = sum((load.mass * load.centre for load in those), np.zeros(3)) / mass
    inertia = np.zeros((3, 3))
    for load in those:
        off = load.centre - centre
        inertia += load.inertia + load.mass * (off @ off * np.eye(3) - np.outer(off, off))
    return Load(mass, centre, inertia)


def is_closed(mesh: Mesh) -> bool:
    """Whether the triangles bound a body: every edge has one neighbour, which runs the other way.

    Points at one place are one.  Outside must be outside: a mesh that is inside out is none.
    """
    places, numbers = np.unique(mesh.points, axis=0, return_inverse=True)
    triangles, count = numbers.reshape(-1).astype(np.int64)[mesh.triangles], len(places)
    edges = np.concatenate([triangles[:, k] for k in ([0, 1], [1, 2], [2, 0])])
    there, back = edges @ [count, 1], edges @ [1, count]
    is_whole = len(np.unique(there)) == len(there) and bool(np.isin(there, back).all())
    return is_whole and _mesh_moments(mesh)[0] > 0


def _moments(shape: Shape) -> Moments:
    """Of a shape in its own frame."""
    match shape:
        case Box(size=size):
            volume = float(np.prod(size))
            return volume, np.zeros(3), volume / 12 * np.diag(size**2)
        case Sphere(radius=radius):
            volume = 4 / 3 * np.pi * radius**3
            return volume, np.zeros(3), volume * radius**2 / 5 * np.eye(3)
        case Cylinder(radius=radius, length=length):
            volume = np.pi * radius**2 * length
            across, along = radius**2 / 4, length**2 / 12
            return volume, np.zeros(3), volume * np.diag([across, across, along])
        case Capsule(radius=radius, length=length):
            bar, ends = np.pi * radius**2 * length, 4 / 3 * np.pi * radius**3
            across = bar * radius**2 / 4 + ends * radius**2 / 5
            far = radius**2 / 5 + 3 / 8 * radius * length + length**2 / 4
            along = bar * length**2 / 12 + ends * far
            return bar + ends, np.zeros(3), np.diag([across, across, along])
        case _:
            found = _mesh_moments(shape)
            low, high = shape.points.min(axis=0), shape.points.max(axis=0)
            if found[0] > ROUNDING * float(np.prod(high - low)):
                return found
            # What bounds no body counts as the box around it.
            size, middle = np.maximum(high - low, 1e-6), (low + high) / 2
            volume, _, square = _moments(Box(size))
            return volume, middle, square + volume * np.outer(middle, middle)


def _mesh_moments(mesh: Mesh) -> Moments:
    """By the tetrahedra of each triangle and one point in the middle of all."""
    base = mesh.points.mean(axis=0)
    corners = (mesh.points - base)[mesh.triangles]
    volumes = np.linalg.det(corners) / 6
    volume, sums = float(volumes.sum()), corners.sum(axis=1)
    if volume == 0.0:
        return 0.0, base, np.zeros((3, 3))
    square = np.einsum("t,tki,tkj->ij", volumes, corners, corners)
    square += np.einsum("t,ti,tj->ij", volumes, sums, sums)
    off = (volumes @ sums) / 4 / volume
    mixed = volume * np.outer(base, off)
    square = square / 20 + volume * np.outer(base, base) + mixed + mixed.T
    return volume, base + off, square
