"""The colours of points as files have them: three channels, or packed into one number."""

import numpy as np

CHANNELS = ("red", "green", "blue")
"""Properties of a PLY file that hold them."""

PACKED = ("rgb", "rgba")
"""Fields of a PCD file, one of which holds them as 0xRRGGBB or 0xAARRGGBB."""


def of_channels(values: np.ndarray, kind: str) -> np.ndarray:
    """Colours (n, 3), 0..255, from rows of red, green and blue (n, 3), no unit.

    Args:
        values: whole numbers of one or two bytes, or shares of 1.
        kind: NumPy's of the file, without byte order: u1 and u2 are whole, f4 and f8 shares.
    """
    full = 255.0 if kind[0] == "f" else 1.0 / 257.0 if kind == "u2" else 1.0
    whole = np.nan_to_num(values * full, nan=0.0, posinf=255.0, neginf=0.0)
    return np.clip(np.round(whole), 0, 255).astype(np.uint8)


def unpack_colours(values: np.ndarray) -> np.ndarray:
    """Colours (n, 3), 0..255, from numbers (n,) of four bytes that hold them."""
    bits = np.ascontiguousarray(values).view(np.uint32)
    return np.stack([bits >> shift & 255 for shift in (16, 8, 0)], axis=1).astype(np.uint8)


def unless_all_alike(colours: np.ndarray | None) -> np.ndarray | None:
    """The colours (n, 3), 0..255, None where all are one.

    Many programs write a field that they cannot fill.
    """
    if colours is None or bool((colours == colours[0]).all()):
        return None
    return colours
