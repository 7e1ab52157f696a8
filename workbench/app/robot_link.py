"""The threads that speak with the robot: one sends a plan, one listens to what it reports."""

import logging
import threading
from collections.abc import Callable, Generator, Mapping
from contextlib import closing
from typing import Any, cast

from workbench.app.commands import Command, LinkEnded, Sent
from workbench.app.rights import ROBOT_LINK
from workbench.app.state import State
from workbench.devices.abb_link import ControllerState, send, watch_state
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, JobCancelled, LinkError, WorkbenchError
from workbench.model.plan import Plan
from workbench.model.release import Approval, Receipt

log = logging.getLogger(__name__)

Clock = Callable[[], float]
"""Seconds since the epoch."""

Do = Callable[[Command, str], State]
"""Gives a command to the bench, with the name of the one who gives it."""

RETRY = 1.0
"""How long [s] to wait before asking again a controller that does not report its state."""

REPORT_SECONDS = 1.0
"""How long [s] a report may lag behind what the controller has done."""


class RobotLink:
    """Sends plans to the controller of a cell, and shows what it reports of itself.

    Lifetime: the controller's reports are listened to from construction until `close`, again
    and again where there are none; a connection for motion exists only while a plan is sent.

    Concurrency: `send` and `stop` return at once; `close` waits until the end of a sending is
    reported.  `do` is called from the sending's thread, `show` from the listening one.
    """

    def __init__(self, cell: Cell, do: Do, now: Clock, show: Callable[..., None]) -> None:
        """Begin to listen.

        Args:
            cell: whose controller it is.
            do: takes `Sent` and `LinkEnded`.
            now: seconds since the epoch.
            show: takes `joints` and `robot` of `Live` as keywords.
        """
        self._cell = cell
        self._do = do
        self._now = now
        self._show = show
        self._stopped = threading.Event()
        self._closing = threading.Event()
        self._reports = threading.Condition()
        self._report: ControllerState | None = None
        self._sender: threading.Thread | None = None
        self._listener = threading.Thread(target=self._listen, name="robot state", daemon=True)
        self._listener.start()

    def use(self, cell: Cell) -> None:
        """Go on with another cell; not while something is sent."""
        self._cell = cell

    def send(self, plan: Plan, approval: Approval) -> None:
        """Begin to send; each message and the end are given to `do`."""
        self._stopped = threading.Event()
        self._start_sender(self._send, plan, approval, self._stopped)

    def stop(self) -> None:
        """Send nothing more, and close the link."""
        self._stopped.set()
        if self._sender is None or not self._sender.is_alive():
            # The end of the sending could not be recorded when it came; perhaps now it can.
            self._start_sender(self._end, "the sending had ended without a record of it", 0)

    def close(self) -> None:
        """Stop, and wait until that is reported."""
        self._stopped.set()
        if self._sender is not None:
            self._sender.join()
        self._closing.set()
        self._listener.join()

    def _start_sender(self, target: Callable[..., None], *arguments: Any) -> None:
        self._sender = threading.Thread(
            target=target, args=arguments, name="robot link", daemon=True
        )
        self._sender.start()

    def _send(self, plan: Plan, approval: Approval, stopped: threading.Event) -> None:
        before, sent, fault = self._report, 0, ""
        receipts = send(plan, approval, self._cell, now=self._now, cancelled=stopped.is_set)
        try:
            # Closing the generator closes the link, whoever breaks off.
            with closing(cast(Generator[Receipt, None, None], receipts)):
                for receipt in receipts:
                    sent += 1
                    self._do(Sent(receipt), ROBOT_LINK)
        except (CommandRefused, JobCancelled) as error:
            fault = str(error)
        except WorkbenchError as error:
            fault = self._explained(str(error))
        except Exception as error:
            log.exception("sending failed")
            fault = f"internal error, see the log: {type(error).__name__}: {error}"
        self._end(fault, self._placed_since(before, 0 if fault else sent))

    def _end(self, fault: str, parts_placed: int) -> None:
        try:
            self._do(LinkEnded(fault, parts_placed), ROBOT_LINK)
        except CommandRefused as error:
            log.error("the end of the sending (%s) is not recorded: %s", fault or "good", error)

    def _explained(self, fault: str) -> str:
        """A fault of the link with what the controller says about it, if it does."""
        report = self._awaited(lambda report: report.fault != "")
        return f"{fault}; the controller says: {report.fault}" if report and report.fault else fault

    def _placed_since(self, before: ControllerState | None, messages: int) -> int:
        """Parts put down since a report, as reported once that many messages have arrived."""
        if before is None:
            return 0
        after = self._awaited(lambda report: report.received - before.received >= messages)
        return 0 if after is None else max(0, after.placed - before.placed)

    def _awaited(self, condition: Callable[[ControllerState], bool]) -> ControllerState | None:
        """The newest report, waiting a little for one that fulfils the condition."""
        with self._reports:
            self._reports.wait_for(
                lambda: self._report is None or condition(self._report), REPORT_SECONDS
            )
            return self._report

    def _listen(self) -> None:
        while not self._closing.is_set():
            controller = self._cell.controller
            try:
                for report in watch_state(
                    controller.host, controller.state_port, self._closing.is_set
                ):
                    self._take(report)
            except LinkError as error:
                log.debug("no report from the robot: %s", error)
            except Exception:
                log.exception("listening to the robot failed")
            self._take(None)
            self._closing.wait(RETRY)

    def _take(self, report: ControllerState | None) -> None:
        with self._reports:
            before, self._report = self._report, report
            self._reports.notify_all()
        if report is not None:
            self._show(joints=self._by_joint(report), robot=_words(report))
        elif before is not None:
            self._show(joints={}, robot="")

    def _by_joint(self, report: ControllerState) -> Mapping[str, float]:
        return {
            joint: angle
            for arm in self._cell.arms
            for joint, angle in zip(arm.joints, report.joints.get(arm.name, ()), strict=False)
        }


def _words(report: ControllerState) -> str:
    if report.fault:
        return f"fault: {report.fault}"
    return f"moves arm {report.moving}" if report.moving else "stands"
