"""The seam of robot links: how an approved plan reaches a controller."""

import math
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Protocol

from workbench.model.cell import Cell, Controller
from workbench.model.errors import CommandRefused, InputError
from workbench.model.messages.devices import DeviceText
from workbench.model.motion import MotionModel
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, Receipt, RobotState
from workbench.plugins.found import USUAL as USUAL_NAME
from workbench.plugins.found import Group, load
from workbench.plugins.misfit import misfit
from workbench.plugins.options import Options, options_of
from workbench.plugins.progress import Cancelled, never
from workbench.plugins.report_checks import Receipts, check_state, check_status

ENTRY_POINTS: Group = "workbench.robot_links"


@dataclass(frozen=True, slots=True)
class LinkPatience:
    """How long both ends of a link wait.  The defaults are for safety; tests use other values.

    Times are in seconds of `clock`, a monotonic clock.
    """

    silence: float = 2.0
    """Longest silence on a link that is used all the time; after it the link counts as dead."""

    answer: float = 30.0
    """Longest wait for the next request of a robot that moves between two requests."""

    stop: float = 2.0
    """Longest wait for the acknowledgement of a stop."""

    report: float = 1.0
    """Longest delay of a state report behind the controller."""

    doubt: float = 0.3
    """Wait for the fault on the link, after a state has reported it: the link is more precise."""

    clock: Callable[[], float] = time.monotonic


USUAL = LinkPatience()


def none_let() -> int:
    """No step is allowed."""
    return 0


@dataclass(frozen=True, slots=True)
class Simulation:
    """Options of a simulated controller.

    Attributes:
        port, state_port: 0 takes a free port.
        speed: 1 is real time.
        record: file for the received messages.
        trace: file for the positions of the arms.
        faults: faults to simulate, in the simulator's own words.
        home_after: time [s] after a stop at which the arms go home by themselves.
        rapid: folder of RAPID modules to run unchanged; links without RAPID refuse it.
    """

    host: str = "127.0.0.1"
    port: int = 0
    state_port: int = 0
    speed: float = 1.0
    record: Path | None = None
    trace: Path | None = None
    faults: Sequence[str] = ()
    home_after: float = math.inf
    rapid: Path | None = None


class Running(Protocol):
    """A simulated controller that runs."""

    @property
    def port(self) -> int:
        """The port for motion."""
        ...

    @property
    def state_port(self) -> int:
        """The port for states."""
        ...

    def stop(self) -> None:
        """End the simulation; a signal handler may call this."""
        ...


class RobotLink(Protocol):
    """A protocol to a kind of controller.

    A link is stateless: one thread may run `send` while another runs `states`.  Configurations are
    in chain order and radians.  `Arm.axis_order` and `Arm.axis_signs` map them to the controller's
    axes, and `Arm.controller_id` is the controller's name of the arm.

    `motion` describes how the controller moves.  Planning, timing and proof rely on it, so it must
    cover everything that the controller may do.  `Options` is the dataclass of the keys below
    `[controller.options]` in the cell file (`plugins.options`), or `NoOptions`.  If the options
    change the motion, the link also has a method `motion_by(options)`, which returns the model with
    them; `motion` is the model without options.
    """

    motion: MotionModel
    Options: type

    def check(self, cell: Cell) -> None:
        """Check that the link can serve a cell.

        Raises:
            InputError: it cannot, for instance because the cell has too many arms.
        """
        ...

    def send(
        self,
        plan: Plan,
        approval: Approval,
        cell: Cell,
        *,
        now: Callable[[], float],
        cancelled: Cancelled,
        show: Callable[[LinkStatus], None],
        patience: LinkPatience,
    ) -> Iterator[Receipt]:
        """Execute a plan; yields a receipt for each message, as soon as it was sent or received.

        The link calls `check_approval` once more before motion begins.  It sends nothing twice:
        after any error it closes the connection.  Closing the iterator closes the connection, and
        the robot comes to rest.  The iterator ends after the controller has ended the last motion.

        Args:
            plan: its legs run in the order of `plan.sequence`.
            approval: the release of the plan.
            cell: `cell.controller` has the address and the options.
            now: returns seconds since the epoch.
            cancelled: called at least every 0.1 s; True stops the robot.
            show: receives each change of the link's status.
            patience: how long the link waits for the controller.

        Raises:
            CommandRefused: the approval is for another plan, or has expired; nothing has moved.
            InputError: the protocol cannot express the plan; nothing was sent.
            LinkError: no connection, silence, a refusal, or the controller closed the link.
            JobCancelled: `cancelled` returned True; the message states whether the robot rests.
        """
        ...

    def states(self, cell: Cell, cancelled: Cancelled) -> Iterator[RobotState]:
        """The states that the controller reports, as they arrive, also while nothing is sent.

        The iterator of a controller that reports no states ends at once.

        Raises:
            LinkError: no answer, or the connection broke; the caller tries again later.
        """
        ...

    def serve(self, cell: Cell, simulation: Simulation, ready: Callable[[Running], None]) -> None:
        """Run a simulated controller of this cell until somebody calls its `stop`.

        Args:
            cell: the cell that it moves.
            simulation: its options.
            ready: receives the controller once clients can connect.

        Raises:
            InputError: this link has no simulated controller, or does not know one of the faults.
        """
        ...


