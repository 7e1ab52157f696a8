"""Whether parts fit into a bin at all: asked before physics is, and without it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Mesh
from workbench.model.messages.parts import PileText
from workbench.model.part import Bin, GraspLibrary, Part
from workbench.model.symmetry import Symmetry

FILLED_SHARE = 0.6
"""Share of the bin that parts can fill; long parts lie more loosely."""


def check_room(parts: Sequence[Part], bin: Bin) -> None:
    """Look whether parts fit into a bin at all, one by one and together.

    Raises:
        InputError: one is longer than the bin, or together they fill too much of it.
    """
    for part in dict.fromkeys(parts):
        if 2 * radius_of(around_frame(part)[0]) > float(np.linalg.norm(bin.size[:2])):
            size, room = (sides * 1000 for sides in (np.ptp(part.mesh.points, axis=0), bin.size))
            sizes = {"size": _sides(size), "room": _sides(room)}
            raise InputError(PileText.TOO_LARGE(part=part.name, **sizes))
    room = float(np.prod(bin.size)) * FILLED_SHARE
    volume = sum(_volume(part) for part in parts)
    if volume > room:
        most = int(len(parts) * room / volume)
        raise InputError(PileText.TOO_MANY(count=len(parts), parts=kinds_of(parts), most=most))


def kinds_of(parts: Sequence[Part]) -> tuple[str, ...]:
    """The kinds of parts by their names, each once."""
    return tuple(dict.fromkeys(part.name for part in parts))


def radius_of(part: Part) -> float:
    """Of the ball about the part's frame that holds it [m]."""
    return float(np.linalg.norm(part.mesh.points, axis=1).max())


@lru_cache(maxsize=16)
def around_frame(part: Part) -> tuple[Part, pin.SE3]:
    """A part, without grasps, whose frame lies in it: physics turns it about that.

    Files of CAD often have their origin far off, as in an assembly.

    Returns:
        The part itself where its origin lies in the box around it, else one with the frame at its
        middle; and that frame, seen from the part's own.
    """
    points = np.asarray(part.mesh.points)
    if np.all(points.min(axis=0) <= 0.0) and np.all(points.max(axis=0) >= 0.0):
        return part, pin.SE3.Identity()
    away = pin.SE3(np.eye(3), -part.mesh.middle)
    moved = replace(
        part,
        mesh=Mesh(points + away.translation, part.mesh.triangles),
        pieces=tuple(
            replace(solid, T_owner_shape=away * solid.T_owner_shape) for solid in part.pieces
        ),
        symmetry=Symmetry(),
        library=GraspLibrary(),
    )
    return moved, away.inverse()


def _sides(size: Floats) -> str:
    return " x ".join(f"{side:.0f}" for side in size)


def _volume(part: Part) -> float:
    """Of the part [m3], by the divergence theorem."""
    a, b, c = part.mesh.points[part.mesh.triangles.T]
    return abs(float(np.einsum("ni,ni->", a, np.cross(b, c)))) / 6
