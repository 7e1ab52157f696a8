"""One arm's UDP port: reports of the controller as they come, each checked, and our answers.

The controller speaks first: it sends to the address in its configuration, and we answer to where
that came from.
"""

import math
import socket
from collections.abc import Callable
from contextlib import suppress

import numpy as np

from workbench.devices.abb_egm import wire
from workbench.model.cell import Arm, Cell
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.geometry import Floats
from workbench.model.messages.devices import DeviceText
from workbench.model.messages.message import Message
from workbench.plugins.report_checks import bounds_of

DRIFT = 1e-3
"""By such a share the controller's clock may be slower than ours: reports are not late for it."""

AT_ONCE = 256
"""This many messages are taken before anything else is done."""

WRAP = 1 << 32
"""Numbers and clocks of messages are modulo this."""


def address_of(host: str) -> str:
    """The numeric address of a controller.

    Raises:
        LinkError: the name is not known.
    """
    try:
        return socket.gethostbyname(host)
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise LinkError(DeviceText.UNKNOWN_HOST(host=host, reason=str(reason))) from None


class Channel:
    """The port of one arm, with what was heard last."""

    def __init__(
        self,
        cell: Cell,
        arm: Arm,
        host: str,
        port: int,
        silence: float,
        clock: Callable[[], float],
        *,
        is_paced: bool = True,
    ) -> None:
        """Listen.

        Args:
            cell: with that arm.
            arm: whose axes are reported there.
            host: numeric address of the controller; what others send is not checked.
            port: where it sends to.
            silence: [s] without a report that are too long, on our clock or the controller's.
            clock: [s] that never goes back.
            is_paced: whether there has to be a report every `wire.PERIOD_MS`.

        Raises:
            LinkError: the port is taken.
        """
        self.arm, self._bounds = arm, bounds_of(cell, arm)
        self.forget()
        self._host, self._silence, self._clock = host, silence, clock
        self._is_paced = is_paced
        self._where = f"{arm.name} at UDP port {port}"
        self._fresh, self._sent = clock(), 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind(("", port))
        except OSError as error:
            self._socket.close()
            raise LinkError(self._at_port(error)) from None
        self._socket.setblocking(False)

    last: wire.Feedback | None
    came: list[wire.Feedback]
    """The reports that came at once, when something was heard last; the last of them too."""
    late: float
    """[s] How much longer than the quickest the first of them was under way."""

    def fileno(self) -> int:
        """For `select`."""
        return self._socket.fileno()

    def close(self) -> None:
        """Let the port go."""
        self._socket.close()

    def forget(self) -> None:
        """Begin anew: what comes next is the first report."""
        self.last, self.came, self.late = None, [], 0.0
        self._from: tuple[str, int] | None = None
        # The controller's clock since the first report; by how much ours is ahead of it at least.
        self._at, self._ahead = 0.0, math.inf

    def _at_port(self, error: OSError) -> Message:
        return DeviceText.PORT(port=self._where, reason=error.strerror or str(error))

    def hear(self) -> wire.Feedback | None:
        """As `hear_first`, and a silence is an error.

        Raises:
            LinkError: also where none came for too long.
        """
        if (feedback := self.hear_first()) is not None:
            return feedback
        if self._clock() - self._fresh > self._silence:
            raise LinkError(DeviceText.SILENT(seconds=self._silence, where=self._where))
        return None

    def hear_first(self) -> wire.Feedback | None:
        """The newest report, after a look at every one; None when none has come.

        Raises:
            LinkError: one is out of order, came twice, cannot be, or others were lost.
        """
        self.came, first = [], None
        for _ in range(AT_ONCE):
            try:
                data, sender = self._socket.recvfrom(wire.LONGEST_MESSAGE)
            except BlockingIOError:
                break
            except OSError as error:
                raise LinkError(self._at_port(error)) from None
            if sender[0] != self._host:
                continue
            if self._from not in (None, sender):
                raise ProtocolError(f"two programs report {self._where}")
            self._from = sender
            self._take(wire.read_feedback(data, len(self.arm.joints)))
            first = self._at if first is None else first
        if first is None:
            return None
        self._fresh = self._clock()
        self._ahead = min(self._ahead + DRIFT * (self._at - first), self._fresh - self._at)
        self.late = self._fresh - first - self._ahead
        return self.last

    def _take(self, feedback: wire.Feedback) -> None:
        if self.last is not None:
            ahead = (feedback.number - self.last.number) % WRAP
            if not 0 < ahead < WRAP // 2:
                raise ProtocolError(
                    f"report {feedback.number} came after {self.last.number}: "
                    "twice, or out of order"
                )
            later = (feedback.at - self.last.at) % WRAP
            off = abs(later - ahead * wire.PERIOD_MS)
            if self._is_paced and off > wire.PERIOD_MS // 2:
                raise ProtocolError(
                    f"{self._where}: {ahead} reports are {later} ms apart by the controller's "
                    f"clock; EGM has to run at {wire.PERIOD_MS} ms"
                )
            if later > self._silence * 1000:
                raise LinkError(DeviceText.LOST(where=self._where))
            self._at += later / 1000
        self._bounds.take(self.q_of(feedback), in_motion=self._is_paced)
        self.last = feedback
        self.came.append(feedback)

    def answer(self, q: Floats, orders: tuple[float, ...]) -> None:
        """A reference (n,) [rad], chain order, and orders, to where the reports come from."""
        if self._from is None or self.last is None:
            return
        said = wire.Reference(self._sent, self.arm.to_axes(q), orders)
        self._sent = (self._sent + 1) % WRAP
        # An answer that does not go out is one that is lost.
        with suppress(OSError):
            self._socket.sendto(wire.reference_bytes(said, self.last.at), self._from)

    def q_of(self, feedback: wire.Feedback) -> Floats:
        """Where the arm is by a report (n,) [rad], chain order."""
        return np.asarray(self.arm.from_axes(feedback.axes))

    @property
    def q(self) -> Floats:
        """Where the arm was last reported to be (n,) [rad], chain order."""
        assert self.last is not None
        return self.q_of(self.last)
