"""One sending: looks first, then the program goes out once, and any doubt stops the robot."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Any

import numpy as np

from workbench.devices.universal_robots.program import Program
from workbench.devices.universal_robots.rtde import PLAYING, RUNNING_MODE, STANDS, STOPPED
from workbench.devices.universal_robots.servo import off_the_references
from workbench.devices.universal_robots.talking import Client
from workbench.model.cell import Arm
from workbench.model.errors import JobCancelled, LinkError
from workbench.model.geometry import Floats
from workbench.model.release import LinkStatus, Receipt
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import LinkPatience

NEAR = np.deg2rad(0.2)
"""[rad] A joint may stand so far from where the plan begins, or ends."""

OFF = np.deg2rad(0.5)
"""[rad] A joint may be so far from the way of its references, where they are streamed."""

POLL = 0.05

MODES = {
    -1: "has no controller",
    0: "is disconnected",
    1: "waits for a confirmation of its safety configuration",
    2: "starts",
    3: "is powered off",
    4: "is powered on, its brakes are not released",
    5: "is idle, its brakes are not released",
    6: "is in free drive",
    8: "updates its firmware",
}

SAFETY = {
    2: "protective stop",
    3: "recovery mode",
    4: "safeguard stop",
    5: "system emergency stop",
    6: "robot emergency stop",
    7: "emergency stop",
    8: "safety violation",
    9: "safety fault",
    10: "stopped for safety",
}
"""Bits of `safety_status_bits`."""


def fault_of(told: dict[str, Any]) -> str:
    """What speaks against moving, by the controller's own report; empty when nothing does."""
    stops = [words for bit, words in SAFETY.items() if told["safety"] >> bit & 1]
    if stops:
        return ", ".join(stops)
    mode = told["mode"]
    return "" if mode == RUNNING_MODE else f"the robot {MODES.get(mode, f'is in mode {mode}')}"


