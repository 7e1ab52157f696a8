"""The controller's side of loading a program by `abb-socket/2`: strict, without sockets.

Nothing of what arrives is believed: counts, order, limits, speeds and the sum over all messages
are checked before the program counts as loaded.
"""

import re
from typing import cast, get_args

import numpy as np

from workbench.devices.abb_loads import LoadData
from workbench.devices.abb_socket.frames import FIRST_CRC, TEXT, MessageFrame, crc_of
from workbench.devices.abb_socket.messages import angles_within_limits
from workbench.devices.abb_socket.program import (
    LONGEST_WAY,
    MOST_LEGS,
    MOST_POINTS,
    TICKET,
    Hand,
    LoadOf,
    Mode,
    ProgramLeg,
    ProgramStep,
    SocketProgram,
)
from workbench.model.cell import Arm, Cell
from workbench.model.errors import ProtocolError
from workbench.model.geometry import Floats
from workbench.model.plan import LegName

SPEED_SLACK = 1.002
"""Times travel in whole milliseconds, angles in hundredths of a degree."""


class Loading:
    """A program on its way in, message by message.

    Lifetime: from the message `plan` to the message `end`.
    """

    def __init__(self, cell: Cell):
        self._arms = {arm.controller_id: arm for arm in cell.arms}
        self._cell = cell
        self._crc = FIRST_CRC
        self._digest = self._ticket = ""
        self._is_stepped = False
        self._legs_told = self._points_told = 0
        self._starts: dict[str, Floats] = {}
        self._steps: list[tuple[Mode, list[ProgramLeg]]] = []
        self._loads: dict[tuple[str, LoadOf], LoadData] = {}
        self._open_load: tuple[str, LoadOf, float, tuple[float, ...]] | None = None
        self._leg: tuple[Arm, ProgramLeg, int] | None = None
        self._points: list[Floats] = []
        self._seconds: list[float] = []
        self._stands: dict[str, Floats] = {}
        self._tools = {arm.name: "first" if arm.tool.name else "" for arm in cell.arms}

    def take(self, frame: MessageFrame) -> SocketProgram | None:
        """The next message; the program when it was the last one.

        Raises:
            ProtocolError: it does not fit what came before, or the robot.
        """
        words = frame.words
        match frame.word, len(words):
            case "plan", 1:
                self._plan(words[0])
            case "ticket", 3 | 4:
                self._take_ticket(words)
            case "start", count if count > 1:
                self._start(words)
            case "load", 6:
                self._take_load(words)
            case "axes", 9:
                self._take_axes(words)
            case "leg", 8:
                self._take_leg(words)
            case "to", count if count > 2:
                self._to(words)
            case "end", 2:
                return self._end(words)
            case _:
                raise ProtocolError(f"{frame.text!r} has not the words of a {frame.word}")
        self._crc = crc_of(frame.text.ljust(TEXT), self._crc)
        return None

    def _plan(self, digest: str) -> None:
        if not re.fullmatch(r"[0-9a-f]{64}", digest):
            raise ProtocolError(f"{digest!r} is no digest of a plan")
        self._digest = digest

    def _take_ticket(self, words: list[str]) -> None:
        if self._ticket or not re.fullmatch(rf"[0-9a-f]{{{TICKET}}}", words[0]):
            raise ProtocolError(f"{words[0]!r} is no ticket, or a second one")
        if words[3:] not in ([], ["stepped"]):
            raise ProtocolError(f"{words[3]!r} is not a manner in which a program is run")
        most = len(self._arms)
        self._ticket, self._is_stepped = words[0], len(words) == 4
        self._legs_told = _whole(words[1], 1, MOST_LEGS * most, "legs")
        self._points_told = _whole(words[2], 1, MOST_POINTS * most, "waypoints")

    def _start(self, words: list[str]) -> None:
        arm = self._arm(words[0])
        if not self._ticket or arm.name in self._starts or self._steps:
            raise ProtocolError(f"the start of arm {arm.name} comes at the wrong place")
        self._starts[arm.name] = angles_within_limits(self._cell, arm, words[1:])
        self._stands[arm.name] = self._starts[arm.name]

    def _take_load(self, words: list[str]) -> None:
        """Mass and centre of gravity, which the axes of this load follow."""
        key = self._arm(words[0]).name, cast(LoadOf, _one_of(words[1], get_args(LoadOf)))
        if len(self._starts) != len(self._arms) or self._steps or self._open_load:
            raise ProtocolError("a load comes at the wrong place")
        if key in self._loads:
            raise ProtocolError(f"the load of {words[1]} of arm {key[0]} comes twice")
        mass, *cog = _read_signed(words[2:], (3, 1, 1, 1))
        if mass <= 0 or not any(cog):
            raise ProtocolError("a load without mass, or without a centre of gravity")
        self._open_load = (*key, mass, tuple(cog))

    def _take_axes(self, words: list[str]) -> None:
        """The principal axes of the load that came before, and its inertia about them."""
        if not self._open_load or self._open_load[:2] != (self._arm(words[0]).name, words[1]):
            raise ProtocolError("axes came without their load")
        arm, what, mass, cog = self._open_load
        numbers = _read_signed(words[2:], (4, 4, 4, 4, 5, 5, 5))
        if abs(np.linalg.norm(numbers[:4]) - 1.0) > 1e-3 or min(numbers[4:]) < 0:
            raise ProtocolError("axes that are no orientation, or an inertia below 0")
        self._loads[arm, what] = LoadData(mass, cog, tuple(numbers[:4]), tuple(numbers[4:]))
        self._open_load = None

    def _take_leg(self, words: list[str]) -> None:
        if len(self._starts) != len(self._arms):
            raise ProtocolError("a leg came before the starts of all arms")
        if self._open_load:
            raise ProtocolError("a leg came before the axes of a load")
        self._close_leg()
        arm = self._arm(words[1])
        number, last = _whole(words[0], 1, 99, "step"), len(self._steps)
        mode, hand = _one_of(words[7], get_args(Mode)), _one_of(words[5], get_args(Hand))
        if number == last and mode != "alone" and mode == self._steps[-1][0]:
            others = self._steps[-1][1]
            if len(others) > 1 or others[0].arm == arm.name:
                raise ProtocolError(f"step {number} moves arm {arm.name} twice, or a third arm")
        elif number == last + 1:
            self._check_step()
            self._steps.append((cast(Mode, mode), []))
        else:
            raise ProtocolError(f"step {number} came after step {last}")
        points = _whole(words[3], 1, MOST_POINTS, "waypoints")
        self._couple(arm.name, hand)
        zone, opening = _number(words[4], 0.0, 0.499, 3), _number(words[6], 0.0, 999.9, 1) / 1000
        low, high = arm.tool.stroke
        is_known = self._tools[arm.name] == "first" and arm.tool.fingers
        if is_known and not low - 1e-4 <= opening <= high + 1e-4:
            raise ProtocolError(f"the fingers of arm {arm.name} cannot be at {words[6]} mm")
        name = cast(LegName, _one_of(words[2], get_args(LegName)))
        begin = self._stands[arm.name]
        empty = np.empty((0, len(begin)))
        leg = ProgramLeg(arm.name, name, zone, cast(Hand, hand), opening, empty, np.empty(0))
        self._leg = (arm, leg, points)
        self._points, self._seconds = [begin], []

    def _couple(self, arm: str, hand: str) -> None:
        """A tool is uncoupled only from an arm that carries one, and coupled to a bare flange."""
        is_bare = not self._tools[arm]
        if (hand, is_bare) in (("couple", False), ("uncouple", True)):
            raise ProtocolError(f"{hand} of arm {arm} comes where that cannot be")
        if hand in ("couple", "uncouple"):
            self._tools[arm] = "next" if hand == "couple" else ""

    def _to(self, words: list[str]) -> None:
        if self._leg is None:
            raise ProtocolError("a waypoint came before its leg")
        arm, leg, points = self._leg
        number, expected = _whole(words[0], 1, MOST_POINTS, "waypoint"), len(self._points)
        if number != expected or number > points:
            raise ProtocolError(f"waypoint {number} came where {expected} of {points} was expected")
        q = angles_within_limits(self._cell, arm, words[1:-1])
        seconds = _whole(words[-1], 1, int(LONGEST_WAY * 1000), "milliseconds") / 1000
        _, _, velocity = self._cell.robot.limits(arm.joints)
        way = np.abs(q - self._points[-1])
        if np.any(way > velocity * SPEED_SLACK / (1 - leg.zone) * (seconds + 0.001)):
            raise ProtocolError(
                f"arm {arm.name} cannot go to waypoint {number} of {leg.name} in {seconds:.3f} s"
            )
        self._points.append(q)
        self._seconds.append(seconds)

    def _end(self, words: list[str]) -> SocketProgram:
        self._close_leg()
        self._check_step()
        steps = tuple(ProgramStep(mode, tuple(legs)) for mode, legs in self._steps)
        begun = self._digest, self._ticket, self._starts
        program = SocketProgram(*begun, steps, self._is_stepped, self._loads)
        points = sum(len(leg.seconds) for leg in program.legs)
        count = _whole(words[0], 1, MOST_POINTS * len(self._arms), "waypoints")
        if (len(program.legs), points, points) != (self._legs_told, self._points_told, count):
            raise ProtocolError(
                f"{points} waypoints on {len(program.legs)} legs came, {self._points_told} on "
                f"{self._legs_told} were told"
            )
        if words[1] != f"{self._crc:04X}":
            raise ProtocolError(f"the check sum of all is {self._crc:04X}, not {words[1]}")
        return program

    def _close_leg(self) -> None:
        """The leg that was loaded joins its step."""
        if self._leg is None:
            return
        arm, leg, points = self._leg
        if len(self._seconds) != points:
            raise ProtocolError(f"leg {leg.name} has {len(self._seconds)} waypoints of {points}")
        q, seconds = np.array(self._points), np.array(self._seconds)
        whole = ProgramLeg(arm.name, leg.name, leg.zone, leg.hand, leg.opening, q, seconds)
        self._steps[-1][1].append(whole)
        self._stands[arm.name] = q[-1]
        self._leg = None

    def _check_step(self) -> None:
        if not self._steps:
            return
        mode, legs = self._steps[-1]
        if len(legs) != (1 if mode == "alone" else 2):
            raise ProtocolError(f"step {len(self._steps)} is {mode} and has {len(legs)} legs")
        if mode == "sync" and not np.array_equal(legs[0].seconds, legs[1].seconds):
            raise ProtocolError(f"step {len(self._steps)} is sync, but its legs differ in time")

    def _arm(self, letter: str) -> Arm:
        if letter not in self._arms:
            raise ProtocolError(f"there is no arm {letter!r}, only {', '.join(self._arms)}")
        return self._arms[letter]


def _whole(word: str, low: int, high: int, what: str) -> int:
    if not re.fullmatch(r"\d{1,5}", word) or not low <= int(word) <= high:
        raise ProtocolError(f"{word!r} is not a number of {what} from {low} to {high}")
    return int(word)


def _number(word: str, low: float, high: float, decimals: int) -> float:
    if not re.fullmatch(rf"\d{{1,3}}\.\d{{{decimals}}}", word) or not low <= float(word) <= high:
        raise ProtocolError(f"{word!r} is not a number from {low} to {high}")
    return float(word)


def _read_signed(words: list[str], decimals: tuple[int, ...]) -> list[float]:
    """Numbers below 1000 either way, with this many decimals each."""
    for word, count in zip(words, decimals, strict=True):
        if not re.fullmatch(rf"-?\d{{1,3}}\.\d{{{count}}}", word):
            raise ProtocolError(f"{word!r} is not a number with {count} decimals")
    return [float(word) for word in words]


def _one_of(word: str, known: tuple[str, ...]) -> str:
    if word not in known:
        raise ProtocolError(f"{word!r} is not one of {', '.join(known)}")
    return word
