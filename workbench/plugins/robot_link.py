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
    """How long both ends of a link wait; what safety wants, tests bring others.

    Times are in seconds of `clock`, which never goes back.
    """

    silence: float = 2.0
    """Without a word from the other side, and a link that is spoken all the time counts as dead."""

    answer: float = 30.0
    """Where the robot moves between two requests: longer than this is too long."""

    stop: float = 2.0
    """How long a controller may take to acknowledge a stop."""

    report: float = 1.0
    """How long a report of the state may lag behind what the controller has done."""

    doubt: float = 0.3
    """A controller that reports a fault mostly says so on the link as well, and better."""

    clock: Callable[[], float] = time.monotonic


USUAL = LinkPatience()


def none_let() -> int:
    """Nobody has let a step run."""
    return 0


@dataclass(frozen=True, slots=True)
class Simulation:
    """What a simulated controller is asked to be.

    Ports of 0 are chosen freely.  `speed` 1 is real time.  `record` and `trace` are files for what
    arrives and for where the arms are; `faults` are misbehaviours in the simulator's own words;
    `home_after` [s]: so long after a stop the arms go home by themselves.  `rapid` is a folder of
    modules in RAPID that are to be run as they are; links that know no RAPID refuse it.
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
        """Where it takes motion."""
        ...

    @property
    def state_port(self) -> int:
        """Where it reports its state."""
        ...

    def stop(self) -> None:
        """End it; may be called from a signal handler."""
        ...


class RobotLink(Protocol):
    """One way to speak with controllers.

    It is stateless: an object is made for each name, and `send` may be called by one thread while
    `states` runs in another.  Configurations are in chain order and radians here; what a controller
    calls its axes is in `Arm.axis_order` and `Arm.axis_signs`, and its arms in `Arm.controller_id`.

    `motion` says how the controller moves: planning, timing and proof follow from it, so it must
    never promise less than the controller may do.  `Options` is the dataclass of the keys that
    stand in the cell file under `[controller.options]` (`plugins.options`), or `NoOptions`.  Where
    they change how the controller moves, the link has a method `motion_by(options)` too, which
    gives that model; `motion` is the model without options.
    """

    motion: MotionModel
    Options: type

    def check(self, cell: Cell) -> None:
        """Refuse a cell that cannot be served.

        Raises:
            InputError: for instance more arms than the controller has.
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
        """Execute a plan; a receipt for each message, as soon as it went out or came.

        `check_approval` is asked once more when motion begins.  Nothing is sent twice: after any
        error the connection is closed.  Closing the iterator closes the connection, and the robot
        comes to rest.  It ends when the controller has ended the last motion.

        Args:
            plan: what is sent, in legs that run in the order of `plan.sequence`.
            approval: that lets it out.
            cell: `cell.controller` has the address and the options.
            now: seconds since the epoch.
            cancelled: asked at least every 0.1 s; True stops the robot.
            show: takes how the link stands, when that changes.
            patience: how long the controller is waited for.

        Raises:
            CommandRefused: the approval is not for this, or has run out; nothing has moved.
            InputError: the plan cannot be said by this link; nothing was sent.
            LinkError: no connection, silence, a refusal, or the controller closed the link.
            JobCancelled: `cancelled` said so; the message says how sure it is that it stands.
        """
        ...

    def states(self, cell: Cell, cancelled: Cancelled) -> Iterator[RobotState]:
        """What the controller reports of itself, as it comes, also while nothing is sent.

        An iterator that ends at once says that this controller reports nothing.

        Raises:
            LinkError: nobody answers, or the report broke off; it is called again later.
        """
        ...

    def serve(self, cell: Cell, simulation: Simulation, ready: Callable[[Running], None]) -> None:
        """Be a simulated controller of this cell until `stop` is called on what `ready` is given.

        Raises:
            InputError: this link has no simulated controller, or does not know a fault's word.
        """
        ...


class SteppedLink(RobotLink, Protocol):
    """A link that can also have a plan run step by step: its motion model `takes_steps`."""

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
        """As `RobotLink.send`; of an approval that `is_stepped` each step waits for a word.

        The controller waits before each step of `plan.sequence`, the first one too, and a receipt
        says once before which (`Receipt.waits`, from 1 on).  That step runs when `let` gives its
        number, once; another number lets nothing run.  Stop, silence and faults count while it
        waits as they do in motion.

        `let` returns the number of the step that a person has let run last, 0 before the first.
        """
        ...


def usual_link() -> str:
    """The link of a cell file that names none."""
    return link_named(USUAL_NAME).motion.link


def link_named(name: str) -> RobotLink:
    """The robot link of that name.

    Raises:
        InputError: there is none, or it is not one.
    """
    link: Any = load(ENTRY_POINTS, name)
    link = link() if isinstance(link, type) else link
    if not isinstance(getattr(link, "motion", None), MotionModel):
        raise InputError(f"the robot link {name!r} has no motion model")
    return link


def motion_of(link: RobotLink, options: Options) -> MotionModel:
    """How a controller moves that is spoken to by a link with these options.

    Raises:
        InputError: the options are not right.
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
    """A controller that is spoken to by the link of that name.

    Raises:
        InputError: there is no such link, or its options are not right.
    """
    link, options = link_named(name), options or {}
    options_of(link.Options, options)
    state_port = min(port + 1, 65535) if state_port is None else state_port
    return Controller(host, port, state_port, motion_of(link, options), options)


def spoken_to_by(cell: Cell, name: str) -> Cell:
    """The cell with its controller spoken to by another link, at the same address."""
    motion = link_named(name).motion
    return replace(cell, controller=replace(cell.controller, motion=motion, options={}))


def check_approval(plan: Plan, approval: Approval, cell: Cell, now: float) -> None:
    """Refuse to send what was not approved exactly so.

    Raises:
        CommandRefused: says what differs, or that the approval has run out.
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

    Whatever the link is, every number that it hands on is checked, and it has to tell that all
    was done: `plugins.reported`.  Where one cannot be, the link is closed, and the robot stops.

    Raises:
        CommandRefused: also where the controller cannot run the plan as it was proven.
        ProtocolError: the controller reports what cannot be, or ends too early.
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
    """What the controller of the cell reports, each state checked; see `RobotLink.states`.

    Raises:
        ProtocolError: it reports what cannot be.
    """
    reports = link_named(cell.controller.link).states(cell, cancelled)
    with _closing(reports):
        for state in reports:
            check_state(state, cell)
            yield state


@contextmanager
def _closing(iterator: Iterator[Any]) -> Generator[None]:
    """At the end the connection of an iterator is closed, where it has one."""
    try:
        yield
    finally:
        if isinstance(iterator, Generator):
            iterator.close()
