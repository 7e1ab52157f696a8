"""One sending: looks first, then the program goes out once, and any doubt stops the robot."""

from collections.abc import Callable, Iterator
from contextlib import suppress

import numpy as np

from workbench.devices.universal_robots.program import UrProgram
from workbench.devices.universal_robots.received_states import States, UrState
from workbench.devices.universal_robots.rtde import PLAYING, REFUSED, STOPPED, TICKETS
from workbench.devices.universal_robots.servo import off_the_references
from workbench.devices.universal_robots.talking import Client
from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError, ProtocolError
from workbench.model.geometry import Floats
from workbench.model.messages.devices import DeviceText
from workbench.model.messages.message import Message
from workbench.model.messages.work import StopText
from workbench.model.release import LinkStatus, Receipt
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import LinkPatience

START_TOLERANCE = np.deg2rad(0.2)
"""[rad] A joint may stand this far from where the plan begins, or ends."""

FOLLOWING_TOLERANCE = np.deg2rad(0.5)
"""[rad] A joint may be this far from the way of its references, where they are streamed."""

POLL_EVERY = 0.05

LEAST_TIME = 0.3
"""[share] Of the time that was planned, a leg takes at least as long by the controller's clock."""

STANDS_WITHIN = 1e-3
"""[rad] Between two reports; a joint that moved by less stands."""


