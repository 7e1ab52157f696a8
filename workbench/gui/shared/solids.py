"""Solids as triangles with hard edges, ready to be drawn."""

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
import pinocchio as pin
import trimesh

from workbench.formats.meshes.triangles import join_surfaces, triangles_of
from workbench.model.geometry import Floats, Ints, Solid

Colour = tuple[int, int, int]
"""Red, green, blue, 0..255."""

SHARP = np.deg2rad(35.0)
"""Edges that turn more than this are drawn as edges, others as smooth surface."""


def with_hard_edges(surface: trimesh.Trimesh) -> tuple[Floats, Ints]:
    """Points (n, 3) [m] and triangles (m, 3), points doubled where the surface has an edge.

    The page computes one normal a point, so an edge needs a point for each of its sides.
    """
    surface.merge_vertices()
    parted = trimesh.graph.smooth_shade(surface, angle=SHARP)
    return np.asarray(parted.vertices), np.asarray(parted.faces, dtype=np.int32)


def by_colour(
    solids: Iterable[Solid], T: pin.SE3 | None = None
) -> list[tuple[Colour, Floats, Ints]]:
    """The solids of one body merged into one mesh a colour, in the body's frame moved by `T`.

    With each colour come points (n, 3) [m] and triangles (k, 3), indices into them.
    """
    groups: defaultdict[Colour, list[trimesh.Trimesh]] = defaultdict(list)
    for solid in solids:
        surface = triangles_of(solid.shape)
        pose = solid.T_owner_shape if T is None else T * solid.T_owner_shape
        surface.apply_transform(pose.homogeneous)
        groups[rgb(solid.colour)].append(surface)
    return [
        (colour, *with_hard_edges(join_surfaces(surfaces))) for colour, surfaces in groups.items()
    ]


def rgb(colour: tuple[float, float, float]) -> Colour:
    """A colour of the model, 0..1, as the page takes it."""
    red, green, blue = (round(255 * min(max(value, 0.0), 1.0)) for value in colour)
    return red, green, blue
