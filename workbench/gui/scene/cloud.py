"""The colours of a scan: by height, of parts found, red where a plan keeps clear; or its own."""

from dataclasses import dataclass

import numpy as np

from workbench.gui.shared.colours import AVOIDED, BESIDE_BIN, HEIGHTS, part_colour, rgb_of
from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Floats
from workbench.model.scan import Detection, Obstacle

ROUNDING = 1e-6
"""[m] Rounding, by which a point on the face of a box may lie outside of it."""

GRID = 2.0**-12
"""[m] To which points are rounded where they are drawn; a drawn point is 1.6 mm wide."""


@dataclass(frozen=True, slots=True, eq=False)
class PaintedCloud:
    """Points (n, 3) [m] in the world, a colour (n, 3) 0..255 for each, and whose they are.

    `owners` (n,) are indices of parts found, -1 where a point is of none; `own` (n, 3) 0..255 are
    the colours that the scanner gave, None where it gave none.
    """

    points: Floats
    colours: np.ndarray
    owners: np.ndarray
    own: np.ndarray | None = None


def painted_cloud(
    cell: Cell,
    points: Floats,
    detections: tuple[Detection, ...],
    own: np.ndarray | None = None,
) -> PaintedCloud:
    """World points (n, 3) [m] by height, those of a part found in the part's colour.

    With them go their `own` colours (n, 3) 0..255, where the scanner gave some.
    """
    colours = height_colours(cell, points)
    owners = np.full(len(points), -1)
    if detections:
        # Open3D takes a second to load: the page does not wait for it before there is a scan.
        from workbench.perception.scene.unexplained import explained_by

        owners = explained_by(cell, detections, points)
        for number in range(len(detections)):
            colours[owners == number] = rgb_of(part_colour(number))
    return PaintedCloud(points, colours, owners, own)


def shown_colours(
    cloud: PaintedCloud, obstacles: tuple[Obstacle, ...], *, as_scanned: bool
) -> np.ndarray:
    """Colours (n, 3) 0..255 in which a cloud is drawn: its own, if wanted and there, or ours.

    In its own nothing is painted over: what is red there need not be kept clear of, and the boxes
    say what is.
    """
    if as_scanned and cloud.own is not None:
        return cloud.own
    return avoided_red(cloud, obstacles)


def avoided_red(cloud: PaintedCloud, obstacles: tuple[Obstacle, ...]) -> np.ndarray:
    """Colours (n, 3) 0..255 of a cloud, red where points lie in a box that is kept clear of.

    The boxes are those that the plan and its proof hold: nothing else is red, so what is not
    avoided does not look as if it were.  Points of parts found keep the part's colour.
    """
    colours = cloud.colours.copy()
    colours[in_boxes(cloud.points, obstacles) & (cloud.owners < 0)] = rgb_of(AVOIDED)
    return colours


def in_short(points: Floats) -> tuple[tuple[float, float, float], np.ndarray]:
    """Points (n, 3) [m] as browsers are sent them, in a third of the bytes once that is packed.

    Returns:
        Their middle, and (n, 3) in half precision from there, rounded to `GRID`: within 0.5 m
        of the middle that is what half precision can say at all.
    """
    if not len(points):
        return (0.0, 0.0, 0.0), np.zeros((0, 3), np.float16)
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    near = np.round((points - middle) / GRID) * GRID
    x, y, z = middle.tolist()
    return (x, y, z), near.astype(np.float16)


def in_boxes(points: Floats, obstacles: tuple[Obstacle, ...]) -> Bools:
    """Which points (n, 3) [m] of the world lie in one of the boxes, (n,)."""
    inside = np.zeros(len(points), np.bool_)
    for obstacle in obstacles:
        T = obstacle.T_world_box.inverse()
        away = np.abs(points @ T.rotation.T + T.translation) - obstacle.size / 2
        inside |= np.all(away <= ROUNDING, axis=1)
    return inside


def height_colours(cell: Cell, points: Floats) -> np.ndarray:
    """A colour (n, 3) 0..255 for each world point (n, 3): by height in the bin, grey beside it."""
    T_bin_world = cell.bin.T_world_bin.inverse()
    inside = points @ T_bin_world.rotation.T + T_bin_world.translation
    length, width, height = cell.bin.size
    share = np.clip(inside[:, 2] / height, 0.0, 1.0) * (len(HEIGHTS) - 1)
    steps = np.arange(len(HEIGHTS))
    colours = np.stack(
        [np.interp(share, steps, channel) for channel in np.array(HEIGHTS).T], axis=1
    )
    beside = (np.abs(inside[:, 0]) > length / 2) | (np.abs(inside[:, 1]) > width / 2)
    colours[beside] = BESIDE_BIN
    return colours.astype(np.uint8)
