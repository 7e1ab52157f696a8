"""The text about a chosen CAD file."""

import math

import numpy as np

from workbench.formats.files.whole_files import MB
from workbench.formats.meshes.cad_look import CadLook


def size_words(name: str, size: int) -> str:
    """A file with its size [bytes]; a small one has no 0.00 MB."""
    words = f"{size / MB:.1f} MB" if size >= MB else f"{math.ceil(size / 1000)} kB"
    return f"{name}, {words}"


def look_words(look: CadLook) -> str:
    """How large what is in a file is, in which unit, where, and whether it is closed."""
    size = " x ".join(f"{length * 1000:.4g}" for length in look.surface.size)
    if not look.unit:
        unit = "as the file says"
    else:
        unit = f"taken to be in {look.unit}" if look.is_assumed else f"read in {look.unit}"
    low, high = np.round(np.array([look.low[2], look.high[2]]) * 1000, 1) + 0.0
    said = f"{size} mm, {unit}; z from {low:g} to {high:g} mm"
    problems = look.surface.problems
    if problems:
        return f"{said}; not closed: {', '.join(problems)}"
    return f"{said}; closed, {look.surface.volume * 1e6:.4g} cm³"
