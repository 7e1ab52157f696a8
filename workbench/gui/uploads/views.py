"""The text about a chosen CAD file."""

import math

import numpy as np

from workbench.formats.files.whole_files import MB
from workbench.formats.meshes.cad_look import CadLook
from workbench.gui.texts.parts import UploadText
from workbench.model.messages.message import Message, as_message


def size_message(name: str, size: int) -> Message:
    """A file with its size [bytes]; a small one has no 0.00 MB."""
    if size >= MB:
        return UploadText.MEGABYTES(file=name, size=size / MB)
    return UploadText.KILOBYTES(file=name, size=math.ceil(size / 1000))


def look_message(look: CadLook) -> Message:
    """How large what is in a file is, in which unit, where, and whether it is closed."""
    size = " x ".join(f"{length * 1000:.4g}" for length in look.surface.size)
    unit = UploadText.AS_STATED()
    if look.unit:
        unit = (UploadText.ASSUMED if look.is_assumed else UploadText.READ_IN)(unit=look.unit)
    low, high = np.round(np.array([look.low[2], look.high[2]]) * 1000, 1) + 0.0
    text = UploadText.SIZE(size=size, unit=unit, low=f"{low:g}", high=f"{high:g}")
    problems = look.surface.problems
    if problems:
        return UploadText.NOT_CLOSED(text=text, problems=map(as_message, problems))
    return UploadText.CLOSED(text=text, volume=f"{look.surface.volume * 1e6:.4g}")
