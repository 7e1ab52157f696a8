"""Our side of `abb-socket/2` without sockets: the next message, and the meaning of each answer.

    controller  send                            As in `abb-socket`, on every new connection.
    we          hello abb-socket/2              A client of the older protocol sends `startR#`.
    controller  hello abb-socket/2 <arms>
    we          plan, ticket, start..., leg, to...    Each is acknowledged before the next.
    we          end, run                        From here on the robot moves.
    controller  state, at                       Sent repeatedly.
    we          next                            Allows a step, when a plan is sent step by step.
    controller  part                            Once for each hand that releases a part.
    controller  done

While the robot moves, we send `ping`.  A side that receives nothing for its patience takes the link
for dead: we stop, and so does the controller.  `abort` may be sent at any time.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

from workbench.devices.abb_socket.frames import (
    FIRST_CRC,
    TEXT,
    Frames,
    MessageFrame,
    crc_of,
    make_frame,
    number_after,
)
from workbench.devices.abb_socket.messages import REQUEST
from workbench.devices.abb_socket.program import ProgramLine, SocketProgram, lines_of
from workbench.devices.abb_socket.program_reports import ProgramReports
from workbench.model.cell import Cell
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.messages.devices import DeviceText
from workbench.model.messages.message import Message
from workbench.model.messages.work import StopText
from workbench.model.plan import Plan
from workbench.model.release import LinkStatus, Receipt
from workbench.plugins.robot_link import USUAL, none_let

VERSION = "abb-socket/2"

PING = 0.5
"""[s] We say something at least this often."""


def arms_of(cell: Cell) -> str:
    """The arms of a cell as a controller reports them: letter and number of axes."""
    return " ".join(f"{arm.controller_id}{len(arm.joints)}" for arm in cell.arms)


class SocketSending:
    """One conversation in which one plan is sent.

    Lifetime: one connection.  Times `at` are of a clock that never goes back.
    """

    def __init__(
        self,
        cell: Cell,
        plan: Plan,
        program: SocketProgram,
        *,
        now: Callable[[], float],
        released: Callable[[], None],
        let: Callable[[], int] = none_let,
        silence: float = USUAL.silence,
    ) -> None:
        """Get ready to send.

        Args:
            cell: whose controller it is.
            plan: that the program was made from.
            program: what is sent.
            now: seconds since the epoch, for the receipts.
            released: called before the robot moves; raises when the approval does not hold.
            let: the step that a person has let run last, counted from 1.
            silence: [s] without a word after which the controller counts as gone.
        """
        self._cell, self._plan, self._program = cell, plan, program
        self._now, self._released, self._let, self._silence = now, released, let, silence
        self._lines = (
            ProgramLine("", "hello", VERSION),
            *lines_of(cell, program),
            ProgramLine("", "end", ""),
            ProgramLine("", "run", program.ticket),
        )
        self._frames = Frames()
        self._greeting = b""
        self._number = self._acknowledged = 0
        self._reports = ProgramReports(cell, plan, program)
        # The step that the controller waits before.
        self._waits = 0
        self._crc = FIRST_CRC
        self._points = sum(len(leg.seconds) for leg in program.legs)
        self._waiting: tuple[MessageFrame, ProgramLine | None, float] | None = None
        self._said_at = self._heard_at = self._aborted_at = None
        self._told = set[object]()
        self._is_done = False
        self.status = LinkStatus(steps=len(program.steps))

    # -- what we say -----------------------------------------------------------------------

    def say(self, at: float) -> bytes:
        """What is to be sent now; empty when it is not our turn.

        Raises:
            CommandRefused: the approval does not hold any more; the robot has not moved.
        """
        if self._waiting is not None or self._greeting != REQUEST:
            return b""
        if self._acknowledged < len(self._lines):
            line = self._lines[self._acknowledged]
            if line.word == "end":
                line = replace(line, rest=f"{self._points:03d} {self._crc:04X}")
            if line.word == "run":
                self._released()
            return self._frame(line.word, line.rest, line, at)
        if self._waits and self._let() == self._waits:
            self._reports.may, self._waits = self._waits, 0
            line = ProgramLine("", "next", f"{self._reports.may:02d}")
            return self._frame(line.word, line.rest, line, at)
        if at - (self._said_at or 0.0) >= PING:
            return self._frame("ping", "", None, at)
        return b""

    def abort(self, at: float) -> bytes:
        """The word that stops the robot; to be sent at once."""
        self._aborted_at = at
        return self._frame("abort", "", None, at)

    def _frame(self, word: str, rest: str, line: ProgramLine | None, at: float) -> bytes:
        self._number = number_after(self._number)
        data = make_frame(self._number, f"{word} {rest}".rstrip())
        text = data[:TEXT].decode("ascii")
        frame = MessageFrame(self._number, word, rest, data[TEXT:-1].decode("ascii"))
        if word not in ("hello", "end", "run"):
            self._crc = crc_of(text, self._crc)
        self._waiting, self._said_at = (frame, line, at), at
        return data

    # -- what we hear ----------------------------------------------------------------------

    @property
    def is_over(self) -> bool:
        """Whether the controller has reported the end."""
        return self._is_done

    @property
    def is_begun(self) -> bool:
        """Whether the controller has been spoken to."""
        return self._number > 0

    @property
    def has_stopped(self) -> bool:
        """Whether the controller has acknowledged an abort."""
        return self.status.stopped is not None

    @property
    def where(self) -> Message:
        """How far it has come, for people."""
        if self._acknowledged < len(self._lines):
            return DeviceText.MESSAGE(number=self._acknowledged + 1, total=len(self._lines))
        steps = len(self._program.steps)
        if self._waits:
            return DeviceText.STEP_WAITS(number=self._waits, total=steps)
        # A step that may run is under way from our word on, whatever was reported before.
        step = self._reports.step
        if self._program.is_stepped:
            step = max(step, self._reports.may)
        return DeviceText.STEP(number=step, total=steps)

    @property
    def _is_run(self) -> bool:
        """Whether the controller has acknowledged `run`."""
        return self._acknowledged == len(self._lines)

    @property
    def _hint(self) -> str:
        """What a refusal may come from."""
        is_ticket = self._waiting is not None and self._waiting[0].word == "ticket"
        if self._program.is_stepped and is_ticket:
            return "; perhaps it cannot wait before steps: its program is older"
        return ""

    def check(self, at: float) -> None:
        """Notice that the other side has fallen silent; call it after all was heard.

        Raises:
            LinkError: it has.
        """
        if self._heard_at is None:
            self._heard_at = at
        if self._waiting is not None and at - self._waiting[2] > self._silence:
            raise LinkError(
                DeviceText.NOT_ACKNOWLEDGED(
                    frame=repr(self._waiting[0].text), seconds=self._silence, where=self.where
                )
            )
        if at - self._heard_at > self._silence:
            raise LinkError(DeviceText.SILENT(seconds=self._silence, where=self.where))

    def hear(self, data: bytes, at: float) -> Iterator[Receipt]:
        """Take what arrived; receipts of what it settles, one by one.

        Raises:
            LinkError: the controller refuses, or reports a fault.
            ProtocolError: it said something that cannot be, or does something else than the plan.
        """
        if data:
            self._heard_at = at
        if self._greeting != REQUEST:
            missing = len(REQUEST) - len(self._greeting)
            self._greeting, data = self._greeting + data[:missing], data[missing:]
            if not REQUEST.startswith(self._greeting) or (data and not self._number):
                raise ProtocolError(
                    f"the controller said {(self._greeting + data)[:40]!r} where {REQUEST!r} was "
                    "expected"
                )
        for frame in self._frames.hear(data):
            if not self._is_done:
                yield from self._take(frame, at)

    def open_receipts(self) -> list[Receipt]:
        """The receipt of a message that went out and was not acknowledged."""
        if self._waiting is None:
            return []
        frame, line, _ = self._waiting
        return [] if line is None else [self._receipt(line, frame, "")]

    def _take(self, frame: MessageFrame, at: float) -> Iterator[Receipt]:
        if self._aborted_at is not None:
            # The abort overtook whatever was under way; only its own answer counts now.
            if frame.word == "stopped":
                took = at - self._aborted_at
                words = StopText.ACKNOWLEDGED(took=took)
                self.status = replace(self.status, phase="stopped", stopped=took, stop=words)
                yield self._make_receipt(frame)
            return
        match frame.word:
            case "hello" | "ok":
                yield from self._take_acknowledgement(frame)
            case "no":
                yield self._make_receipt(frame)
                raise LinkError(
                    DeviceText.REFUSES(where=self.where, why=f"{frame.rest[5:]}{self._hint}")
                )
            case "fault":
                yield self._make_receipt(frame)
                raise LinkError(DeviceText.FAULT(where=self.where, fault=frame.rest))
            case "state":
                yield from self._take_state(frame)
            case "at":
                self._take_joints(frame)
            case "part":
                yield from self._take_part(frame)
            case "done":
                yield from self._take_done(frame)
            case _:
                raise ProtocolError(f"the controller said {frame.text!r}, which means nothing")

    def _take_acknowledgement(self, frame: MessageFrame) -> list[Receipt]:
        if self._waiting is None:
            raise ProtocolError(f"the controller acknowledged twice: {frame.text!r}")
        ours, line, _ = self._waiting
        if ours.word == "hello":
            self._check_hello(frame)
        elif frame.word != "ok" or frame.words != [f"{ours.number:04d}", ours.crc]:
            raise ProtocolError(f"the controller answered {ours.text!r} by {frame.text!r}")
        self._waiting = None
        now = self._now()
        self.status = replace(self.status, acknowledged=frame.text, acknowledged_at=now)
        if line is None:
            return []
        self._acknowledged += line.word != "next"
        return [self._receipt(line, ours, frame.text)]

    def _check_hello(self, frame: MessageFrame) -> None:
        version, _, arms = frame.rest.partition(" ")
        if frame.word != "hello" or version != VERSION:
            raise ProtocolError(f"the controller speaks {frame.text[5:]!r}, here it is {VERSION}")
        if arms != arms_of(self._cell):
            raise ProtocolError(
                f"the controller has the arms {arms}, cell {self._cell.name} {arms_of(self._cell)}"
            )
        self.status = replace(self.status, version=version)

    def _take_state(self, frame: MessageFrame) -> list[Receipt]:
        phase, step, points = self._reports.state(frame)
        self.status = replace(self.status, phase=phase, step=step, reported_at=self._now())
        waits = 0
        if not self._is_run:
            self._reports.check_before(frame, phase, step, points)
        elif phase == "waiting":
            waits = self._check_wait(frame, step, points)
        elif phase == "running":
            self._reports.check_motion(step, points)
        else:
            raise ProtocolError(f"the controller says it is {phase}, it should be running")
        # Each is told once, and before the robot moves each phase: a controller that repeats
        # itself fills no journal.
        is_complete = self._reports.step or phase == "waiting"
        said = (phase, step, *sorted(points.items())) if is_complete else phase
        if said in self._told:
            return []
        self._told.add(said)
        running = step if phase == "running" else 0
        return [replace(self._make_receipt(frame), waits=waits, step=running)]

    def _check_wait(self, frame: MessageFrame, step: int, points: Mapping[str, int]) -> int:
        """The step that it waits before; 0 as long as our word that this one may run is on its way.

        Raises:
            ProtocolError: it is not the next one, or something moves.
        """
        is_under_way = self._waiting is not None and self._waiting[0].word == "next"
        if is_under_way and step == self._reports.may:
            return 0
        self._reports.check_wait(frame, step, points)
        self._waits = step
        return step

    def _take_joints(self, frame: MessageFrame) -> None:
        arm, q = self._reports.joints(frame)
        joints = {**(self.status.joints or {}), arm: q}
        self.status = replace(self.status, joints=joints, reported_at=self._now())

    def _take_part(self, frame: MessageFrame) -> list[Receipt]:
        self._check_is_run(frame)
        if self._reports.is_dropped(frame):
            return [self._make_receipt(frame)]
        part = self._reports.part(frame)
        return [replace(self._make_receipt(frame), arm=part.arm, part=part)]

    def _take_done(self, frame: MessageFrame) -> list[Receipt]:
        self._check_is_run(frame)
        self._reports.check_done(frame, self.where)
        self._is_done = True
        self.status = replace(self.status, phase="done")
        return [self._make_receipt(frame)]

    def _check_is_run(self, frame: MessageFrame) -> None:
        if not self._is_run:
            raise ProtocolError(f"{frame.text!r} comes too early, before we sent run")

    def _receipt(self, line: ProgramLine, ours: MessageFrame, heard: str) -> Receipt:
        return Receipt(
            self._now(),
            line.arm,
            line.word,
            ours.text,
            self._acknowledged,
            len(self._lines),
            heard,
        )

    def _make_receipt(self, frame: MessageFrame) -> Receipt:
        done, total = self._acknowledged, len(self._lines)
        return Receipt(self._now(), "", "heard", "", done, total, frame.text)
