"""A scan of an image of points in millimetres, as makers' libraries give it."""

import numpy as np

from workbench.model.cell import ScannerMount
from workbench.model.errors import LinkError
from workbench.model.scan import Scan


def image_scan(points_mm: np.ndarray, mount: ScannerMount, source: str) -> Scan:
    """The points (rows, columns, 3) [mm] that were measured; NaN or (0, 0, 0) was not."""
    points = np.asarray(points_mm, np.float64) / 1000
    if points.ndim != 3 or points.shape[2] != 3:
        raise LinkError(f"{source}: an image of points is expected, not of shape {points.shape}")
    rows, columns, _ = points.shape
    points = points.reshape(-1, 3)
    pixels = np.flatnonzero(np.isfinite(points).all(axis=1) & points.any(axis=1))
    if not len(pixels):
        raise LinkError(f"{source}: nothing was measured")
    return Scan(points[pixels], mount.T_world_scanner, source, pixels, (columns, rows))
