"""A scan as a picture, and parts drawn over it where they were found."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from scipy.ndimage import grey_dilation

from workbench.model.geometry import Floats, frozen, own, put
from workbench.model.scan import Scan
from workbench.perception.views.camera import Pinhole
from workbench.perception.views.rendering import rendered

PICTURE_WIDTH = 1280
"""[pixels] Width of a picture."""

POINTS_A_PIXEL = 1.0
"""Of the scan's own pixels, which are drawn as squares of the picture's."""

OUTLYING = 0.5
"""[percent] Of the points on each side may lie outside of the picture: stray ones."""

DARKEST, BRIGHTEST = 40.0, 215.0
"""Grey of what is farthest and nearest, where a scan has no colours."""

RELIEF, MOST_RELIEF = 6000.0, 40.0
"""Grey by which a slope of 1 m a pixel is brighter or darker, and at most."""

TINT = 0.25
"""Share of its own colour in the face of a part that is drawn."""

TINTS = (
    (255, 80, 80), (80, 230, 80), (90, 140, 255), (250, 230, 70), (240, 90, 240),
    (70, 230, 230), (255, 160, 60), (190, 160, 255),
)  # fmt: skip
"""Colours of parts, one after the other; then again from the first."""


@dataclass(frozen=True, slots=True, eq=False)
class PartOverlay:
    """A picture (rows, columns, 3) of bytes, and where each part's number belongs in it.

    `places` (n, 2) [pixels] are column and row of the middle of what is drawn of each part, NaN
    where it lies outside; `colours` (n, 3) of bytes are theirs.
    """

    picture: np.ndarray
    places: Floats
    colours: np.ndarray

    def __post_init__(self) -> None:
        own(self, "places")
        put(self, picture=frozen(self.picture, np.uint8), colours=frozen(self.colours, np.uint8))


def overlay(scan: Scan, parts: Sequence[tuple[trimesh.Trimesh, Floats]]) -> PartOverlay:
    """The scan as its scanner sees it, in its colours if it has some, with parts drawn over it.

    Args:
        scan: organised or not.
        parts: the surface of each [m], and its pose (4, 4) in the scanner's frame.
    """
    camera, times = _camera(scan.points)
    picture = np.repeat(np.repeat(_picture_of(scan, camera), times, axis=0), times, axis=1)
    shape = (picture.shape[0], picture.shape[1])
    large = Pinhole(camera.focal * times, (camera.centre + 0.5) * times - 0.5, shape)
    rays, (column, row) = large.rays(), map(float, large.centre)
    places, colours = np.full((len(parts), 2), np.nan), np.zeros((len(parts), 3))
    for k, (mesh, pose) in enumerate(parts):
        colours[k] = TINTS[k % len(TINTS)]
        v, u, depth, _, _ = rendered(
            np.array(pose, order="C"), frozen(mesh.vertices), frozen(mesh.faces, np.int64),
            bool(mesh.is_watertight), rays, large.focal, column, row,
        )  # fmt: skip
        drawn = np.isfinite(depth)
        if not drawn.any():
            continue
        window = picture[v : v + drawn.shape[0], u : u + drawn.shape[1]]
        inner = np.zeros_like(drawn)
        inner[2:-2, 2:-2] = drawn[:-4, 2:-2] & drawn[4:, 2:-2] & drawn[2:-2, :-4] & drawn[2:-2, 4:]
        window[drawn] = (1.0 - TINT) * window[drawn] + TINT * colours[k]
        window[drawn & ~inner] = colours[k]
        rows, columns = np.nonzero(drawn)
        places[k] = u + columns.mean(), v + rows.mean()
    return PartOverlay(picture.round(), places, colours)


def _camera(points: Floats) -> tuple[Pinhole, int]:
    """A camera whose pixels hold about a point each, and how many pixels of a picture they are."""
    flat = points[:, :2] / points[:, 2:]
    low, high = np.percentile(flat, (OUTLYING, 100 - OUTLYING), axis=0)
    margin = 0.03 * (high - low)
    low, high = low - margin, high + margin
    step = float(np.sqrt(np.prod(high - low) * POINTS_A_PIXEL / len(points)))
    step = max(step, float(high[0] - low[0]) / PICTURE_WIDTH)
    columns, rows = np.ceil((high - low) / step).astype(int) + 1
    camera = Pinhole(1.0 / step, -low / step, (int(rows), int(columns)))
    return camera, max(1, round(PICTURE_WIDTH / columns))


def _picture_of(scan: Scan, camera: Pinhole) -> Floats:
    """The scan's picture (rows, columns, 3), 0..255; black where nothing was measured."""
    rows, columns = camera.shape
    before = scan.points[:, 2] > 0
    points = scan.points[before]
    u, v = np.rint(points[:, :2] / points[:, 2:] * camera.focal + camera.centre).astype(int).T
    inside = (u >= 0) & (u < columns) & (v >= 0) & (v < rows)
    # The nearest point of a pixel is written last.
    order = np.flatnonzero(inside)[np.argsort(-points[inside, 2], kind="stable")]
    near = np.zeros(camera.shape)
    near[v[order], u[order]] = 1.0 / points[order, 2]
    if scan.colours is not None:
        picture = np.zeros((rows, columns, 3))
        picture[v[order], u[order]] = scan.colours[before][order]
    else:
        depths = points[order, 2]
        first, last = np.percentile(depths, (1, 99)) if len(depths) else (0.0, 1.0)
        share = np.clip((depths - first) / max(last - first, 1e-9), 0.0, 1.0)
        grey = np.zeros(camera.shape)
        grey[v[order], u[order]] = BRIGHTEST + (DARKEST - BRIGHTEST) * share
        grey = np.where(near > 0, grey, grey_dilation(grey, size=(3, 3)))
        deep = 1.0 / np.where(near > 0, near, np.nan)
        slope = np.nan_to_num(np.gradient(deep, axis=0) + np.gradient(deep, axis=1))
        grey = np.clip(grey + np.clip(RELIEF * slope, -MOST_RELIEF, MOST_RELIEF), 0, 255)
        return np.repeat(grey[..., None], 3, axis=2)
    filled = grey_dilation(picture, size=(3, 3, 1))
    return np.where((near > 0)[..., None], picture, filled)
