"""The two threads of the robot link: one sends plans, one reads the states of the controller."""

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
"""Gives a command to the bench, with the name of its actor."""

RETRY = 1.0
"""[s] Pause before the next try to connect to a controller that reports no state."""


@dataclass(slots=True)
class Sending:
    """One sending in progress.

    Attributes:
        before: the controller's last report before the sending.
        receipts: receipts of the messages sent since.
        doubt: why the sending must stop from the time `doubted_at` [s] of `clock` on.
        let: last step that a person has allowed, in a plan that is sent step by step.
        following: next plan of the row.
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
        """Whether a person has stopped it, or the reports contradict the plan."""
        return self.stopped.is_set() or (self.doubt is not None and self.clock() >= self.doubted_at)


class LinkRunner:
    """Sends plans to the controller of a cell, and shows the states that the controller reports.

    Lifetime: the connection for states is open from construction until `close`, and opened again
    after a failure; that for motion is open only while a plan is sent.  The constructor starts both
    threads: if the machine has none left, no sending begins that nobody could stop.

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
        # Numbers of the newest connection for states, and of the one that the report came by.
        self._wanted = self._reported_by = 0
        self._runs: queue.SimpleQueue[tuple[Sending, Approval] | None] = queue.SimpleQueue()
        # The sending in progress; the same if only the states report its progress; the latest one.
        self._active = self._watched = cast(Sending | None, None)
        self._latest: Sending | None = None
        self._used: set[str] = set()
        self._status = LinkStatus()
        self._sender = threading.Thread(target=self._send_all, name="robot link", daemon=True)
        self._sender.start()
        self._listener = threading.Thread(target=self._listen, name="robot state", daemon=True)
        self._listener.start()

    def use(self, cell: Cell) -> None:
        """Use another cell from now on; not while a plan is sent."""
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
        # The plans of a row share one event: a stop between two of them stops the next plan.
        stopped = self._stopped
        run = Sending(plan, self._report, stopped, self._patience.clock, following=following)
        self._latest = run
        self._runs.put((run, approval))

    def let(self, number: int) -> None:
        """Allow a step of the current plan; it runs once the robot waits before it."""
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
            fault = self._transmit(run, approval)
            outcome = self._outcome(run, fault)
            if run.following is not None and not fault:
                self._await_start_of(run.following)
            self._end(fault, *outcome)
        except Exception as error:
            # The bench waits for an end, whatever has failed here.
            log.exception("the end of a sending cannot be reported as it was")
            run.stopped.set()  # the next plan of the row may wait in the queue
            self._active = self._watched = None
            # The journal may have refused the text itself, so it is reduced to ASCII.
            text = str(fault or internal_error(error))
            self._end(plain(text.encode("ascii", "backslashreplace").decode()))
            self._show_link(replace(self._status, phase="closed"))

    def _transmit(self, run: Sending, approval: Approval) -> Message | None:
        """Send the plan, message by message; returns the fault that ended it early, or None."""
        fault, is_silent = None, self._is_silent()
        self._show_link(LinkStatus(phase="connecting"))
        try:
            if run.stopped.is_set():
                raise JobCancelled(LinkText.NOTHING_SENT())
            self._spend(approval)
            # A silent link reports no progress: `_compare` checks the states instead.
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
            # Closing the generator closes the link, whichever side ends early.
            with closing(cast(Generator[Receipt, None, None], receipts)):
                for receipt in receipts:
                    run.receipts.append(receipt)
                    self._do(Sent(receipt), ROBOT_LINK)
        except JobCancelled as error:
            # A silent link does not acknowledge the stop.
            if is_silent and self._status.stopped is None:
                self._await_rest(run)
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
        """The number of placed parts, and the report on each part."""
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
        """The last report on each part of the plan; without one the result is None."""
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

    def _await_start_of(self, plan: Plan) -> None:
        """Between two plans of a row: show the joints once they are at the start of the next plan.

        The last report may date from the end of the motion, and the rules decide by the joints.
        """
        cell = self._cell

        def stands(report: RobotState) -> bool:
            return not report.moving and not moved_away(cell, plan, self._by_joint(report.joints))

        report = self._wait_for(stands)
        if report is not None:
            self._show(joints=self._by_joint(report.joints))

    def _await_rest(self, run: Sending) -> None:
        """After a stop by closing the link, which nobody acknowledges: show whether it rests."""
        began = time.monotonic()
        # A new connection brings a new report, also from a robot that rests and reports no change.
        self._wanted += 1
        arrived = len(run.receipts) + (run.before.received if run.before else 0)

        def stands(report: RobotState) -> bool:
            # A message on its way would move the robot once more.
            is_new = self._reported_by == self._wanted
            return is_new and not report.moving and report.received >= arrived

        report = self._wait_for(stands)
        took = time.monotonic() - began
        if report is None or not stands(report):
            self._show_link(replace(self._status, stop=LinkText.NOT_SEEN_STANDING()))
        else:
            words = LinkText.STANDS_AFTER(took=took)
            self._show_link(replace(self._status, stopped=took, stop=words))

    def _show_link(self, status: LinkStatus) -> None:
        self._status = status
        self._show(link=status)
        if self._report is not None:
            return
        if status.phase == "closed":
            # Nobody reports joints any more.
            self._show(joints={}, robot=None)
        elif status.joints:
            words = LinkText.PHASE(
                phase=phase_message(status.phase), step=status.step, steps=status.steps
            )
            self._show(joints=self._by_joint(status.joints), robot=words)

    def _explain(self, fault: Message) -> Message:
        """A fault of the link together with the controller's own message, if there is one."""
        report = self._wait_for(lambda report: report.fault != "")
        if report is None or not report.fault:
            return fault
        return LinkText.CONTROLLER_SAYS(fault=fault, report=report.fault)

    def _placed_since(self, before: RobotState | None, messages: int) -> int:
        """Parts placed since a report, read once the controller has received that many messages."""
        if before is None:
            return 0
        after = self._wait_for(lambda report: report.received - before.received >= messages)
        return 0 if after is None else max(0, after.placed - before.placed)

    def _wait_for(self, condition: Callable[[RobotState], bool]) -> RobotState | None:
        """The newest report, after a short wait for a report that fulfils the condition."""
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
            before, self._report, self._reported_by = self._report, report, count
            self._reports.notify_all()
        if report is not None:
            self._compare(report)
            self._show(joints=self._by_joint(report.joints), robot=_message(report))
        elif before is not None:
            self._show(joints={}, robot=None)

    def _doubt(self, why: Message) -> None:
        """Stop the current plan because a report makes no sense."""
        run = self._active
        if run is not None and not run.doubt:
            run.doubted_at, run.doubt = self._patience.clock(), why

    def _compare(self, report: RobotState) -> None:
        """Stop the sending if a report contradicts it: a new fault, or another arm moves."""
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
