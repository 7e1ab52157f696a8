"""The part of URScript that our programs are made of, read and run: for the controller's twin.

What is not known is refused by name and line, never passed over.
"""

import math
import re
from dataclasses import dataclass

from workbench.model.errors import InputError

CALL = re.compile(r"\s+(\w+)\((.*)\)\s*")
JOINTS = re.compile(r"\[([^\]]*)\], a=([0-9.]+), v=([0-9.]+)(?:, r=([0-9.]+))?")
SERVO = re.compile(r"\[([^\]]*)\], t=([0-9.]+), lookahead_time=([0-9.]+), gain=([0-9]+)")
IF = re.compile(r"  if read_output_integer_register\((\d+)\) == (\d+):")
READ = re.compile(r"read_output_integer_register\((\d+)\)")
PAYLOAD = re.compile(r"([-0-9.]+), \[([-0-9., ]+)\](?:, \[([-0-9., ]+)\])?")
FLANGE = "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
"""The TCP at the flange."""

LOOKAHEAD, GAIN = (0.03, 0.2), (100, 2000)
"""What `servoj` takes, by the maker's article "ServoJ command": [s], and without a unit."""

ARGUMENTS = {
    "write_output_integer_register": 2,
    "set_standard_digital_out": 2,
    "sleep": 1,
    "stopj": 1,
    "rtde_set_watchdog": 3,
}


@dataclass(frozen=True, slots=True)
class Line:
    """A call, with joints `q` (6,) [rad] where it moves.

    `if` has a register and a number: what follows, up to `end`, is done where it holds that.  That
    of `movej` has `a` [rad/s2], `v` [rad/s] and `r` [m], that of `servoj` its time `t` [s],
    `lookahead` [s] and `gain` [1/s2].
    """

    name: str
    words: tuple[str, ...] = ()
    q: tuple[float, ...] = ()
    a: float = 0.0
    v: float = 0.0
    r: float = 0.0
    t: float = 0.0
    lookahead: float = 0.0
    gain: float = 0.0

    def goes_on_in(self, after: "Line") -> bool:
        """Whether the arm does not come to rest between this call and the one after."""
        if self.name == "servoj":
            return after.name == "servoj"
        return self.name == "movej" == after.name and self.r > 0


def read_program(text: str) -> tuple[Line, ...]:
    """The calls of a program.

    Raises:
        InputError: names the line that is not known.
    """
    first, *rest = [line for line in text.splitlines() if line.strip()] or [""]
    if not re.fullmatch(r"def \w+\(\):", first) or not rest or rest[-1].strip() != "end":
        raise InputError(f"{first!r:.60}: a program from `def` to `end` is expected")
    lines: list[Line] = []
    is_inside = False
    for number, line in enumerate(rest[:-1], start=2):
        lines.append(_line(number, line, is_inside))
        is_inside = lines[-1].name == "if" or (is_inside and lines[-1].name != "end")
    if is_inside:
        raise InputError("an `if` has no end")
    return tuple(lines)


def _line(number: int, text: str, is_inside: bool) -> Line:
    if is_inside and text in ("    halt", "  end"):
        return Line(text.strip())
    asked = IF.fullmatch(text)
    if asked is not None and not is_inside:
        return Line("if", (asked[1], asked[2]))
    call = CALL.fullmatch(text)
    if call is not None and call[1] in ("movej", "servoj"):
        if (line := _move(call[1], call[2])) is not None:
            return line
    elif call is not None and call[1] in ("set_payload", "set_target_payload"):
        if (line := _payload(call[1], call[2])) is not None:
            return line
    elif call is not None and call[1] == "set_tcp" and call[2] == FLANGE:
        return Line("set_tcp", (FLANGE,))
    elif call is not None:
        words = tuple(word.strip() for word in call[2].split(","))
        is_known = ARGUMENTS.get(call[1]) == len(words)
        if call[1] == "write_output_integer_register" and is_known:
            is_known = words[0].isdecimal() and (words[1].isdecimal() or READ.fullmatch(words[1]))
        if is_known:
            return Line(call[1], words)
    raise InputError(f"line {number}: {text.strip()!r:.60} is not known")


def _payload(name: str, words: str) -> Line | None:
    """A call that sends the load, its numbers in `words`; None where no load is that."""
    said = PAYLOAD.fullmatch(words)
    if said is None or (name == "set_payload") != (said[3] is None):
        return None
    try:
        mass, centre = float(said[1]), [float(word) for word in said[2].split(",")]
        inertia = [float(word) for word in said[3].split(",")] if said[3] else [0.0] * 6
    except ValueError:
        return None
    numbers = (mass, *centre, *inertia)
    if len(centre) != 3 or len(inertia) != 6 or mass <= 0 or min(inertia[:3]) < 0:
        return None
    return Line(name, tuple(map(str, numbers)))


def _move(name: str, words: str) -> Line | None:
    """A call that moves; None where it is not known, or is not possible."""
    said = (JOINTS if name == "movej" else SERVO).fullmatch(words)
    if said is None:
        return None
    try:
        q = tuple(float(word) for word in said[1].split(","))
        acceleration, other, third = (float(word or 0) for word in said.groups()[1:])
    except ValueError:
        return None
    if len(q) != 6 or not all(map(math.isfinite, (*q, acceleration, other, third))):
        return None
    if name == "movej":
        return (
            Line(name, (), q, acceleration, other, third)
            if acceleration > 0 and other > 0
            else None
        )
    has_range = LOOKAHEAD[0] <= other <= LOOKAHEAD[1] and GAIN[0] <= third <= GAIN[1]
    return (
        Line(name, (), q, t=acceleration, lookahead=other, gain=third)
        if acceleration > 0 and has_range
        else None
    )


def seconds_of(way: float, v: float, a: float) -> float:
    """How long [s] an axis takes from rest to rest."""
    return way / v + v / a if way > v * v / a else 2 * math.sqrt(way / a)
