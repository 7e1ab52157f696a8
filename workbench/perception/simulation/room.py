"""Whether parts fit into a bin at all: asked before physics is, and without it."""

from collections.abc import Sequence

import numpy as np

from workbench.model.errors import InputError
from workbench.model.messages.parts import PileText
from workbench.model.part import Bin, Part

FULL = 0.6
"""Share of the bin that parts can fill: long ones lie more loosely than that."""


def check_room(parts: Sequence[Part], bin: Bin) -> None:
    """Look whether parts fit into a bin at all, one by one and together.

    Raises:
        InputError: one is longer than the bin, or together they fill too much of it.
    """
    for part in parts:
        if 2 * radius_of(part) > float(np.linalg.norm(bin.size[:2])):
            raise InputError(PileText.TOO_LARGE(part=part.name))
    room = float(np.prod(bin.size)) * FULL
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


def _volume(part: Part) -> float:
    """Of the part [m3], by the divergence theorem."""
    a, b, c = part.mesh.points[part.mesh.triangles.T]
    return abs(float(np.einsum("ni,ni->", a, np.cross(b, c)))) / 6
