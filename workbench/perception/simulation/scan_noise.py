"""Errors of a scanner's points, drawn from a seed.

The models follow the literature on triangulating sensors.  The standard deviation grows with the
square of the depth and with the angle of incidence.  There are mixed pixels at depth edges, pixels
that the projector does not light, and outliers by wrong decoding.  Types of scanner differ most in
the errors that neighbouring pixels share (`image_errors`).

Source: Nguyen, Izadi, Lovell, "Modeling Kinect Sensor Noise for Improved 3D Reconstruction and
Tracking", 3DIMPVT 2012.
"""

import numpy as np
from scipy import ndimage

from workbench.model.geometry import Floats
from workbench.perception.simulation.image_errors import (
    fattened,
    lengthened,
    sheared,
    smoothed,
    stepped,
    waved,
)
from workbench.perception.simulation.noise_models import NoiseModel

EDGE = 0.005
"""[m] Neighbouring pixels whose depths differ by more lie on different sides of an edge."""


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
        deviation: [m] standard deviation of a pixel by itself at 1 m, met head-on; builds that
            average over neighbours (`NoiseModel.blur`) leave less of it.
        model: the build of scanner.
        generator: of all that is random.
    """
    if model.drifted:
        depth, cosine = sheared(depth, model.drifted), sheared(cosine, model.drifted)
    if model.fattened:
        depth = fattened(depth, model.fattened, EDGE)
    if model.corners:
        depth = lengthened(depth, model.corners)
    if model.wave:
        depth = waved(depth, model.wave, model.fringe)
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
    if model.glare:
        fails |= (cosine > model.gloss) & (generator.random(depth.shape) < model.glare)
    if model.torn:
        fails |= generator.random((len(depth), 1)) < model.torn
    if model.blur:
        measured = smoothed(np.where(fails, np.nan, measured), model.blur, model.bridged)
    if model.step:
        measured = stepped(measured, model.step)
    return np.where(fails | ~np.isfinite(measured), np.nan, measured)


def _across_edges(depth: Floats, share: Floats) -> Floats:
    """Depths between the two sides of an edge, `share` (0..1) of the way; NaN elsewhere."""
    finite = np.where(np.isfinite(depth), depth, np.nan)
    near = ndimage.minimum_filter(np.nan_to_num(finite, nan=np.inf), 3)
    far = ndimage.maximum_filter(np.nan_to_num(finite, nan=-np.inf), 3)
    with np.errstate(invalid="ignore"):
        is_edge = np.isfinite(far - near) & (far - near > EDGE)
        return np.where(is_edge, near + share * (far - near), np.nan)
