"""From depth maps to organised clouds.

Names and meaning of the features are those of GenICam's Standard Features Naming Convention 2.7,
chapter 3D Scan Control: a coordinate is the pixel's value times scale plus offset, in the unit that
the device says.
"""

from dataclasses import dataclass

import numpy as np

from workbench.model.errors import LinkError
from workbench.model.geometry import Floats
from workbench.model.messages.devices import ScannerText

MOST_PIXELS = 50_000_000
"""More than the largest depth cameras have."""


@dataclass(frozen=True, slots=True)
class DepthScale:
    """What the 16 bits of a pixel mean.

    `scale` [m] a count and `offset` [m] give the depth along the view; `focal` [px] and `center`
    (u, v) [px], counted from the middle of the first pixel, give the directions; `invalid` is the
    value of pixels without a measurement, None where every pixel has one.
    """

    scale: float
    offset: float
    focal: float
    center: tuple[float, float]
    invalid: int | None

    def __post_init__(self) -> None:
        numbers = (self.scale, self.offset, self.focal, *self.center)
        if not (np.isfinite(numbers).all() and self.scale > 0 and self.focal > 0):
            detail = (
                f"a depth map needs a scale and a focal length above zero and finite "
                f"numbers, not scale {self.scale:g} m, offset {self.offset:g} m, "
                f"focal length {self.focal:g} px, principal point {self.center} px"
            )
            raise LinkError(ScannerText.SETTING(detail=detail))


def organise_points(counts: np.ndarray, means: DepthScale) -> Floats:
    """The points (h, w, 3) [m] of a depth map (h, w), z forward, x right, y down.

    Pixels of the value `invalid`, and those whose depth is not before the camera, are NaN.
    """
    z = counts.astype(np.float64) * means.scale + means.offset
    z[z <= 0] = np.nan
    if means.invalid is not None:
        z[counts == means.invalid] = np.nan
    rows, columns = counts.shape
    x = (np.arange(columns) - means.center[0]) / means.focal
    y = (np.arange(rows) - means.center[1]) / means.focal
    return np.stack([z * x, z * y[:, None], z], axis=-1)
