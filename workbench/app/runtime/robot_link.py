"""The threads that speak with the robot: one sends a plan, one listens to what it reports."""

import logging
import queue
import threading
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, field, replace
from typing import cast

from workbench.app.core.command import Command
from workbench.app.core.cycle.sending import LinkEnded, Sent
from workbench.app.core.cycle.standing import moved_away
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.state import State
from workbench.app.runtime.jobs import internal_error
from workbench.app.runtime.record_retries import insist
from workbench.model.cell import Cell
from workbench.model.errors import (
    CommandRefused,
    JobCancelled,
    LinkError,
    ProtocolError,
    WorkbenchError,
)
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message, all_of, plain
from workbench.model.messages.work import LinkText, phase_message
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, PartReport, Receipt, RobotState
from workbench.plugins.robot_link import USUAL, LinkPatience, send, states

log = logging.getLogger(__name__)

Clock = Callable[[], float]
"""Seconds since the epoch."""

Do = Callable[[Command, str], State]
"""Gives a command to the bench, with the name of the one who gives it."""

RETRY = 1.0
"""How long [s] to wait before asking again a controller that does not report its state."""


@dataclass(slots=True)
class Sending:
    """One sending, as it goes.

    `before` is what the controller reported last before it, `receipts` what has gone out since.
    `doubt` says why the sending must not go on from the time `doubted_at` [s] of `clock` on.
    `let` is the last step of the plan that a person has let run, where each waits for that.
    `following` is the plan that may go out after it, in a row.
    """

    plan: Plan
    before: RobotState | None
    stopped: threading.Event
    clock: Callable[[], float]
    receipts: list[Receipt] = field(default_factory=list[Receipt])
    doubt: Message | None = None
    doubted_at: float = 0.0
    let: int = 0
    following: Plan | None = None

    def is_to_stop(self) -> bool:
        """Whether somebody stops it, or what is reported does not fit what was sent."""
        return self.stopped.is_set() or (self.doubt is not None and self.clock() >= self.doubted_at)