class SteppedLink(RobotLink, Protocol):
    """A link that can also run a plan step by step: its motion model `takes_steps`."""

    def send(
        self,
        plan: Plan,
        approval: Approval,
        cell: Cell,
        *,
        now: Callable[[], float],
        cancelled: Cancelled,
        show: Callable[[LinkStatus], None],
        patience: LinkPatience,
        let: Callable[[], int] = none_let,
    ) -> Iterator[Receipt]:
        """As `RobotLink.send`; if the approval `is_stepped`, a person allows each step.

        The controller waits before each step of `plan.sequence`, also before the first.  One
        receipt names that step (`Receipt.waits`, counted from 1).  The step runs once `let` returns
        its number; any other number starts nothing.  Stop, silence and faults count during the wait
        as in motion.

        `let` returns the last step that a person has allowed, 0 before the first.
        """
        ...


def usual_link() -> str:
    """The name of the link for cell files that name none."""
    return link_named(USUAL_NAME).motion.link


def link_named(name: str) -> RobotLink:
    """The robot link of that name.

    Raises:
        InputError: there is none, or it has no motion model.
    """
    link: Any = load(ENTRY_POINTS, name)
    link = link() if isinstance(link, type) else link
    if not isinstance(getattr(link, "motion", None), MotionModel):
        raise InputError(f"the robot link {name!r} has no motion model")
    return link


def motion_of(link: RobotLink, options: Options) -> MotionModel:
    """The motion model of a link with these options.

    Raises:
        InputError: the options are wrong.
    """
    motion_by = getattr(link, "motion_by", None)
    return link.motion if motion_by is None else motion_by(options)


def controller_by(
    name: str,
    host: str = "127.0.0.1",
    port: int = 1025,
    state_port: int | None = None,
    options: Options | None = None,
) -> Controller:
    """A controller with the link of that name.

    Raises:
        InputError: there is no such link, or its options are wrong.
    """
    link, options = link_named(name), options or {}
    options_of(link.Options, options)
    state_port = min(port + 1, 65535) if state_port is None else state_port
    return Controller(host, port, state_port, motion_of(link, options), options)


def spoken_to_by(cell: Cell, name: str) -> Cell:
    """The cell with another link to its controller, at the same address and without options."""
    motion = link_named(name).motion
    return replace(cell, controller=replace(cell.controller, motion=motion, options={}))


def check_approval(plan: Plan, approval: Approval, cell: Cell, now: float) -> None:
    """Check that an approval is for exactly this plan in this cell, and has not expired.

    Raises:
        CommandRefused: the message states the difference, or the expiry.
    """
    pairs = (
        (DeviceText.PLAN, approval.plan_digest, plan.digest),
        (DeviceText.CELL, approval.cell_digest, cell.digest),
        (DeviceText.PLAN_CELL, plan.cell_digest, cell.digest),
        (DeviceText.SCAN, approval.scan_digest, plan.scan_digest),
    )
    for what, approved, present in pairs:
        if approved != present:
            raise CommandRefused(
                DeviceText.OTHER_APPROVAL(what=what(), approved=approved[:12], present=present[:12])
            )
    if approval.is_switched_off and not cell.controller.motion.sends_poses:
        raise CommandRefused(DeviceText.NOBODY_APPROVED(link=cell.controller.link))
    if now < approval.at:
        raise CommandRefused(DeviceText.APPROVAL_EARLY(seconds=approval.at - now))
    if not now < approval.until:
        raise CommandRefused(DeviceText.APPROVAL_OVER(seconds=now - approval.until))


def _unseen(status: LinkStatus) -> None:
    pass


def send(
    plan: Plan,
    approval: Approval,
    cell: Cell,
    *,
    now: Callable[[], float] = time.time,
    cancelled: Cancelled = never,
    show: Callable[[LinkStatus], None] = _unseen,
    patience: LinkPatience = USUAL,
    let: Callable[[], int] = none_let,
) -> Iterator[Receipt]:
    """Send a plan to the controller of the cell, by the link of the cell; see `SteppedLink.send`.

    Every number from any link is checked, and the receipts must cover the whole plan
    (`plugins.report_checks`).  After an impossible report the link is closed, and the robot stops.

    Raises:
        CommandRefused: also if the controller cannot run the plan as it was proven.
        ProtocolError: the controller reports something impossible, or ends too early.
    """
    check_approval(plan, approval, cell, now())
    if problem := misfit(plan, cell, approval.manner):
        raise CommandRefused(problem)
    link = link_named(cell.controller.motion.link)
    words: dict[str, Any] = {}
    if approval.is_stepped:
        if not link.motion.takes_steps:
            raise CommandRefused(DeviceText.NO_STEPS(link=link.motion.link))
        words["let"] = let

    def show_status(status: LinkStatus) -> None:
        check_status(status, cell)
        show(status)

    receipts = Receipts(plan, link.motion)
    sending = link.send(
        plan,
        approval,
        cell,
        now=now,
        cancelled=cancelled,
        show=show_status,
        patience=patience,
        **words,
    )
    with _closing(sending):
        try:
            for receipt in sending:
                receipts.check(receipt)
                yield receipt
        except CommandRefused:
            raise
        except InputError as error:
            unsendable = DeviceText.UNSENDABLE(link=link.motion.link, detail=error.message)
            raise InputError(unsendable) from None
    receipts.check_end()


def states(cell: Cell, cancelled: Cancelled = never) -> Iterator[RobotState]:
    """The states of the cell's controller, each checked; see `RobotLink.states`.

    Raises:
        ProtocolError: a state is impossible.
    """
    reports = link_named(cell.controller.link).states(cell, cancelled)
    with _closing(reports):
        for state in reports:
            check_state(state, cell)
            yield state


@contextmanager
def _closing(iterator: Iterator[Any]) -> Generator[None]:
    """Close the iterator at the end of the block; this closes its connection."""
    try:
        yield
    finally:
        if isinstance(iterator, Generator):
            iterator.close()
