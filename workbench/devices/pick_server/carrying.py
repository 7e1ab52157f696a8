"""One plan while a robot program asks for it: what may be asked next, and what it reports."""

from collections.abc import Callable

import numpy as np

from workbench.devices.pick_server.axes import AxisWords
from workbench.devices.pick_server.lines import BadLine, Request, read_whole
from workbench.devices.pick_server.program import AskedLeg, AskedProgram
from workbench.model.errors import LinkError, ProtocolError
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.work import AskText
from workbench.model.release import PartReport, Receipt
from workbench.plugins.progress import Cancelled, never

Words = tuple[str, ...]

MISSED = "missed"
"""The reason of a failure by which the hand has closed on nothing."""


class Carrying:
    """One plan that waits to be asked for, goes out, and comes to its end or to a doubt.

    Lifetime: one sending.  Concurrency: `Conversation` calls it under its lock.
    """

    def __init__(
        self,
        program: AskedProgram,
        axes: AxisWords,
        *,
        now: Callable[[], float],
        released: Callable[[], None],
        cancelled: Cancelled = never,
    ) -> None:
        """Offer a plan.

        Args:
            program: what is asked for.
            axes: how joints are read.
            now: seconds since the epoch, for the receipts.
            released: called before each leg goes out; raises when the approval does not hold.
            cancelled: whether somebody has stopped it: asked before anything is answered.
        """
        self.program, self._axes = program, axes
        self._now, self._released, self._cancelled = now, released, cancelled
        self.is_taken, self.is_over = False, False
        self.fault: Exception | None = None
        self.is_stopping, self.is_acknowledged = False, False
        # Legs that were answered and that were reported as done; waypoints of the last one.
        self._given = self.done = self._points = self._count = 0
        self._is_gripped = self._is_reported = self._has_held = False
        self.part: PartReport | None = None
        self.receipts: list[Receipt] = []

    @property
    def where(self) -> Message:
        """How far it has come, for people."""
        if not self._given:
            return AskText.BEFORE()
        return AskText.LEG(leg=self._given, legs=len(self.program.legs))

    @property
    def is_moving(self) -> bool:
        """Whether the robot may be on a leg."""
        return self._given > self.done

    @property
    def seconds(self) -> float:
        """[s] That were planned for the leg that goes out."""
        return self._leg.seconds if self._given else 0.0

    @property
    def step(self) -> int:
        """The step of the plan that runs, from 1 on; 0 before the first."""
        return self._given

    @property
    def is_asked_for(self) -> bool:
        """Whether the robot program has it, and is to go on asking."""
        return self.is_taken and not (self.is_over or self.is_stopping)

    def answer(self, request: Request) -> Words:
        """What is answered to a job of the plan; a doubt ends it, and is answered by `STOP`."""
        # Whoever takes the receipts may be held up by a disk just then.
        self.is_stopping = self.is_stopping or self._cancelled()
        if self.is_stopping:
            return "STOP", "stopped"
        try:
            words = self._answer(request)
        except BadLine:
            raise
        except Exception as error:
            return self.doubt(error)
        return words

    def doubt(self, why: Exception) -> Words:
        """Nothing more of the plan goes out."""
        self.fault, self.is_stopping = self.fault or why, True
        return "STOP", "doubt"

    def _answer(self, request: Request) -> Words:
        match request.job:
            case "next" if not self.is_taken:
                return self._next(request)
            case "leg" if self._given == self.done < len(self.program.legs):
                return self._give(request)
            case "point" if self.is_moving and self._points < len(self._leg.points):
                return self._point(request)
            case "done" if self.is_moving and self._points == len(self._leg.points):
                return self._end_leg(request)
            case "picked" if self._is_gripped and not self._is_reported:
                self._has_held = True
                return self._acknowledge(request)
            case "placed" if self._is_open_again and not self._is_reported:
                return self._report(request, is_picked=True)
            case "failed" if self._is_gripped and not self._is_reported:
                return self._report(request, is_picked=False)
            case "stop":
                why = request.words[0] if request.words else "-"
                raise LinkError(AskText.STOPPED(where=self.where, why=why))
            case _:
                raise ProtocolError(AskText.WRONG_JOB(job=request.job, where=self.where))

    @property
    def _leg(self) -> AskedLeg:
        return self.program.legs[self._given - 1]

    @property
    def _is_open_again(self) -> bool:
        return self._is_gripped and self._leg.hand == "open"

    def _next(self, request: Request) -> Words:
        self._check_stands(request.words, self.program.q_start, in_motion=False)
        self.is_taken = True
        self._count += 1
        return self._record(self.program.words, request)

    def _give(self, request: Request) -> Words:
        self._check_number(request, 0, self.done + 1)
        # From here on the robot moves.
        self._released()
        self._given, self._points = self.done + 1, 0
        self._is_gripped = self._is_gripped or self._leg.hand == "grip"
        self._count += 1
        return self._record(self._leg.words, request)

    def _point(self, request: Request) -> Words:
        self._check_number(request, 0, self._given)
        self._check_number(request, 1, self._points + 1)
        self._points += 1
        self._count += 1
        return self._record(self._leg.points[self._points - 1], request)

    def _end_leg(self, request: Request) -> Words:
        self._check_number(request, 0, self._given)
        self._check_stands(request.words[1:], self._leg.q_end, in_motion=True)
        is_owed = self._is_gripped and not self._is_reported
        if self._given == len(self.program.legs) and is_owed:
            raise ProtocolError(AskText.WRONG_JOB(job="done", where=self.where))
        self.done = self._given
        self._count += 1
        self.is_over = self.done == len(self.program.legs)
        return self._record(("OK", "end" if self.is_over else "leg"), request)

    def _report(self, request: Request, *, is_picked: bool) -> Words:
        self._report_part(request, is_picked=is_picked)
        return self._acknowledge(request, self.part)

    def _report_part(self, request: Request, *, is_picked: bool) -> None:
        why = "" if is_picked else (request.words or ("-",))[0]
        self._is_reported = True
        is_missed = why == MISSED and self._may_have_missed
        self.part = PartReport(self.program.arm, self.program.detection, is_picked, why, is_missed)

    @property
    def _may_have_missed(self) -> bool:
        """Whether the hand can have closed on nothing: what it held before has fallen."""
        return self._leg.hand == "grip" and not self._has_held

    def _acknowledge(self, request: Request, part: PartReport | None = None) -> Words:
        return self._record(("OK", request.job), request, part)

    def _record(self, words: Words, request: Request, part: PartReport | None = None) -> Words:
        heard = " ".join((request.job, *request.words))
        receipt = Receipt(
            self._now(),
            self.program.arm,
            request.job,
            " ".join(words),
            self._count,
            self.program.total,
            heard,
            part,
            step=self.step,
        )
        self.receipts.append(receipt)
        return words

    def _check_number(self, request: Request, place: int, wanted: int) -> None:
        if len(request.words) <= place:
            raise BadLine("count")
        if read_whole(request.words[place], 9999) != wanted:
            raise ProtocolError(AskText.WRONG_JOB(job=request.job, where=self.where))

    def _check_stands(self, words: Words, there: Floats, *, in_motion: bool) -> None:
        q = self._check_joints(words, in_motion=in_motion)
        if joint := self._axes.far_from(q, there):
            raise LinkError(AskText.ELSEWHERE(where=self.where, joint=joint))

    def _check_joints(self, words: Words, *, in_motion: bool = False) -> Floats:
        """The configuration (n,) [rad, m] that was reported, once it can be one."""
        try:
            return np.asarray(self._axes.read(words, in_motion=in_motion))
        except BadLine:
            raise
        except ProtocolError as error:
            text = AskText.NO_JOINTS(where=self.where, problem=error.message)
            raise ProtocolError(text) from error
