"""The colours that a camera has of what it sees, drawn from a seed: light, shading and noise."""

from dataclasses import dataclass, field

import numpy as np

from workbench.model.geometry import Floats, own
from workbench.perception.views.srgb import encoded, linear


@dataclass(frozen=True, slots=True, eq=False)
class Light:
    """A light, and how a camera takes it.

    `gains` (3,), no unit, multiply red, green and blue, exposure included; `ambient` is the share
    of light that comes from everywhere.  Noise has a deviation of `noise`, the brightest being 1,
    and of `uneven` over what is seen.
    """

    gains: Floats = field(default_factory=lambda: np.ones(3))
    ambient: float = 0.3
    noise: float = 0.005
    uneven: float = 0.03

    def __post_init__(self) -> None:
        own(self, "gains")


def coloured(
    paints: np.ndarray, cosine: Floats, light: Light, generator: np.random.Generator
) -> np.ndarray:
    """Colours (n, 3) in sRGB, 0..255, of dull surfaces.

    Args:
        paints: (n, 3) in sRGB, 0..255, under white light met head-on.
        cosine: (n,) of incidence.
        light: what shines.
        generator: of the noise.
    """
    shading = light.ambient + (1.0 - light.ambient) * cosine
    seen = linear(paints) * light.gains * shading[:, None]
    noise = generator.standard_normal(seen.shape) * np.hypot(light.noise, light.uneven * seen)
    return encoded(seen + noise)
