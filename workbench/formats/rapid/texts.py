"""Functions of RAPID on numbers, bytes and strings.

Source: Technical reference manual: RAPID instructions, functions and data types (3HAC050917).
"""

# The prelude gives the types of what natives take, and every call is checked against it.
# pyright: reportUnknownLambdaType=false

import math
import re
from collections.abc import Callable
from typing import Any

from workbench.formats.rapid.problems import RapidError, RapidStop
from workbench.formats.rapid.syntax.tokens import LONGEST_STRING
from workbench.formats.rapid.values import Place, single

NUMBER = re.compile(r" *[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)? *")


def number_text(value: float, decimals: float, exponent: bool | None) -> str:
    """NumToStr."""
    return f"{value:.{int(decimals)}{'E' if exponent else 'f'}}"


def number_of(text: str, place: Place) -> bool:
    """StrToVal: only when all of the text is one number."""
    if not NUMBER.fullmatch(text):
        return False
    holder, at = place
    try:
        holder[at] = single(float(text))
    except RapidError:  # larger than a num can be
        return False
    return True


def find(text: str, begin: float, wanted: str, not_in_set: bool | None) -> float:
    """StrFind: the first place from `begin` on of a character of a set, or one behind the end."""
    _check_place("StrFind", text, begin)
    for k in range(int(begin), len(text) + 1):
        if (text[k - 1] in wanted) != bool(not_in_set):
            return float(k)
    return float(len(text) + 1)


def part(text: str, begin: float, count: float) -> str:
    """StrPart."""
    _check_place("StrPart", text, begin)
    if count < 0 or begin + count > len(text) + 1:
        raise RapidStop(f"StrPart: {count:g} characters from {begin:g} on of {len(text)}")
    return text[int(begin) - 1 : int(begin + count) - 1]


def match(text: str, begin: float, pattern: str) -> float:
    """StrMatch: the first place from `begin` on of a pattern, or one behind the end."""
    _check_place("StrMatch", text, begin)
    at = text.find(pattern, int(begin) - 1)
    return float(at + 1 if at >= 0 else len(text) + 1)


def _check_place(name: str, text: str, at: float) -> None:
    if not 1 <= at <= len(text) + 1 or at != int(at):
        raise RapidStop(f"{name}: there is no place {at:g} in a string of {len(text)}")


def byte_text(value: float, *forms: bool | None) -> str:
    r"""ByteToStr: decimal, or \\Hex, \\Okt, \\Bin, \\Char."""
    for given, form in zip(forms, ("02X", "03o", "08b", "c"), strict=True):
        if given:
            return format(int(value), form)
    return f"{int(value)}"


def byte_of(text: str, *forms: bool | None) -> float:
    r"""StrToByte: decimal, or \\Hex, \\Okt, \\Bin, \\Char."""
    *bases, is_char = forms
    if is_char:
        value = ord(text) if len(text) == 1 else 256
    else:
        base = next((base for given, base in zip(bases, (16, 8, 2), strict=False) if given), 10)
        try:
            value = int(text, base)
        except ValueError:
            value = 256
    if not 0 <= value <= 255:
        raise RapidStop(f"StrToByte: {text!r} is no byte")
    return float(value)


def _shift(value: float, steps: float) -> float:
    return float(int(value) << int(steps) & 0xFF if steps >= 0 else int(value) >> -int(steps))


def _round(value: float, decimals: float | None) -> float:
    scale = 10.0 ** (decimals or 0)
    return single(math.floor(abs(value) * scale + 0.5) / scale * (1 if value >= 0 else -1))


def _root(value: float) -> float:
    if value < 0:
        raise RapidStop(f"Sqrt: there is none of {value:g}")
    return single(math.sqrt(value))


def _change(place: Place, by: float) -> None:
    holder, at = place
    holder[at] = single(holder[at] + by)


def _clear(place: Place) -> None:
    holder, at = place
    holder[at] = 0.0


def check_length(text: str) -> str:
    """A text that fits a string.

    Raises:
        RapidError: it does not.
    """
    if len(text) > LONGEST_STRING:
        raise RapidError("ERR_STRTOOLNG")
    return text


NATIVES: dict[str, Callable[..., Any]] = {
    "abs": abs,
    "sqrt": _root,
    "dnumtonum": single,
    "pow": lambda base, exponent: single(base**exponent),
    "round": _round,
    "trunc": lambda value, dec: single(math.trunc(value * 10 ** (dec or 0)) / 10 ** (dec or 0)),
    "sin": lambda angle: single(math.sin(math.radians(angle))),
    "cos": lambda angle: single(math.cos(math.radians(angle))),
    "atan2": lambda y, x: single(math.degrees(math.atan2(y, x))),
    "min": min,
    "max": max,
    "bitand": lambda a, b: float(int(a) & int(b)),
    "bitor": lambda a, b: float(int(a) | int(b)),
    "bitxor": lambda a, b: float(int(a) ^ int(b)),
    "bitlsh": _shift,
    "bitrsh": lambda value, steps: _shift(value, -steps),
    "bytetostr": byte_text,
    "strtobyte": byte_of,
    "numtostr": number_text,
    "strtoval": number_of,
    "strlen": lambda text: float(len(text)),
    "strfind": find,
    "strpart": part,
    "strmatch": match,
    "strmemb": lambda text, at, wanted: part(text, at, 1.0) in wanted,
    "incr": lambda place: _change(place, 1.0),
    "decr": lambda place: _change(place, -1.0),
    "add": _change,
    "clear": _clear,
    "distance": lambda a, b: single(math.dist(a, b)),
    "offs": lambda target, x, y, z: [
        [single(a + b) for a, b in zip(target[0], (x, y, z), strict=True)],
        *target[1:],
    ],
}
"""By small name; arguments that were not given are None."""
