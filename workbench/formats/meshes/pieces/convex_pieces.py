"""A mesh as few convex pieces that cover it, and by how much they are larger.

Convex pieces are what the collision checker is quick and sure with.  What was cut once is kept.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.formats.meshes.kept import Arrays, content_of, kept, packed, recipe, unpacked
from workbench.model.geometry import Mesh

ASKED = ("coacd", "scipy", "trimesh")
"""Distributions whose version decides what comes out."""


@dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """Convex meshes that together cover a mesh.

    `excess` [m]: how far their surface lies from that of the mesh at most, seen at samples.
    """

    pieces: tuple[Mesh, ...]
    excess: float


def pieces_of(mesh: Mesh, *, tolerance: float, most: int = 8) -> Pieces | None:
    """Convex pieces that cover a mesh.

    Args:
        mesh: any triangles; they need not close.
        tolerance: [m] a hull that is no more than this too large is taken as it is.
        most: pieces to divide it into otherwise.

    Returns:
        None when all points lie in one plane.
    """

    def cut() -> tuple[tuple[Mesh, ...], float] | None:
        # It takes a while to import, and is seldom needed.
        from workbench.formats.meshes.pieces import cutting

        return cutting.cut(mesh, tolerance, most)

    return _kept_pieces(f"pieces {recipe(*ASKED)} {tolerance!r} {most}", mesh, cut)


def split_pieces_of(mesh: Mesh, *, tolerance: float, most: int = 32) -> Pieces | None:
    """Convex pieces that cover a mesh and follow it closely, made quickly by cuts along planes.

    Args:
        mesh: any triangles; they need not close.
        tolerance: [m] pieces are divided until none is by more too large, or there are `most`.
        most: pieces at most.

    Returns:
        None when all points lie in one plane.
    """

    def cut() -> tuple[tuple[Mesh, ...], float] | None:
        from workbench.formats.meshes.pieces import splitting

        return splitting.split(mesh, tolerance, most)

    return _kept_pieces(f"split {recipe(*ASKED)} {tolerance!r} {most}", mesh, cut)


def _kept_pieces(
    name: str, mesh: Mesh, cut: Callable[[], tuple[tuple[Mesh, ...], float] | None]
) -> Pieces | None:
    """The pieces of a mesh and their excess, from the cache where they are in it."""

    def made() -> Arrays | None:
        found = cut()
        return found and {**packed(found[0]), "excess": np.array(found[1])}

    found = kept(name, content_of(mesh), made)
    return None if found is None else Pieces(unpacked(found), float(found["excess"]))


def hull_of(mesh: Mesh) -> Mesh | None:
    """The convex hull of a mesh, or one around it where that has too many edges at one corner.

    None when all points lie in one plane.
    """

    def made() -> Arrays | None:
        from workbench.formats.meshes.pieces import cutting

        hull = cutting.hull(mesh)
        return hull and packed([hull])

    found = kept(f"hull {recipe(*ASKED)}", content_of(mesh), made)
    return None if found is None else unpacked(found)[0]