class RtdeSending:
    """One conversation, over one client."""

    def __init__(
        self,
        client: Client,
        cell: Cell,
        program: UrProgram,
        *,
        now: Callable[[], float],
        show: Callable[[LinkStatus], None],
        patience: LinkPatience,
        link: str = "ur-rtde",
    ) -> None:
        self._client, self._arm, self._program, self._link = client, cell.arms[0], program, link
        self._now, self._show, self._patience = now, show, patience
        self._states = States(cell, self._arm)
        self._leg, self._alive, self._fresh, self._has_begun = 0, 0, 0.0, False
        # By the controller's clock: until when it was seen in each leg, or before it.
        self._until = dict.fromkeys(range(len(program.legs) + 1), 0.0)

    @property
    def _where(self) -> Message:
        return DeviceText.LEG(number=self._leg, total=len(self._program.legs))

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
        has_ended = False
        try:
            self._client.say(run=self._program.text, alive=0)
            yield self._receipt("program", sent=self._program.text)
            for state in self._follow(cancelled):
                done = state.leg - self._program.ticket
                for number in range(self._leg + 1, min(done, len(self._program.legs)) + 1):
                    self._leg = number
                    yield self._receipt(self._program.legs[number - 1], heard=f"leg {done}")
            has_ended = True
            yield self._receipt("end", heard="the program has ended")
        except JobCancelled:
            has_ended = True
            raise
        finally:
            if not has_ended:
                with suppress(LinkError):
                    self._client.say(stop=True)

    def _follow(self, cancelled: Cancelled) -> Iterator[UrState]:
        """States of the program as it runs, each checked, up to that of its end."""
        total, clock = len(self._program.legs), self._patience.clock
        began, stood, over = clock(), None, None
        while True:
            if cancelled():
                self._stop()
            state = self._hear()
            if state is None:
                continue
            done = state.leg - self._program.ticket
            if fault := state.fault:
                raise LinkError(DeviceText.FAULT(where=self._where, fault=fault))
            if not self._has_begun and not 0 <= done <= REFUSED:
                if clock() - began > self._patience.silence:
                    raise LinkError(DeviceText.NOT_BEGUN())
                continue
            self._check_leg(done, state.at)
            yield state
            self._check_follows(state)
            self._report(state)
            over = over or (clock() if done > total else None)
            if over is not None and clock() - over > self._patience.answer:
                raise LinkError(DeviceText.NOT_ENDED())
            if state.runtime == PLAYING:
                stood = None
            elif done > total and state.runtime == STOPPED:
                return self._check_stands(state, self._program.q_end, DeviceText.PLAN_END())
            else:
                stood = clock() if stood is None else stood
            # The register and the state of the program come in one packet; a doubt is short.
            if stood is not None and clock() - stood > self._patience.doubt:
                raise LinkError(DeviceText.ENDED_EARLY(where=self._where))

    def _check_leg(self, done: int, at: float) -> None:
        """The leg that is reported follows that before, and all between took their time."""
        total, seconds = len(self._program.legs), self._program.seconds
        self._has_begun = True
        if done == REFUSED:
            raise LinkError(DeviceText.TWICE(where=self._where))
        if not 0 <= done <= total + 1:
            raise ProtocolError(f"the controller reports another program at {self._where}")
        if done < self._leg:
            raise ProtocolError(f"the controller is in leg {done} after {self._where}")
        for before in range(done):
            least = LEAST_TIME * sum(seconds[before : done - 1])
            if at - self._until[before] < least:
                later = at - self._until[before]
                where = f"in leg {done}" if done <= total else "at the end"
                since = f"leg {before}" if before else "the beginning"
                raise ProtocolError(
                    f"the controller is {where} {later:.2f} s after {since}: "
                    f"what is between takes {least / LEAST_TIME:.2f} s"
                )
        for number in range(done, total + 1):
            self._until[number] = at

    def _first(self, cancelled: Cancelled) -> UrState:
        """The first state; the client has to connect before."""
        until = self._patience.clock() + self._patience.answer
        while self._patience.clock() < until:
            if cancelled():
                raise JobCancelled(StopText.NOT_SPOKEN())
            message = self._client.hear(POLL_EVERY)
            if message is not None and message.get("remote") is False:
                raise LinkError(DeviceText.LOCAL_CONTROL())
            state = self._states.take(message)
            if state is not None:
                # How long the client took to connect is not the controller's silence.
                self._fresh = self._patience.clock()
                self._until = dict.fromkeys(self._until, state.at)
                return state
        raise LinkError(DeviceText.NOTHING_NEW(seconds=self._patience.answer))

    def _check_ready(self, state: UrState) -> None:
        if fault := state.fault:
            raise LinkError(DeviceText.CANNOT_MOVE(fault=fault))
        if state.runtime != STOPPED:
            raise LinkError(DeviceText.OTHER_RUNS())
        ticket = self._program.ticket
        if ticket in state.begun or 0 <= state.leg - ticket < TICKETS:
            raise LinkError(DeviceText.RUN_BEFORE())
        self._check_stands(state, self._program.q_start, DeviceText.PLAN_START())

    def _check_stands(self, state: UrState, q: Floats, where: Message) -> None:
        off = np.abs(state.q - q)
        if not off.max() <= START_TOLERANCE:
            joint = self._arm.joints[int(off.argmax())]
            raise LinkError(DeviceText.OFF_TARGET(joint=joint, off=float(off.max()), where=where))

    def _check_follows(self, state: UrState) -> None:
        """Where the arm is streamed, it is on the way of the leg that it says it is in."""
        if not self._program.references:
            return
        off = off_the_references(state.q, self._program.references[max(self._leg - 1, 0)])
        if not off.max() <= FOLLOWING_TOLERANCE:
            joint = self._arm.joints[int(off.argmax())]
            raise LinkError(
                DeviceText.NOT_FOLLOWING(name=joint, off=float(off.max()), where=self._where)
            )

    def _hear(self) -> UrState | None:
        """A state that is news; we say that we are there as often as we look."""
        began = self._patience.clock()
        message = self._client.hear(POLL_EVERY)
        if message is not None and message.get("sent") is False:
            raise LinkError(DeviceText.NOT_TAKEN())
        state = self._states.take(message)
        if state is not None:
            self._fresh = self._patience.clock()
            self._alive += 1
            self._client.say(alive=self._alive)
        # What comes while this process stands still is heard next, so that is no silence.
        elif began - self._fresh > self._patience.silence:
            raise LinkError(DeviceText.SILENT(seconds=self._patience.silence, where=self._where))
        return state

    def _stop(self) -> None:
        """Stop the robot, and wait for its word.

        Raises:
            JobCancelled: always.
        """
        missing = StopText.NOT_STANDING()
        clock = self._patience.clock
        began, is_heard, before = clock(), False, None
        try:
            self._client.say(stop=True)
            while clock() - began < self._patience.stop:
                message = self._client.hear(POLL_EVERY)
                is_heard = is_heard or (message is not None and "stopping" in message)
                state = self._states.take(message)
                if state is None or not is_heard:
                    continue
                # What was on its way when the stop was heard says nothing: two that agree do.
                last, before = before, state if state.stands else None
                if last is not None and before is not None and _is_still(last, before):
                    took = clock() - began
                    words = StopText.STANDS(took=took)
                    legs, at = len(self._program.legs), self._now()
                    self._show(
                        LinkStatus(self._link, "stopped", self._leg, legs, "", 0.0, at, took, words)
                    )
                    raise JobCancelled(StopText.AT(where=self._where, how=words))
        except LinkError as error:
            missing = StopText.SINCE(what=missing, why=error.message)
        raise JobCancelled(StopText.AT(where=self._where, how=missing))

    def _report(self, state: UrState) -> None:
        joints, at = {self._arm.name: state.q}, self._now()
        phase = "running" if state.runtime == PLAYING else "stopped"
        legs = len(self._program.legs)
        heard = f"leg {self._leg}"
        self._show(LinkStatus(self._link, phase, self._leg, legs, heard, at, at, joints=joints))

    def _receipt(self, kind: str, sent: str = "", heard: str = "") -> Receipt:
        total = len(self._program.legs)
        return Receipt(self._now(), self._arm.name, kind, sent, self._leg, total, heard)


def _is_still(before: UrState, after: UrState) -> bool:
    return bool(np.abs(after.q - before.q).max() < STANDS_WITHIN)
