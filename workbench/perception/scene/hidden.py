"""Where a partly seen object may extend unseen: below and behind the parts that were found.

An object can extend only where the scanner sees nothing.  So the space that found parts hide
belongs to it if it is connected with the seen points and within the object's reach.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import open3d as o3d
from scipy.ndimage import distance_transform_edt, label

from workbench.model.geometry import Bools, Floats, Ints
from workbench.perception.views.surfaces import rays_of

SMALLEST_CUBE = 0.004
"""[m] Edge of the cubes that the room is divided into."""

MOST_CUBES = 200_000
"""Cubes; where there are more they are larger."""

BELOW = 0.001
"""[m] What goes on below a part stays this far from it: it is in touch with it at most."""


@dataclass(frozen=True, slots=True, eq=False)
class Room:
    """Where things may go on unseen, in the frame of the bin.

    Attributes:
        parts: that were found.
        eye: (3,) [m] where the scanner is.
        half: (2,) [m] half of the bin's length and width.
        top: [m] height of the highest part.
        reach: [m] no thing goes on further than this from what was seen of it.
    """

    parts: o3d.t.geometry.RaycastingScene
    eye: Floats
    half: Floats
    top: float
    reach: float


@dataclass(frozen=True, slots=True, eq=False)
class _Cubes:
    """The room near what was seen, in cubes.

    `seen` (a, b, c) is where things are, from what was seen of them down to the floor.  The first
    of the cubes is that of the whole numbers `first` (2,) on the floor, and they are `edge` [m].
    """

    seen: Bools
    first: Ints
    edge: float

    @property
    def centres(self) -> Floats:
        """The middle (a, b, c, 3) [m] of each."""
        index: Any = np.moveaxis(np.indices(self.seen.shape), 0, -1)
        return (index + (*self.first, 0) + 0.5) * self.edge


def hidden_columns(cells: Ints, tops: Floats, edge: float, room: Room) -> tuple[Ints, Floats]:
    """More grid cells (m, 2), seen from above, and heights (m,) [m] up to which things may go on.

    Args:
        cells: (n, 2) whole numbers, where something was seen, of a grid seen from above.
        tops: (n,) its height in each [m].
        edge: of a grid cell [m].
        room: where things may go on.
    """
    middles = (cells + 0.5) * edge
    is_inside = np.all(np.abs(middles) <= room.half, axis=1)
    cells, tops = cells[is_inside], tops[is_inside]
    cubes = _cubes(cells, tops, edge, room) if len(cells) else None
    goes_on = np.zeros((1, 1, 1), np.bool_) if cubes is None else _goes_on(cubes, room)
    if cubes is None or not goes_on.any():
        return np.empty((0, 2), np.int64), np.empty(0)
    columns = np.argwhere(goes_on.any(axis=2))
    a, b = columns.T
    highest = goes_on.shape[2] - 1 - np.argmax(goes_on[a, b, ::-1], axis=1)
    over = _room_above(cubes.centres[a, b, highest], room.parts)
    heights = (highest + 0.5) * cubes.edge + np.minimum(cubes.edge / 2, over - BELOW)
    wide = round(cubes.edge / edge)
    within = np.argwhere(np.ones((wide, wide)))
    more = ((columns + cubes.first)[:, None] * wide + within).reshape(-1, 2)
    return more, np.repeat(heights, len(within))


def _cubes(cells: Ints, tops: Floats, edge: float, room: Room) -> _Cubes | None:
    """The room around cells (n, 2) of things with heights (n,), each cube some cells wide.

    None where no part is high enough to hide anything.
    """
    height = min(room.top, float(tops.max()) + room.reach)
    if height <= 0.0:
        return None
    low = np.maximum(cells.min(axis=0) * edge - room.reach, -room.half)
    high = np.minimum((cells.max(axis=0) + 1) * edge + room.reach, room.half)
    volume = float(np.prod(high - low)) * height
    wide = int(np.ceil(max(SMALLEST_CUBE, float(np.cbrt(volume / MOST_CUBES))) / edge))
    cube = wide * edge
    first = np.floor(low / cube).astype(np.int64)
    across = np.ceil(high / cube).astype(np.int64) - first
    seen = np.zeros((*across, int(np.ceil(height / cube))), np.bool_)
    levels = np.ceil(tops / cube).astype(np.int64)
    for (a, b), level in zip(cells // wide - first, levels, strict=True):
        seen[a, b, : max(level, 1)] = True
    return _Cubes(seen, first, cube)


def _goes_on(cubes: _Cubes, room: Room) -> Bools:
    """The cubes (a, b, c) in which things may go on: hidden, joined to what was seen, and near."""
    away: Any = distance_transform_edt(~cubes.seen)
    is_asked = ~cubes.seen & (away * cubes.edge <= room.reach)
    is_hidden = np.zeros(cubes.seen.shape, np.bool_)
    is_hidden[is_asked] = _hidden(cubes.centres[is_asked], room)
    joined: Any = label(is_hidden | cubes.seen, structure=np.ones((3, 3, 3)))
    return is_hidden & np.isin(joined[0], np.unique(joined[0][cubes.seen]))


def _hidden(points: Floats, room: Room) -> Bools:
    """Whether parts stand before points (n, 3) [m], which are not within them, (n,)."""
    rays = rays_of(room.eye, points - room.eye)
    found = room.parts.cast_rays(rays, nthreads=1)["t_hit"].numpy() < 1.0
    behind = np.ascontiguousarray(points[found], dtype=np.float32)
    within = room.parts.compute_occupancy(o3d.core.Tensor(behind), nthreads=1).numpy()
    found[found] = within < 0.5
    return found


def _room_above(points: Floats, parts: o3d.t.geometry.RaycastingScene) -> Floats:
    """How far it is from points (n, 3) up to a part, (n,) [m]; infinite where there is none."""
    up = np.broadcast_to((0.0, 0.0, 1.0), points.shape)
    return parts.cast_rays(rays_of(points, up), nthreads=1)["t_hit"].numpy().astype(float)
