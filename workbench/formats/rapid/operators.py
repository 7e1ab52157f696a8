"""Operators of RAPID: what comes of two values, and of which type it is."""

import operator
from collections.abc import Callable
from typing import Any

from workbench.formats.rapid.problems import RapidError, RapidStop
from workbench.formats.rapid.syntax.tokens import LONGEST_STRING
from workbench.formats.rapid.values import BOOL, DNUM, NUM, STRING, Kind, single

Act = Callable[[Any, Any], Any]

POS, ORIENT = Kind("pos"), Kind("orient")

RELATIONS: dict[str, Act] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt,
    "<=": operator.le, ">=": operator.ge,
}  # fmt: skip

LOGIC: dict[str, Act] = {"and": operator.and_, "or": operator.or_, "xor": operator.ne}
"""Both sides are always computed: what runs so runs on a controller that stops early, too."""


def _divide(a: float, b: float) -> float:
    if b == 0:
        raise RapidError("ERR_DIVZERO")
    return a / b


def _whole(name: str, divide: Callable[[int, int], int]) -> Callable[[float, float], float]:
    def run(a: float, b: float) -> float:
        if b == 0:
            raise RapidError("ERR_DIVZERO")
        if a != int(a) or b != int(b):
            raise RapidStop(f"{name} of {a:g} and {b:g}: both must be whole numbers")
        return float(divide(int(a), int(b)))

    return run


def _quotient(a: int, b: int) -> int:
    return -(-a // b) if (a < 0) != (b < 0) else a // b


ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": _divide,
    "div": _whole("DIV", _quotient),
    "mod": _whole("MOD", lambda a, b: a - b * _quotient(a, b)),
}  # fmt: skip


def _join(a: str, b: str) -> str:
    if len(a) + len(b) > LONGEST_STRING:
        raise RapidError("ERR_STRTOOLNG")
    return a + b


def _in_single(act: Callable[[float, float], float]) -> Act:
    return lambda a, b: single(act(a, b))


def _each(act: Callable[[float, float], float]) -> Act:
    return lambda a, b: [single(act(x, y)) for x, y in zip(a, b, strict=True)]


def scale(a: list[float], b: float) -> list[float]:
    """A pos times a num."""
    return [single(x * b) for x in a]


def _cross(a: list[float], b: list[float]) -> list[float]:
    rows = ((1, 2), (2, 0), (0, 1))
    return [single(a[i] * b[j] - a[j] * b[i]) for i, j in rows]


def _turn(a: list[float], b: list[float]) -> list[float]:
    (w, x, y, z), (s, t, u, v) = a, b
    found = (
        w * s - x * t - y * u - z * v,
        w * t + x * s + y * v - z * u,
        w * u - x * v + y * s + z * t,
        w * v + x * u - y * t + z * s,
    )
    return [single(number) for number in found]


WAYS: dict[tuple[str, Kind, Kind], tuple[Kind, Act]] = {
    **{(word, NUM, NUM): (NUM, _in_single(act)) for word, act in ARITHMETIC.items()},
    **{(word, DNUM, DNUM): (DNUM, act) for word, act in ARITHMETIC.items()},
    **{(word, BOOL, BOOL): (BOOL, act) for word, act in LOGIC.items()},
    **{(word, kind, kind): (BOOL, act) for word, act in RELATIONS.items() for kind in (NUM, DNUM)},
    ("+", STRING, STRING): (STRING, _join),
    ("+", POS, POS): (POS, _each(operator.add)),
    ("-", POS, POS): (POS, _each(operator.sub)),
    ("*", POS, POS): (POS, _cross),
    ("*", POS, NUM): (POS, scale),
    ("*", NUM, POS): (POS, lambda a, b: scale(b, a)),
    ("/", POS, NUM): (POS, lambda a, b: [single(_divide(x, b)) for x in a]),
    ("*", ORIENT, ORIENT): (ORIENT, _turn),
}
"""By operator and base types: the type of the result, and what computes it."""


def way(word: str, kind: Kind, other: Kind) -> tuple[Kind, Act] | None:
    """What an operator makes of two base types; None when it makes nothing."""
    found = WAYS.get((word, kind, other))
    if found is None and word in ("=", "<>") and kind == other:
        return BOOL, RELATIONS[word]
    return found
