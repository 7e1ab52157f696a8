"""The wire protocol of the thesis' cell, without sockets: plan to messages, bytes to events.

The controller is the server.  Each time it is ready it sends `send`; the other side answers
with one message:

    startR#                                 The right arm begins (L: left arm).
    inR#*-12.50*...*0.00*                   A configuration on the way in, axes 1 to 7, degrees.
    outR#*-12.50*...*0.00*                  A configuration on the way out.
    stopR#                                  The right arm has finished.

The gripper closes between the last `in` and the first `out`, and opens at `stop`.  Legs `reach`
and `approach` travel as `in`; `extract`, `return` and `place` as `out`; `home` and `view` are
sequences of their own with `out` only, which leave the gripper as it is.  RAPID strings hold 80
characters; the longest message has 62.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.errors import InputError, ProtocolError
from workbench.model.geometry import Floats, frozen, put
from workbench.model.plan import ArmPlan, LegName, Plan

Kind = Literal["start", "in", "out", "stop"]

REQUEST = b"send"
"""What the controller says when it is ready for the next message."""

LONGEST_STRING = 80
"""Characters of the longest RAPID string."""

ALONE: frozenset[LegName] = frozenset({"home", "view"})
"""Legs that are sequences of their own."""

INWARD: frozenset[LegName] = frozenset({"reach", "approach"})

DEGREES_NUMBER = re.compile(r"-?(0|[1-9]\d{0,2})\.\d\d")


@dataclass(frozen=True, slots=True, eq=False)
class SocketMessage:
    """One message; `q` (n,) [rad], chain order, for `in` and `out` alone."""

    arm: str
    kind: Kind
    text: str
    q: Floats | None = None

    def __post_init__(self) -> None:
        put(self, q=None if self.q is None else frozen(self.q))


def encode(arm: Arm, kind: Kind, q: Floats | None = None) -> SocketMessage:
    """A message to one arm, for most kinds with a configuration `q` (n,) [rad], chain order.

    Raises:
        InputError: a configuration is missing, too many, not finite or of the wrong size.
    """
    head = f"{kind}{arm.controller_id}#"
    if kind in ("start", "stop"):
        if q is not None:
            raise InputError(f"a {kind} message carries no configuration")
        return SocketMessage(arm.name, kind, head)
    if q is None or len(q) != len(arm.joints) or not np.all(np.isfinite(q)):
        raise InputError(
            f"an {kind} message to arm {arm.name} needs {len(arm.joints)} finite joints"
        )
    text = head + "*" + "*".join(in_degrees(arm, q)) + "*"
    if len(text) > LONGEST_STRING:
        raise InputError(f"a message of {len(text)} characters does not fit a RAPID string")
    return SocketMessage(arm.name, kind, text, q)


def in_degrees(arm: Arm, q: Floats) -> list[str]:
    """A configuration (n,) [rad], chain order, as it travels: axes 1 to n in degrees."""
    degrees = np.rad2deg(arm.to_axes(q))
    return [f"{value + 0.0:.2f}" for value in np.round(degrees, 2)]


def angles_of(arm: Arm, words: Sequence[str]) -> Floats:
    """The configuration (n,) [rad], chain order, that travelled so; see `in_degrees`.

    Raises:
        ProtocolError: not as many numbers as the arm has joints, each with two decimals.
    """
    if len(words) != len(arm.joints):
        raise ProtocolError(f"{len(words)} numbers came for the {len(arm.joints)} axes of an arm")
    for word in words:
        if not DEGREES_NUMBER.fullmatch(word):
            raise ProtocolError(f"{word!r} is not a number with two decimals")
    return arm.from_axes(np.deg2rad([float(word) for word in words]))


def angles_within_limits(cell: Cell, arm: Arm, words: Sequence[str]) -> Floats:
    """As `angles_of`, for a configuration (n,) [rad] that the arm is to go to.

    Raises:
        ProtocolError: it is none, or outside the limits of a joint.
    """
    q = angles_of(arm, words)
    try:
        check_limits(cell, arm, q)
    except InputError as error:
        raise ProtocolError(str(error)) from None
    return q


def messages(cell: Cell, plan: Plan) -> tuple[SocketMessage, ...]:
    """All messages of a plan, in the order in which they are sent.

    A waypoint that ends one leg and begins the next is sent once; the first waypoint of a
    sequence, where the arm stands, not at all.

    Raises:
        InputError: the plan moves two arms at once, which this protocol cannot say, or a
            configuration is outside the limits of its joint.
    """
    sent: list[SocketMessage] = []
    for step in plan.sequence:
        if len(step.runs) != 1:
            raise InputError("the protocol abb-socket moves one arm at a time")
        name, leg = step.runs[0]
        sent.extend(_leg_messages(cell, plan.arm(name), leg))
    return tuple(sent)


def _leg_messages(cell: Cell, arm_plan: ArmPlan, name: LegName) -> list[SocketMessage]:
    arm, leg = cell.arm(arm_plan.arm), arm_plan.leg(name)
    check_limits(cell, arm, np.asarray(leg.q))
    kind: Kind = "in" if name in INWARD else "out"
    sent = [encode(arm, "start")] if name in ("reach", *ALONE) else []
    sent += [encode(arm, kind, np.asarray(q)) for q in leg.q[1:]]
    if name in ("place", *ALONE):
        sent.append(encode(arm, "stop"))
    return sent


def check_limits(cell: Cell, arm: Arm, path: Floats) -> None:
    """Refuse configurations (m, n) [rad] outside the joint limits.

    Raises:
        InputError: names the joint, its value and its limits.
    """
    lower, upper, _ = cell.robot.limits(arm.joints)
    # Two decimals of a degree may round a value at its limit outwards by half a hundredth.
    slack = np.deg2rad(0.0051)
    for q in np.atleast_2d(path):
        for joint, value, low, high in zip(arm.joints, q, lower, upper, strict=True):
            if not low - slack <= value <= high + slack:
                raise InputError(
                    f"joint {joint} at {np.rad2deg(value):.2f} deg is outside "
                    f"{np.rad2deg(low):.2f} to {np.rad2deg(high):.2f} deg"
                )


class Requests:
    """The controller's words as our side hears them; bytes may arrive in any pieces.

    Lifetime: one connection.
    """

    def __init__(self) -> None:
        self._heard = b""

    def hear(self, data: bytes) -> bool:
        """Take what arrived; True when it completes exactly one request.

        Raises:
            ProtocolError: it is something else, or a second request before an answer.
        """
        self._heard += data
        if self._heard == REQUEST:
            self._heard = b""
            return True
        if REQUEST.startswith(self._heard):
            return False
        raise ProtocolError(
            f"the controller said {self._heard[:40]!r} where one {REQUEST!r} was expected"
        )


class Commands:
    """Our words as the controller hears them: strict, in order, within limits.

    Lifetime: one connection.  After an error nothing further may be fed.
    """

    def __init__(self, cell: Cell) -> None:
        self._cell = cell
        self._arms = {arm.controller_id: arm for arm in cell.arms}
        self._heard = b""
        self._active: Arm | None = None
        self._last: Kind = "stop"

    @property
    def is_between(self) -> bool:
        """Whether no sequence is open and no half message waits."""
        return self._active is None and not self._heard

    def hear(self, data: bytes) -> SocketMessage | None:
        """Take what arrived; the message when it completes one.

        Raises:
            ProtocolError: not a message of the protocol, out of order, or two at once.
        """
        self._heard += data
        if len(self._heard) > LONGEST_STRING:
            raise ProtocolError(f"a message is longer than {LONGEST_STRING} characters")
        try:
            text = self._heard.decode("ascii")
        except UnicodeDecodeError:
            raise ProtocolError(f"{self._heard[:40]!r} is not text") from None
        head, mark, rest = text.partition("#")
        if not mark:
            if len(head) > len("startR"):
                raise ProtocolError(f"{text!r} is no message")
            return None
        found = re.fullmatch(r"(start|in|out|stop)([A-Z])", head)
        if found is None or found[2] not in self._arms:
            known = ", ".join(sorted(self._arms))
            raise ProtocolError(f"{head + mark!r} is no message to one of the arms {known}")
        kind: Kind = found[1]  # type: ignore[assignment]
        arm = self._arms[found[2]]
        if kind in ("in", "out"):
            if rest.count("*") < len(arm.joints) + 1:
                return None
        elif rest:
            raise ProtocolError(f"{rest!r} follows {head + mark!r}")
        message = SocketMessage(arm.name, kind, text, self._configuration(arm, kind, rest))
        self._heard = b""
        self._follow(arm, kind)
        return message

    def _configuration(self, arm: Arm, kind: Kind, rest: str) -> Floats | None:
        if kind in ("start", "stop"):
            return None
        words = rest.split("*")
        if words[0] or words[-1] or len(words) != len(arm.joints) + 2:
            raise ProtocolError(f"{rest!r} is not {len(arm.joints)} numbers between stars")
        return angles_within_limits(self._cell, arm, words[1:-1])

    def _follow(self, arm: Arm, kind: Kind) -> None:
        """The order: start, any in, any out, stop; one arm at a time."""
        if kind == "start":
            if self._active is not None:
                raise ProtocolError(
                    f"start of arm {arm.name} before arm {self._active.name} stopped"
                )
            self._active = arm
        elif self._active is not arm:
            raise ProtocolError(f"{kind} for arm {arm.name}, which was not started")
        elif kind == "in" and self._last == "out":
            raise ProtocolError(f"a way in of arm {arm.name} after its way out")
        elif kind == "stop":
            self._active = None
        self._last = kind
