"""A robot where it stands, and still things around it, as files of other programs have them."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.formats.meshes.pieces.convex_pieces import pieces_of
from workbench.model.cell import Fixture
from workbench.model.geometry import Mesh, Solid
from workbench.model.part import Bin
from workbench.model.robot import Robot


@dataclass(frozen=True, slots=True, eq=False)
class RobotInPlace:
    """One robot where it stands, and still things."""

    robot: Robot
    T_world_robot: pin.SE3
    things: tuple[Fixture, ...]


def box_around(thing: Fixture) -> Bin:
    """An open box as large as a thing, for a world's bin, with the usual walls."""
    wall = 0.003
    points = np.vstack(
        [
            solid.T_owner_shape.act(point)
            for solid in thing.solids
            if isinstance(solid.shape, Mesh)
            for point in solid.shape.points
        ]
    )
    low, high = points.min(axis=0), points.max(axis=0)
    middle = np.array([*(low[:2] + high[:2]) / 2, low[2] + wall])
    size = np.maximum(high - low - [2 * wall, 2 * wall, wall], 0.01)
    return Bin(thing.T_world_fixture * pin.SE3(np.eye(3), middle), size, wall)


def in_pieces(thing: Fixture, *, tolerance: float, most: int) -> Fixture:
    """A thing with convex pieces instead of its meshes; see `convex_pieces.pieces_of`."""
    solids: list[Solid] = []
    for solid in thing.solids:
        found = None
        if isinstance(solid.shape, Mesh):
            found = pieces_of(solid.shape, tolerance=tolerance, most=most)
        pieces = (solid.shape,) if found is None else found.pieces
        solids += [
            Solid(f"{thing.name}_piece_{k}", piece, solid.T_owner_shape, solid.colour)
            for k, piece in enumerate(pieces, start=1)
        ]
    return Fixture(thing.name, thing.T_world_fixture, tuple(solids))