class Sending:
    """One conversation, over one client."""

    def __init__(
        self,
        client: Client,
        arm: Arm,
        program: Program,
        *,
        now: Callable[[], float],
        show: Callable[[LinkStatus], None],
        patience: LinkPatience,
        link: str = "ur-rtde",
    ) -> None:
        self._client, self._arm, self._program, self._link = client, arm, program, link
        self._now, self._show, self._patience = now, show, patience
        self._leg, self._alive = 0, 0
        self._at: float | None = None
        self._fresh = 0.0

    @property
    def _where(self) -> str:
        return f"leg {self._leg} of {len(self._program.legs)}"

    def run(self, released: Callable[[], None], cancelled: Cancelled) -> Iterator[Receipt]:
        """Look, send, follow.

        Args:
            released: called before motion begins; raises when the approval does not hold.
            cancelled: whether to stop.

        Raises:
            LinkError: the robot is not ready, stands elsewhere, stops, or nothing is heard.
            JobCancelled: somebody stops; says whether the robot stands.
        """
        self._check_ready(self._first(cancelled))
        released()
        total = len(self._program.legs)
        has_ended = False
        try:
            self._client.say(run=self._program.text, alive=0)
            yield self._receipt("program", sent=self._program.text)
            began, stood = self._patience.clock(), None
            while not has_ended:
                if cancelled():
                    has_ended = True
                    self._stop()
                told = self._hear()
                if told is None:
                    continue
                clock = self._patience.clock()
                done = told["leg"] - self._program.ticket
                if not 0 <= done <= total + 1:
                    if clock - began > self._patience.silence:
                        raise LinkError("the controller did not begin the program; see its log")
                    continue
                if done < self._leg:
                    raise LinkError(f"the controller is in leg {done} after {self._where}")
                if fault := fault_of(told):
                    raise LinkError(f"the controller reports at {self._where}: {fault}")
                for number in range(self._leg + 1, min(done, total) + 1):
                    self._leg = number
                    yield self._receipt(self._program.legs[number - 1], heard=f"leg {number}")
                self._check_follows(told)
                self._tell(told)
                if told["runtime"] == PLAYING:
                    stood = None
                    continue
                if done == total + 1 and told["runtime"] == STOPPED:
                    self._check_stands(told, self._program.q_end, "ends")
                    has_ended = True
                    yield self._receipt("end", heard="the program has ended")
                    continue
                stood = clock if stood is None else stood
                # The register and the state of the program come in one packet; a doubt is short.
                if clock - stood > self._patience.doubt:
                    raise LinkError(f"the controller ended the program at {self._where}")
        finally:
            if not has_ended:
                with suppress(LinkError):
                    self._client.say(stop=True)

    def _first(self, cancelled: Cancelled) -> dict[str, Any]:
        """The first state; the client has to connect before."""
        until = self._patience.clock() + self._patience.answer
        while self._patience.clock() < until:
            if cancelled():
                raise JobCancelled("sending was stopped before the controller was spoken to")
            told = self._client.hear(POLL)
            if told is not None and told.get("remote") is False:
                raise LinkError("the robot is in local control; choose remote control on its panel")
            if told is not None and "q" in told:
                # How long the client took to connect is not the controller's silence.
                self._fresh = self._patience.clock()
                return told
        raise LinkError(f"the controller told nothing within {self._patience.answer:.0f} s")

    def _check_ready(self, told: dict[str, Any]) -> None:
        if fault := fault_of(told):
            raise LinkError(f"the robot cannot move: {fault}")
        if told["runtime"] != STOPPED:
            raise LinkError("the controller runs another program, or holds one that is paused")
        if 0 <= told["leg"] - self._program.ticket <= len(self._program.legs) + 1:
            raise LinkError("the controller has run this program already; nothing runs twice")
        self._check_stands(told, self._program.q_start, "begins")

    def _check_stands(self, told: dict[str, Any], q: Floats, where: str) -> None:
        off = np.abs(self._arm.from_axes(told["q"]) - q)
        if not off.max() <= NEAR:  # nor where it reports no number
            joint = self._arm.joints[int(off.argmax())]
            raise LinkError(
                f"{joint} stands {np.rad2deg(off.max()):.1f} degrees from where the plan {where}"
            )

    def _check_follows(self, told: dict[str, Any]) -> None:
        """Where the arm is streamed, it is on the way of the leg that it says it is in."""
        if not self._program.references:
            return
        q = np.asarray(self._arm.from_axes(told["q"]))
        off = off_the_references(q, self._program.references[max(self._leg - 1, 0)])
        if not off.max() <= OFF:  # nor where it reports no number
            joint = self._arm.joints[int(off.argmax())]
            raise LinkError(
                f"the robot does not follow in {self._where}: {joint} is "
                f"{np.rad2deg(off.max()):.1f} degrees from its references"
            )

    def _hear(self) -> dict[str, Any] | None:
        """A state that is news; we say that we are there as often as we look."""
        began = self._patience.clock()
        told = self._client.hear(POLL)
        if told is not None and "q" in told and told["at"] != self._at:
            self._at, self._fresh = told["at"], self._patience.clock()
            self._alive += 1
            self._client.say(alive=self._alive)
            return told
        # What comes while this process stands still is heard next, so that is no silence.
        if began - self._fresh > self._patience.silence:
            raise LinkError(
                f"the controller was silent for {self._patience.silence:.0f} s at {self._where}"
            )
        return None

    def _stop(self) -> None:
        """Stop the robot, and wait for its word.

        Raises:
            JobCancelled: always.
        """
        where = f"sending was stopped at {self._where}"
        missing = "the controller did not report that it stands: use the emergency stop"
        clock = self._patience.clock
        began, is_heard = clock(), False
        try:
            self._client.say(stop=True)
            while clock() - began < self._patience.stop:
                told = self._client.hear(POLL)
                is_heard = is_heard or (told is not None and "stopping" in told)
                if is_heard and told is not None and told.get("runtime") in STANDS:
                    took = clock() - began
                    words = f"the controller reported that it stands after {took * 1000:.0f} ms"
                    legs, at = len(self._program.legs), self._now()
                    self._show(
                        LinkStatus(self._link, "stopped", self._leg, legs, "", 0.0, at, took, words)
                    )
                    raise JobCancelled(f"{where}; {words}")
        except LinkError as error:
            raise JobCancelled(f"{where}; {missing} ({error})") from None
        raise JobCancelled(f"{where}; {missing}")

    def _tell(self, told: dict[str, Any]) -> None:
        joints = {self._arm.name: self._arm.from_axes(told["q"])}
        at = self._now()
        phase = "running" if told["runtime"] == PLAYING else "stopped"
        legs = len(self._program.legs)
        heard = f"leg {self._leg}"
        self._show(LinkStatus(self._link, phase, self._leg, legs, heard, at, at, joints=joints))

    def _receipt(self, kind: str, sent: str = "", heard: str = "") -> Receipt:
        total = len(self._program.legs)
        return Receipt(self._now(), self._arm.name, kind, sent, self._leg, total, heard)
