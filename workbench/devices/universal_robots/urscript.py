"""The part of URScript that our programs are made of, read and run: for the controller's twin.

What is not known is refused by name and line, never passed over.
"""

import math
import re
from dataclasses import dataclass

from workbench.model.errors import InputError

CALL = re.compile(r"\s+(\w+)\((.*)\)\s*")
JOINTS = re.compile(r"\[([^\]]*)\], a=([0-9.]+), v=([0-9.]+)(?:, r=([0-9.]+))?")
FLANGE = "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
"""The TCP at the flange."""

ARGUMENTS = {
    "write_output_integer_register": 2,
    "set_standard_digital_out": 2,
    "sleep": 1,
    "stopj": 1,
    "rtde_set_watchdog": 3,
}


@dataclass(frozen=True, slots=True)
class Line:
    """A call; that of `movej` has joints `q` (6,) [rad], `a` [rad/s2], `v` [rad/s] and `r` [m]."""

    name: str
    words: tuple[str, ...] = ()
    q: tuple[float, ...] = ()
    a: float = 0.0
    v: float = 0.0
    r: float = 0.0


def read_program(text: str) -> tuple[Line, ...]:
    """The calls of a program.

    Raises:
        InputError: names the line that is not known.
    """
    first, *rest = [line for line in text.splitlines() if line.strip()] or [""]
    if not re.fullmatch(r"def \w+\(\):", first) or not rest or rest[-1].strip() != "end":
        raise InputError(f"{first!r:.60}: a program from `def` to `end` is expected")
    return tuple(_line(number, line) for number, line in enumerate(rest[:-1], start=2))


def _line(number: int, text: str) -> Line:
    call = CALL.fullmatch(text)
    if call is not None and call[1] == "movej" and (move := JOINTS.fullmatch(call[2])):
        try:
            q = tuple(float(word) for word in move[1].split(","))
            line = Line("movej", (), q, float(move[2]), float(move[3]), float(move[4] or 0))
        except ValueError:
            line = None
        if line is not None and _is_possible(line):
            return line
    elif call is not None and call[1] == "set_tcp" and call[2] == FLANGE:
        return Line("set_tcp", (FLANGE,))
    elif call is not None:
        words = tuple(word.strip() for word in call[2].split(","))
        if ARGUMENTS.get(call[1]) == len(words):
            return Line(call[1], words)
    raise InputError(f"line {number}: {text.strip()!r:.60} is not known")


def _is_possible(line: Line) -> bool:
    numbers = (*line.q, line.a, line.v, line.r)
    return len(line.q) == 6 and line.a > 0 and line.v > 0 and all(map(math.isfinite, numbers))


def seconds_of(way: float, v: float, a: float) -> float:
    """How long [s] an axis takes from rest to rest."""
    return way / v + v / a if way > v * v / a else 2 * math.sqrt(way / a)
