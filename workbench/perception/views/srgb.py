"""sRGB, in which files and cameras have colours, and shares of light (IEC 61966-2-1)."""

import numpy as np

from workbench.model.geometry import Floats


def linear(colours: np.ndarray) -> Floats:
    """Shares of light (n, 3), 0..1, from sRGB (n, 3), 0..255."""
    shares = np.asarray(colours, float) / 255.0
    return np.where(shares <= 0.04045, shares / 12.92, ((shares + 0.055) / 1.055) ** 2.4)


def encoded(shares: Floats) -> np.ndarray:
    """SRGB (n, 3), 0 to 255 in one byte, from shares of light (n, 3); what is beyond 1 is white."""
    kept = np.clip(shares, 0.0, 1.0)
    values = np.where(kept <= 0.0031308, kept * 12.92, 1.055 * kept ** (1 / 2.4) - 0.055)
    return np.round(255.0 * values).astype(np.uint8)
