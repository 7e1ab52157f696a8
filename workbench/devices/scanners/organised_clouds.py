"""The points of a camera's image as a scan, if they lie where the scanner can measure."""

import numpy as np

from workbench.formats.clouds.scans import RANGE_FACTOR, STRAY_SHARE
from workbench.model.cell import ScannerMount
from workbench.model.errors import LinkError
from workbench.model.geometry import Floats
from workbench.model.messages.devices import ScannerText
from workbench.model.messages.message import Message
from workbench.model.scan import Scan


def scan_of(points: Floats, mount: ScannerMount, source: str, doubt: Message) -> Scan:
    """A scan of one image.

    Args:
        points: (rows, columns, 3) [m] in the scanner's frame, NaN where nothing was measured.
        mount: where the scanner hangs, and how far it measures.
        source: names the image.
        doubt: what to look at when the points lie far from where the scanner measures.

    Raises:
        LinkError: nothing was measured, or far from there.
    """
    rows, columns, _ = points.shape
    flat = points.reshape(-1, 3)
    measured = np.flatnonzero(np.isfinite(flat).all(axis=1))
    if not len(measured):
        raise LinkError(ScannerText.NOTHING_MEASURED(image=source))
    flat = flat[measured]
    away = np.linalg.norm(flat, axis=1)
    nearest, farthest = (
        float(value) for value in np.quantile(away, (STRAY_SHARE, 1 - STRAY_SHARE))
    )
    if nearest > mount.far * RANGE_FACTOR or farthest < mount.near / RANGE_FACTOR:
        raise LinkError(
            ScannerText.OUT_OF_RANGE(
                image=source,
                nearest=nearest,
                farthest=farthest,
                near=mount.near,
                far=mount.far,
                doubt=doubt,
            )
        )
    return Scan(flat, mount.T_world_scanner, source, measured, (columns, rows))
