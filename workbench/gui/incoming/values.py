"""Values of single fields: finite, within bounds, and made of signs that people type."""

import math
import unicodedata
from collections.abc import Sequence
from typing import Any

LARGEST_NUMBER = 1e12
"""Of a number whose field has no bounds of its own."""

MOST_SIGNS = 1000
"""Of a text on one line."""

MOST_SIGNS_OF_MANY_LINES = 20_000

TOO_SMALL, TOO_LARGE = "too small", "too large"

BENT = 1e-6
"""How far a number may lie beside a whole step, of that step: browsers compute in binary."""

TURNED_AROUND = frozenset(map(chr, (*range(0x202A, 0x202F), *range(0x2066, 0x206A))))
"""Signs that have others shown in another order than they stand in."""


def number_problem(
    value: Any,
    now: Any,
    *,
    low: float | None,
    high: float | None,
    step: float | None,
    digits: int,
) -> str:
    """Why a field for a number does not offer a value; empty when it does.

    A person types as many digits as are shown, or goes on in steps from the number that is there.

    Args:
        value: what was sent.
        now: the number that is there; whole when the field is for whole numbers.
        low: smallest; None: there is none.
        high: largest; None: there is none.
        step: of the arrows beside the number; None: there are none.
        digits: after the point, as they are shown.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return "no number"
    if value == now:
        return ""
    if value < (-LARGEST_NUMBER if low is None else low):
        return TOO_SMALL
    if value > (LARGEST_NUMBER if high is None else high):
        return TOO_LARGE
    if value in (low, high):
        return ""
    if isinstance(now, int):
        return "" if float(value).is_integer() else "not whole"
    is_typed = _is_whole(value * 10.0**digits)
    is_stepped = bool(step) and _is_whole((value - now) / step)
    return "" if is_typed or is_stepped else "more digits than are shown"


def numbers_problem(
    value: Any,
    now: Sequence[float],
    *,
    low: Sequence[float] | None,
    high: Sequence[float] | None,
    step: float | None,
    digits: int,
) -> str:
    """Why a field for several numbers does not offer a value; see `number_problem`."""
    if not isinstance(value, list | tuple) or len(value) != len(now):
        return f"not {len(now)} numbers"
    for k, (after, before) in enumerate(zip(value, now, strict=True)):
        problem = number_problem(
            after,
            before,
            low=None if low is None else low[k],
            high=None if high is None else high[k],
            step=step,
            digits=digits,
        )
        if problem:
            return problem
    return ""


def text_problem(value: Any, *, has_lines: bool = False) -> str:
    """Why a field for a text does not offer a value; empty when it does."""
    if not isinstance(value, str):
        return "no text"
    if len(value) > (MOST_SIGNS_OF_MANY_LINES if has_lines else MOST_SIGNS):
        return "too long"
    kept = "\t\n\r" if has_lines else "\t"  # what is copied from a table has tabs
    if any(is_no_sign(sign) for sign in value if sign not in kept):
        return "signs that nobody types"
    return ""


def is_no_sign(sign: str) -> bool:
    """Whether a character of a text commands those who show or keep it, as NUL does."""
    return unicodedata.category(sign) in ("Cc", "Cs") or sign in TURNED_AROUND


def _is_whole(number: float) -> bool:
    return abs(number - round(number)) <= max(BENT, abs(number) * 1e-15)
