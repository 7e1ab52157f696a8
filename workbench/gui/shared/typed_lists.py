"""Numbers as people type them: `0, 72, 144`, or `5 x 72`, or `3 x 13 from -28`; and directions."""

import re

import numpy as np

from workbench.gui.texts.grasps import GraspText
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.message import plain

MOST_NUMBERS = 1000
"""Numbers in one list."""

_NUMBER = r"(?:[-+]?\d{1,9}(?:\.\d{0,9})?|[-+]?\.\d{1,9})"
_STEPS = re.compile(rf"(\d{{1,6}})\s*x\s*({_NUMBER})(?:\s+from\s+({_NUMBER}))?")


def numbers_in(text: str, name: str) -> tuple[float, ...]:
    """The numbers that a text stands for.

    Args:
        text: numbers with commas or blanks between them, or a count, `x` and a step.
        name: of the field, for the message.

    Raises:
        InputError: it is neither, or stands for more than `MOST_NUMBERS` numbers.
    """
    steps = _STEPS.fullmatch(text.strip())
    if steps:
        count, step, start = int(steps[1]), float(steps[2]), float(steps[3] or 0.0)
        _check(count, name)
        return tuple(start + k * step for k in range(count))
    words = text.replace(",", " ").split()
    _check(len(words), name)
    if not all(re.fullmatch(_NUMBER, word) for word in words):
        raise InputError(GraspText.NUMBERS_EXPECTED(name=plain(name), text=f"{text[:60]!r}"))
    return tuple(float(word) for word in words)


def _check(count: int, name: str) -> None:
    if not 1 <= count <= MOST_NUMBERS:
        raise InputError(GraspText.COUNT_EXPECTED(name=plain(name), most=MOST_NUMBERS, count=count))


def shown_numbers(values: tuple[float, ...]) -> str:
    """The numbers as a person would type them, even steps as such."""
    short = [round(value, 4) + 0.0 for value in values]
    if len(short) > 2:
        step = round(short[1] - short[0], 4)
        if step and all(abs(short[0] + k * step - v) < 1e-3 for k, v in enumerate(short)):
            start = f" from {short[0]:g}" if short[0] else ""
            return f"{len(short)} x {step:g}{start}"
    return ", ".join(f"{value:g}" for value in short)


def direction_in(vector: tuple[float, float, float], name: str) -> Floats:
    """The unit vector (3,) along what was typed into the field of that name.

    Raises:
        InputError: it has no length, or none that can be measured.
    """
    length = float(np.linalg.norm(vector))
    if not 1e-9 < length < 1e9:
        raise InputError(GraspText.NO_DIRECTION(name=plain(name), vector=str(vector)))
    return np.array(vector) / length


def shown_vector(vector: Floats) -> tuple[float, float, float]:
    """A vector (3,), in the field's unit, as the field shows it."""
    x, y, z = (round(float(value), 6) + 0.0 for value in vector)
    return x, y, z
