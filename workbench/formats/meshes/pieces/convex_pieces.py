"""A mesh as few convex pieces that cover it, and by how much they are larger.

Convex pieces are what the collision checker is quick and sure with.  What was cut once is kept.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from workbench.formats.meshes.mesh_cache import (
    Arrays,
    content_of,
    load_or_make,
    pack_meshes,
    recipe,
    unpack_meshes,
)
from workbench.formats.meshes.triangles import surface_of
from workbench.model.geometry import Mesh, Solid

OVER = 4.0
"""Pieces into which a mesh is split, per piece that may be left once some are joined."""

ASKED = ("scipy", "trimesh")
"""Distributions whose version decides what comes out."""


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Convex meshes that together cover a mesh.

    `excess` [m]: how far their surface lies from that of the mesh at most, seen at samples.
    """

    pieces: tuple[Mesh, ...]
    excess: float


def pieces_of(mesh: Mesh, *, tolerance: float, most: int = 32, over: float = OVER) -> Pieces | None:
    """Convex pieces that cover a mesh and follow it closely.

    Args:
        mesh: any triangles; they need not close.
        tolerance: [m] pieces are divided until none is by more too large, or there are `most`.
        most: pieces at most.
        over: see `OVER`; the time it takes grows with it.

    Returns:
        None when all points lie in one plane.
    """

    def make() -> Arrays | None:
        # It takes a while to import, and is seldom needed.
        from workbench.formats.meshes.pieces import splitting

        found = splitting.split(mesh, tolerance, most, over)
        return found and {**pack_meshes(found[0]), "excess": np.array(found[1])}

    found = load_or_make(
        f"pieces {recipe(*ASKED)} {tolerance!r} {most} {over!r}", content_of(mesh), make
    )
    return None if found is None else Pieces(unpack_meshes(found), float(found["excess"]))


def excess_of(mesh: Mesh, solids: Iterable[Solid]) -> float:
    """How far solids stick out of a mesh at most [m], about.

    Seen at points on all their faces, to within a twentieth of a millimetre.

    Args:
        mesh: any triangles; they need not close.
        solids: in the frame of the mesh; where one goes around pieces, these count.
    """
    from workbench.formats.meshes.pieces import splitting

    return splitting.excess_of(mesh, surface_of(solids).triangles)


def groups_of(mesh: Mesh, pieces: Pieces, *, tolerance: float, most: int) -> tuple[Mesh, ...]:
    """The pieces of a mesh in few groups, each a convex mesh that goes around its pieces.

    Args:
        mesh: see `pieces_of`.
        pieces: of it.
        tolerance: [m] a group may be by this too large, or by more where else there were too many.
        most: groups.
    """
    if len(pieces.pieces) <= most:
        return pieces.pieces

    def make() -> Arrays:
        from workbench.formats.meshes.pieces import splitting

        groups = splitting.group_pieces(mesh, pieces.pieces, tolerance, most)
        flat = [part for group in groups for part in (group, *group.pieces)]
        return {**pack_meshes(flat), "sizes": np.array([len(group.pieces) for group in groups])}

    content = [part for piece in (mesh, *pieces.pieces) for part in content_of(piece)]
    found = load_or_make(f"groups {recipe(*ASKED)} {tolerance!r} {most}", content, make) or {}
    flat, groups = list(unpack_meshes(found)), list[Mesh]()
    for size in found["sizes"].tolist():
        around, inside = flat[0], tuple(flat[1 : 1 + size])
        del flat[: 1 + size]
        groups.append(Mesh(around.points, around.triangles, True, inside))
    return tuple(groups)


def hull_of(mesh: Mesh) -> Mesh | None:
    """The convex hull of a mesh, or one around it where that has too many edges at one corner.

    None when all points lie in one plane.
    """

    def make() -> Arrays | None:
        from workbench.formats.meshes.pieces import hulls

        hull = hulls.hull(mesh)
        return hull and pack_meshes([hull])

    found = load_or_make(f"hull {recipe(*ASKED)}", content_of(mesh), make)
    return None if found is None else unpack_meshes(found)[0]
