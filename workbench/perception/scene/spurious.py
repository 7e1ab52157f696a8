"""Which unexplained points are real, and which are errors of the scanner.

A scanner decodes single pixels wrongly.  A pixel that lies half on one surface and half on the next
measures a depth between the two.  A real object covers several neighbouring pixels.  So a point is
real if enough reliable area was seen around it, and its neighbours are real, too.
"""

import numpy as np
import open3d as o3d

from workbench.model.geometry import Bools, Floats, Ints
from workbench.perception.scene.voxels import Blocks, Voxels
from workbench.perception.views.surfaces import rays_of

NARROWEST = 0.004
"""[m] Of the blocks in which area is counted: with their neighbours they are three times that."""

LEAST_AREA = 6e-6
"""[m2] Area that is believed: a pin of 3 mm, if the scanner sees that fine."""

FEWEST_PIXELS = 5
"""Pixels that are believed, however large they are."""

SURE_SHARE = 0.6
"""Share of a whole surface from which on nobody asks whether it is a mistake."""

MIXED_PIXELS = 1.5
"""Pixels from a point to where the surfaces are that it may be mixed of."""

FEWEST_POINTS = 50
"""With fewer points nothing is known of how dense they are."""

MOST_POINTS = 50_000
"""Points by which that is measured; of more of them every second, third, ... is left out."""

A_CELL = 30
"""Points in a cell of the grid by which their density is measured, on average."""

_CLOCK = np.linspace(0.0, 2 * np.pi, 8, endpoint=False)


def pixel_angle(points: Floats, chosen: Ints) -> float:
    """The angle [rad] between neighbouring points, as the one in the middle of all sees it.

    It is 0 where fewer than `FEWEST_POINTS` points are there.

    Args:
        points: (n, 3) [m] in the scanner's frame, organised or not.
        chosen: (m,) which of them count, as indices.
    """
    step = max(1, len(chosen) // MOST_POINTS)
    some = points[chosen[::step]]
    far = np.linalg.norm(some, axis=1)
    some, far = some[far > 0], far[far > 0]
    if len(some) < FEWEST_POINTS:
        return 0.0
    ahead = np.mean(some / far[:, None], axis=0)
    across = np.linalg.svd(ahead[None])[2][1:]
    depth = some @ (ahead / np.linalg.norm(ahead))
    is_ahead = depth > 0.1 * far
    flat = (some[is_ahead] @ across.T) / depth[is_ahead, None]
    low, high = np.quantile(flat, (0.02, 0.98), axis=0)
    width, height = np.maximum(high - low, 1e-6)
    size = float(np.sqrt(width * height * A_CELL / len(flat)))
    rows = int(height / size) + 1
    index = np.floor((flat[np.all((flat >= low) & (flat <= high), axis=1)] - low) / size)
    place = index.astype(np.int64) @ np.array([rows, 1])
    counts = np.bincount(place)
    # By points, not by cells: empty edges of the picture do not make its middle less dense.
    return size / float(np.sqrt(np.median(counts[place]) * step))


def believed(
    voxels: Voxels,
    eye: Floats,
    angle: float,
    pitch: float,
    known: o3d.t.geometry.RaycastingScene,
) -> Bools:
    """Which voxels (n,) hold something.

    Args:
        voxels: points that nothing explains.
        eye: (3,) [m] where they were seen from.
        angle: between pixels [rad]; 0: not known.
        pitch: between points on what the scanner looks at [m].
        known: the surfaces that are known, in the frame of the voxels.
    """
    if angle == 0.0:
        # How dense they are nobody knows: all of them, or so few that they are no thing.
        return np.full(len(voxels.counts), voxels.counts.sum() >= FEWEST_PIXELS)
    width = max(2, int(np.ceil(max(NARROWEST, 2 * pitch) / voxels.edge)))
    blocks = Blocks(voxels, width)
    seen = blocks.sums(voxels.counts)
    area = max(pitch, 1e-6) ** 2
    enough = max(FEWEST_PIXELS, LEAST_AREA / area)
    whole = (3 * width * voxels.edge) ** 2 / area
    weights = voxels.counts.copy()
    # Alone they are too few even with their neighbours' help, or enough without asking.
    doubtful = np.flatnonzero(seen < max(enough, SURE_SHARE * whole))
    mixed = _may_be_mixed(voxels.centres[doubtful], eye, angle, known)
    weights[doubtful[mixed]] = 0
    core = blocks.sums(weights) >= enough
    return blocks.sums(core & (weights > 0)) > 0


def _may_be_mixed(
    points: Floats, eye: Floats, angle: float, known: o3d.t.geometry.RaycastingScene
) -> Bools:
    """Whether points (n, 3) lie between known surfaces that neighbouring pixels see, (n,)."""
    if len(points) == 0:
        return np.zeros(0, np.bool_)
    ahead = points - eye
    across = np.cross(ahead, np.eye(3)[np.argmin(np.abs(ahead), axis=1)])
    across /= np.linalg.norm(across, axis=1)[:, None]
    other = np.cross(ahead, across)  # as long as the way to the point
    across *= np.linalg.norm(ahead, axis=1)[:, None]
    spread = np.cos(_CLOCK)[:, None] * across[:, None] + np.sin(_CLOCK)[:, None] * other[:, None]
    rays = rays_of(eye, (ahead[:, None] + MIXED_PIXELS * angle * spread).reshape(-1, 3))
    hits = known.cast_rays(rays, nthreads=1)["t_hit"].numpy().reshape(-1, len(_CLOCK))
    return (hits.min(axis=1) < 1.0) & (hits.max(axis=1) > 1.0)
