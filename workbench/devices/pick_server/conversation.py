"""The server's side of the conversation, without sockets: requests and their answers.

A request that comes again, by its number, gets the answer that it got: nothing is done twice.
"""

import logging
import secrets
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass

from workbench.devices.pick_server.axes import AxisWords
from workbench.devices.pick_server.carrying import Carrying
from workbench.devices.pick_server.desk import Desk, NoDesk
from workbench.devices.pick_server.lines import (
    LAST,
    BadLine,
    Request,
    answer_bytes,
    number_after,
    read_request,
    read_whole,
)
from workbench.model.errors import InputError, ProtocolError
from workbench.model.geometry import Floats
from workbench.model.messages.work import AskText

log = logging.getLogger(__name__)

VERSION = "pick-server/1"
"""Of paths."""

POSES_VERSION = "pick-poses/1"
"""Of vision only: a robot program for the one is not greeted by the other."""

ALIVE = 2.0
"""[s] A program that was heard so lately is not replaced by another one while it has a plan."""

Words = tuple[str, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Reported:
    """What the robot program said of the robot last: `q` (n,) [rad, m] at [s] of the clock."""

    count: int
    q: Floats
    at: float


class PickConversation:
    """What one server knows of its robot program, over all of its connections.

    Lifetime: as long as the server listens; `session` names it, so that a robot program notices
    another start.  Concurrency: every method may be called from any thread.
    """

    def __init__(
        self,
        axes: AxisWords,
        *,
        clock: Callable[[], float] = time.monotonic,
        session: int | None = None,
    ) -> None:
        """Begin with nobody; `session` [1 to 9999] is drawn by lot where none is given."""
        self.sends_poses = axes.cell.controller.motion.sends_poses
        self._axes, self._form, self._clock = axes, axes.form, clock
        self.session = session or secrets.randbelow(LAST) + 1
        self._changed = threading.Condition()
        self._owner: object = None
        self._run = self._last = 0
        self._request, self._answer = b"", b""
        self._heard_at = -1e9
        self._carrying: Carrying | None = None
        self._is_ended = False
        self.desk: Desk = NoDesk()
        self.reported: Reported | None = None
        self.count = self.placed = 0

    # -- our side --------------------------------------------------------------------------

    def offer(self, carrying: Carrying) -> None:
        """Let a plan be asked for."""
        with self._changed:
            self._carrying = carrying

    def withdraw(self, carrying: Carrying) -> None:
        """End a sending; what the robot program asks for after it is answered by `STOP`."""
        with self._changed:
            if self._carrying is not carrying:
                return
            self._carrying = None
            self._is_ended = carrying.is_taken and not (
                carrying.is_over or carrying.is_acknowledged
            )

    def stop(self, carrying: Carrying) -> None:
        """Answer by `STOP` from now on, until the robot program says that it has stopped."""
        with self._changed:
            carrying.is_stopping = True

    def wait(self, seconds: float) -> None:
        """Wait until something was asked, but no longer."""
        with self._changed:
            self._changed.wait(seconds)

    def silence(self) -> float:
        """[s] Since the robot program was heard last."""
        with self._changed:
            return self._clock() - self._heard_at

    # -- the robot program's side ----------------------------------------------------------

    def owns(self, owner: object) -> bool:
        """Whether a connection is the one that is answered."""
        with self._changed:
            return self._owner is owner

    def leave(self, owner: object) -> None:
        """A connection has ended; the robot program may come back by another."""
        with self._changed:
            if self._owner is owner:
                self._owner = None

    def hear(self, owner: object, line: bytes) -> bytes:
        """The answer to one line without its end, over the connection `owner`."""
        with self._changed:
            try:
                request = read_request(self._form, line)
                if request.job == "hello":
                    return self._hello(owner, request)
                if self._owner is not owner:
                    raise BadLine("hello")
            except BadLine as error:
                return answer_bytes(self._form, 0, "ERR", error.word)
            self._heard_at = self._clock()
            if request.number == self._last:
                return self._again(request, line)
            if request.number != number_after(self._last):
                return answer_bytes(self._form, request.number, "ERR", "number")
            self._last, self._request = request.number, line
            self.count += 1
            try:
                words = self._respond(request)
            except BadLine as error:
                words = ("ERR", error.word)
            except Exception as error:
                # A request without an answer is asked for ever.
                log.exception("the request %s could not be answered", request.job)
                words = self._fail(error)
            self._answer = answer_bytes(self._form, request.number, *words)
            self._changed.notify_all()
            return self._answer

    def _hello(self, owner: object, request: Request) -> bytes:
        version = POSES_VERSION if self.sends_poses else VERSION
        if len(request.words) != 2 or request.words[0] != version:
            raise BadLine("version")
        run, carrying = read_whole(request.words[1], LAST), self._carrying
        if run != self._run:
            if carrying is not None and carrying.is_asked_for:
                if self._owner not in (None, owner) and self._clock() - self._heard_at < ALIVE:
                    raise BadLine("taken")
                carrying.doubt(ProtocolError(AskText.BEGAN_ANEW(where=carrying.where)))
            self._run, self._last, self._request, self._answer = run, 0, b"", b""
            self._is_ended = False
            self.desk.begin_anew()
        self._owner, self._heard_at = owner, self._clock()
        self._changed.notify_all()
        words = ("OK", version, str(self.session), str(self._last))
        return answer_bytes(self._form, 0, *words)

    def _again(self, request: Request, line: bytes) -> bytes:
        if line == self._request:
            return self._answer
        if self._carrying is not None and self._carrying.is_asked_for:
            where = self._carrying.where
            self._carrying.doubt(ProtocolError(AskText.TWICE(where=where)))
            self._changed.notify_all()
        return answer_bytes(self._form, request.number, "ERR", "number")

    def _fail(self, why: Exception) -> Words:
        """An error of ours: a doubt where a plan is under way."""
        if self._carrying is not None and self._carrying.is_asked_for:
            return self._carrying.doubt(why)
        return "NO", "error"

    def _respond(self, request: Request) -> Words:
        carrying = self._carrying
        if request.job == "state":
            return self._state(request.words)
        if self._is_ended:
            # It is owed that answer also where the next plan waits already.
            self._is_ended = request.job != "stop"
            return ("STOP", "ended") if self._is_ended else ("OK", "stop")
        if carrying is not None and carrying.is_stopping and request.job == "stop":
            carrying.is_acknowledged = True
            return "OK", "stop"
        if carrying is not None and (carrying.is_taken or request.job == "next"):
            words = carrying.answer(request)
            if request.job == "placed" and words[0] == "OK":
                self.placed += 1
            if carrying.is_over:
                self._carrying = None
            joints = request.words[request.job == "done" :]
            if request.job in ("next", "done") and words[0] != "STOP" and joints:
                self._report(joints, in_motion=False)
            return words
        if request.job in ("leg", "point", "done", "pose", "picked", "placed", "failed"):
            return "NO", "plan"
        is_reported = request.words or not self.sends_poses
        is_on_a_path = request.job in ("view", "home") and request.words
        if (request.job == "next" and is_reported) or is_on_a_path:
            self._report_at_rest(request.words)
        return self.desk.answer(request)

    def _state(self, words: Words) -> Words:
        carrying = self._carrying
        if words:
            is_asked_for = carrying is not None and carrying.is_asked_for
            try:
                self._report(words, in_motion=is_asked_for)
            except BadLine:
                raise
            except (ProtocolError, InputError) as error:
                if carrying is None or not is_asked_for:
                    raise BadLine("joints") from error
                text = AskText.NO_JOINTS(where=carrying.where, problem=error.message)
                return carrying.doubt(ProtocolError(text))
        if self._is_ended:
            return "STOP", "ended"
        if carrying is None:
            return "OK", self.desk.phase()
        if carrying.is_stopping:
            return "STOP", "stopped"
        return "OK", "moving" if carrying.is_taken else "offered"

    def _report_at_rest(self, words: Words) -> None:
        try:
            self._report(words, in_motion=False)
        except BadLine:
            raise
        except ProtocolError as error:
            raise BadLine("joints") from error

    def _report(self, words: Words, *, in_motion: bool) -> None:
        q = self._axes.read(words, in_motion=in_motion)
        count = self.reported.count + 1 if self.reported else 1
        self.reported = Reported(count, q, self._clock())

    def is_moving(self) -> bool:
        """Whether the robot may be on a leg of a plan."""
        with self._changed:
            return self._carrying is not None and self._carrying.is_moving
