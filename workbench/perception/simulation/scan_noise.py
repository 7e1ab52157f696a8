"""What is wrong with the points of a structured-light scanner, drawn from a seed.

The models follow what is known of triangulating sensors: a deviation that grows with the square of
the depth and with the angle of incidence (Nguyen, Izadi, Lovell, "Modeling Kinect Sensor Noise for
Improved 3D Reconstruction and Tracking", 3DIMPVT 2012), mixed pixels at depth edges, pixels that
the projector does not light, and now and then a pattern that is decoded wrongly.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from scipy import ndimage

from workbench.model.geometry import Floats

EDGE = 0.005
"""[m] Neighbouring pixels whose depths differ by more lie on different sides of an edge."""


@dataclass(frozen=True, slots=True)
class NoiseModel:
    """A build of scanner.

    `baseline` [m] is from camera to projector, along the image's rows.  Below the cosine
    `grazing` too little of the pattern comes back; failures begin at `fading`.  `drop_outs` is the
    share of pixels that fail anywhere (dust, gloss), `outliers` that of pixels which are decoded
    wrongly and lie anywhere up to `stray` [m] off, `flying` that of pixels beside a depth edge
    which measure something between its two sides.
    """

    baseline: float
    grazing: float
    fading: float
    drop_outs: float
    outliers: float
    stray: float
    flying: float


FINE = NoiseModel(
    baseline=0.12,
    grazing=0.26,  # 75 degrees
    fading=0.42,  # 65 degrees
    drop_outs=0.01,
    outliers=0.0005,
    stray=0.03,
    flying=0.05,
)
ROUGH = NoiseModel(
    baseline=0.25,
    grazing=0.34,  # 70 degrees
    fading=0.57,  # 55 degrees
    drop_outs=0.05,
    outliers=0.005,
    stray=0.06,
    flying=0.4,
)
NOISE_MODELS: Mapping[str, NoiseModel] = MappingProxyType({"fine": FINE, "rough": ROUGH})


def noisy(
    depth: Floats,
    cosine: Floats,
    deviation: float,
    model: NoiseModel,
    generator: np.random.Generator,
) -> Floats:
    """Depths as they are measured; NaN where nothing is.

    Args:
        depth: (rows, columns) [m] the truth along the optical axis, infinite where nothing is hit.
        cosine: (rows, columns) of incidence, the smaller one of camera and projector; zero where
            no light falls.
        deviation: [m] standard deviation at 1 m, met head-on.
        model: the build of scanner.
        generator: of all that is random.
    """
    spread = deviation * depth**2 / np.maximum(cosine, model.grazing)
    measured = depth + np.where(np.isfinite(depth), spread, 0.0) * generator.standard_normal(
        depth.shape
    )
    between = _across_edges(depth, generator.random(depth.shape))
    mixed = (generator.random(depth.shape) < model.flying) & np.isfinite(between + depth)
    measured[mixed] = between[mixed]
    wrong = generator.random(depth.shape) < model.outliers
    measured[wrong] += generator.uniform(-model.stray, model.stray, depth.shape)[wrong]
    fading = np.clip((model.fading - cosine) / (model.fading - model.grazing), 0.0, 1.0)
    fails = generator.random(depth.shape) < model.drop_outs + (1.0 - model.drop_outs) * fading
    return np.where(fails | ~np.isfinite(measured), np.nan, measured)


def _across_edges(depth: Floats, share: Floats) -> Floats:
    """Depths between the two sides of an edge, `share` (0..1) of the way; NaN elsewhere."""
    finite = np.where(np.isfinite(depth), depth, np.nan)
    near = ndimage.minimum_filter(np.nan_to_num(finite, nan=np.inf), 3)
    far = ndimage.maximum_filter(np.nan_to_num(finite, nan=-np.inf), 3)
    with np.errstate(invalid="ignore"):
        is_edge = np.isfinite(far - near) & (far - near > EDGE)
        return np.where(is_edge, near + share * (far - near), np.nan)