class LinkRunner:
    """Sends plans to the controller of a cell, and shows what it reports of itself.

    Lifetime: the controller's reports are listened to from construction until `close`, again
    and again where there are none; a connection for motion exists only while a plan is sent.
    Both threads are there from the beginning: where none can be had, nothing begins that could
    not be ended.

    Concurrency: `send` and `stop` return at once; `close` waits until the end of a sending is
    reported.  `do` is called from the sending's thread, `show` from the listening one.
    """

    def __init__(
        self,
        cell: Cell,
        do: Do,
        now: Clock,
        show: Callable[..., None],
        *,
        patience: LinkPatience = USUAL,
    ) -> None:
        """Begin to listen.

        Args:
            cell: whose controller it is.
            do: takes `Sent` and `LinkEnded`.
            now: seconds since the epoch.
            show: takes `joints`, `robot`, `link` and `unrecorded` of `Live` as keywords.
            patience: how long the controller is waited for.
        """
        self._cell = cell
        self._do = do
        self._now = now
        self._show = show
        self._patience = patience
        self._stopped = threading.Event()
        self._closing = threading.Event()
        self._giving_up = threading.Event()
        self._reports = threading.Condition()
        self._report: RobotState | None = None
        # Connections for reports that were wanted, and the one that the report came by.
        self._wanted = self._told = 0
        self._runs: queue.SimpleQueue[tuple[Sending, Approval] | None] = queue.SimpleQueue()
        # The sending that goes on, the same where reports alone say what is done, and the latest.
        self._active = self._watched = cast(Sending | None, None)
        self._latest: Sending | None = None
        self._used: set[str] = set()
        self._status = LinkStatus()
        self._sender = threading.Thread(target=self._send_all, name="robot link", daemon=True)
        self._sender.start()
        self._listener = threading.Thread(target=self._listen, name="robot state", daemon=True)
        self._listener.start()

    def use(self, cell: Cell) -> None:
        """Go on with another cell; not while something is sent."""
        self._cell = cell

    def send(self, plan: Plan, approval: Approval, following: Plan | None = None) -> None:
        """Begin to send; each message and the end are given to `do`.

        Args:
            plan: what is sent.
            approval: that lets it out.
            following: the plan that may go out after it.
        """
        if not approval.first:
            self._stopped = threading.Event()
        # Of a row all plans have one: a stop that comes between two of them stops the next one.
        stopped = self._stopped
        run = Sending(plan, self._report, stopped, self._patience.clock, following=following)
        self._latest = run
        self._runs.put((run, approval))

    def let(self, number: int) -> None:
        """Let this step of the plan that is being sent run, once the robot waits before it."""
        if self._latest is not None:
            self._latest.let = number

    def stop(self) -> None:
        """Send nothing more, and close the link."""
        self._stopped.set()

    def close(self) -> None:
        """Stop, and wait until that is reported."""
        self._giving_up.set()
        self._stopped.set()
        self._runs.put(None)
        self._sender.join()
        self._closing.set()
        self._listener.join()

    def _send_all(self) -> None:
        while (wanted := self._runs.get()) is not None:
            self._send(*wanted)

    def _send(self, run: Sending, approval: Approval) -> None:
        fault: Message | None = None
        try:
            fault = self._spoken(run, approval)
            outcome = self._outcome(run, fault)
            if run.following is not None and not fault:
                self._see_it_at(run.following)
            self._end(fault, *outcome)
        except Exception as error:
            # Whatever it is, the sending must not seem to go on for ever.
            log.exception("the end of a sending cannot be told as it was")
            run.stopped.set()  # the next plan of the row may wait already
            self._active = self._watched = None
            # A text that no journal can hold may have been the reason.
            text = str(fault or internal_error(error))
            self._end(plain(text.encode("ascii", "backslashreplace").decode()))
            self._show_link(replace(self._status, phase="closed"))

    def _spoken(self, run: Sending, approval: Approval) -> Message | None:
        """Send the plan, message by message; what ended that early, if anything did."""
        fault, is_silent = None, self._is_silent()
        self._show_link(LinkStatus(phase="connecting"))
        try:
            if run.stopped.is_set():
                raise JobCancelled(LinkText.NOTHING_SENT())
            self._spend(approval)
            # Where the link says nothing, nobody else compares what is done with what was said.
            self._active, self._watched = run, run if is_silent else None
            receipts = send(
                run.plan,
                approval,
                self._cell,
                now=self._now,
                cancelled=run.is_to_stop,
                show=self._show_link,
                patience=self._patience,
                let=lambda: run.let,
            )
            # Closing the generator closes the link, whoever breaks off.
            with closing(cast(Generator[Receipt, None, None], receipts)):
                for receipt in receipts:
                    run.receipts.append(receipt)
                    self._do(Sent(receipt), ROBOT_LINK)
        except JobCancelled as error:
            # A link that has nothing but its end says nothing of the robot.
            if is_silent and self._status.stopped is None:
                self._see_it_stand(run)
            fault = error.message if run.stopped.is_set() else all_of((run.doubt, error.message))
        except CommandRefused as error:
            fault = error.message
        except WorkbenchError as error:
            fault = self._explain(error.message) if is_silent else error.message
        except Exception as error:
            log.exception("sending failed")
            fault = internal_error(error)
        return fault

    def _outcome(self, run: Sending, fault: Message | None) -> tuple[int, tuple[PartReport, ...]]:
        """How many parts were put down, and what is known of each."""
        self._active = self._watched = None
        self._show_link(replace(self._status, phase="closed"))
        parts = self._parts(run)
        placed = sum(part.is_picked is True for part in parts)
        if self._is_silent():
            since = self._placed_since(run.before, 0 if fault else len(run.receipts))
            placed = min(since, len(run.plan.picks))
        return placed, parts

    def _is_silent(self) -> bool:
        return not self._cell.controller.motion.reports_progress

    def _spend(self, approval: Approval) -> None:
        """One approval, one sending.

        Raises:
            CommandRefused: it has been used.
        """
        if approval.digest in self._used:
            raise CommandRefused(LinkText.APPROVAL_USED())
        self._used.add(approval.digest)

    def _parts(self, run: Sending) -> tuple[PartReport, ...]:
        """What was reported of each part of the plan; where nothing was, nobody knows."""
        latest = {receipt.part.arm: receipt.part for receipt in run.receipts if receipt.part}
        why = LinkText.NO_REPORT(link=self._cell.controller.link)
        return tuple(
            latest.get(arm.arm, PartReport(arm.arm, arm.detection, None, why))
            for arm in run.plan.picks
        )

    def _end(
        self, fault: Message | None, placed: int = 0, parts: tuple[PartReport, ...] = ()
    ) -> None:
        ended = LinkEnded(fault or "", placed, parts)
        how = fault or LinkText.WENT_WELL()

        def show_unrecorded(problem: Message | None) -> None:
            self._show(unrecorded=problem and LinkText.ENDED_BUT(how=how, problem=problem))

        insist(self._do, ended, ROBOT_LINK, giving_up=self._giving_up, show_problem=show_unrecorded)

    def _see_it_at(self, plan: Plan) -> None:
        """Between two plans: show how the robot stands once that is where the next one starts.

        What is reported may be as old as the last bit of the motion; the rules decide by it.
        """
        cell = self._cell

        def stands(report: RobotState) -> bool:
            return not report.moving and not moved_away(cell, plan, self._by_joint(report.joints))

        report = self._wait_for(stands)
        if report is not None:
            self._show(joints=self._by_joint(report.joints))

    def _see_it_stand(self, run: Sending) -> None:
        """After a stop by closing the link, which nobody acknowledges: what the reports say."""
        began = time.monotonic()
        # What was told before says nothing of now, and who stands may have no news: it is asked.
        self._wanted += 1
        arrived = len(run.receipts) + (run.before.received if run.before else 0)

        def stands(report: RobotState) -> bool:
            # A message on its way would make it move once more.
            is_new = self._told == self._wanted
            return is_new and not report.moving and report.received >= arrived

        report = self._wait_for(stands)
        took = time.monotonic() - began
        if report is None or not stands(report):
            words = LinkText.NOT_SEEN_STANDING()
            self._show_link(replace(self._status, stop=words))
        else:
            words = LinkText.STANDS_AFTER(took=took)
            self._show_link(replace(self._status, stopped=took, stop=words))

    def _show_link(self, status: LinkStatus) -> None:
        self._status = status
        self._show(link=status)
        if self._report is not None:
            return
        if status.phase == "closed":
            # From now on nobody reports where the robot is moved to.
            self._show(joints={}, robot=None)
        elif status.joints:
            words = LinkText.PHASE(
                phase=phase_message(status.phase), step=status.step, steps=status.steps
            )
            self._show(joints=self._by_joint(status.joints), robot=words)

    def _explain(self, fault: Message) -> Message:
        """A fault of the link with what the controller says about it, if it does."""
        report = self._wait_for(lambda report: report.fault != "")
        if report is None or not report.fault:
            return fault
        return LinkText.CONTROLLER_SAYS(fault=fault, report=report.fault)

    def _placed_since(self, before: RobotState | None, messages: int) -> int:
        """Parts put down since a report, as reported once that many messages have arrived."""
        if before is None:
            return 0
        after = self._wait_for(lambda report: report.received - before.received >= messages)
        return 0 if after is None else max(0, after.placed - before.placed)

    def _wait_for(self, condition: Callable[[RobotState], bool]) -> RobotState | None:
        """The newest report, waiting a little for one that fulfils the condition."""
        with self._reports:
            self._reports.wait_for(
                lambda: self._report is None or condition(self._report), self._patience.report
            )
            return self._report

    def _listen(self) -> None:
        while not self._closing.is_set():
            cell, wanted = self._cell, self._wanted

            def is_over(wanted: int = wanted) -> bool:
                return self._closing.is_set() or self._wanted != wanted

            try:
                for report in states(cell, is_over):
                    self._take(report, wanted)
            except ProtocolError as error:
                log.debug("what the robot reports makes no sense: %s", error)
                self._doubt(error.message)
            except LinkError as error:
                log.debug("no report from the robot: %s", error)
            except Exception:
                log.exception("listening to the robot failed")
            if self._wanted == wanted:
                self._take(None, wanted)
                self._closing.wait(RETRY)

    def _take(self, report: RobotState | None, count: int) -> None:
        with self._reports:
            before, self._report, self._told = self._report, report, count
            self._reports.notify_all()
        if report is not None:
            self._compare(report)
            self._show(joints=self._by_joint(report.joints), robot=_message(report))
        elif before is not None:
            self._show(joints={}, robot=None)

    def _doubt(self, why: Message) -> None:
        """A robot of which nonsense is reported goes on with no plan."""
        run = self._active
        if run is not None and not run.doubt:
            run.doubted_at, run.doubt = self._patience.clock(), why

    def _compare(self, report: RobotState) -> None:
        """Whether a report fits what was sent; if not, the sending is to stop."""
        run = self._watched
        if run is None or run.doubt:
            return
        received = report.received - (run.before.received if run.before else 0)
        if report.fault and (received or run.before is None or report.fault != run.before.fault):
            run.doubted_at = self._patience.clock() + self._patience.doubt
            run.doubt = LinkText.REPORTS_FAULT(fault=report.fault)
        elif run.before is not None and report.moving and 1 <= received <= len(run.receipts):
            ordered = run.receipts[received - 1].arm
            if report.moving != ordered:
                run.doubt = LinkText.OTHER_ARM(moving=report.moving, ordered=ordered)

    def _by_joint(self, joints: Mapping[str, Sequence[float] | Floats]) -> Mapping[str, float]:
        return {
            joint: float(angle)
            for arm in self._cell.arms
            for joint, angle in zip(arm.joints, joints.get(arm.name, ()), strict=False)
        }


def _message(report: RobotState) -> Message:
    if report.fault:
        return LinkText.FAULT(fault=report.fault)
    return LinkText.MOVES(arm=report.moving) if report.moving else LinkText.STANDS()
