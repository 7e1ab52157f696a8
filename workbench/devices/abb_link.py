"""Our end of the robot link: an approved plan goes out, message by message, or nothing does."""

import json
import socket
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from workbench.devices.abb_messages import Requests, messages
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, JobCancelled, LinkError, ProtocolError
from workbench.model.plan import Plan
from workbench.model.release import Approval, Receipt

CONNECT_SECONDS = 3.0
ANSWER_SECONDS = 30.0
"""The robot moves between two requests; longer than this and something is wrong."""

POLL_SECONDS = 0.05
LONGEST_LINE = 64 * 1024


@dataclass(frozen=True, slots=True)
class ControllerState:
    """What a controller reports of itself.

    `joints` [rad], chain order, and `openings` [m] by arm; `moving` the arm in motion or "";
    `received` counts messages and `placed` the parts put down since it started.  `fault` is
    empty when there is none.
    """

    joints: dict[str, tuple[float, ...]]
    openings: dict[str, float]
    moving: str
    received: int
    placed: int
    fault: str


def check_approval(plan: Plan, approval: Approval, cell: Cell, now: float) -> None:
    """Refuse to send what was not approved exactly so.

    Raises:
        CommandRefused: says what differs, or that the approval has run out.
    """
    pairs = (
        ("plan", approval.plan_digest, plan.digest),
        ("cell", approval.cell_digest, cell.digest),
        ("cell of the plan", plan.cell_digest, cell.digest),
        ("scan", approval.scan_digest, plan.scan_digest),
    )
    for what, approved, present in pairs:
        if approved != present:
            raise CommandRefused(
                f"the approval is for another {what} ({approved[:12]}, here {present[:12]})"
            )
    if not approval.at <= now <= approval.until:
        raise CommandRefused(f"the approval ran out {now - approval.until:.0f} s ago")


def send(
    plan: Plan,
    approval: Approval,
    cell: Cell,
    *,
    now: Callable[[], float] = time.time,
    cancelled: Callable[[], bool] = lambda: False,
    answer_seconds: float = ANSWER_SECONDS,
) -> Iterator[Receipt]:
    """Send a plan to the controller of the cell; one receipt for each message that went out.

    Nothing is sent twice: after any error the link is closed, and what was sent stands in the
    receipts.  The iterator ends when the controller has asked once more after the last message,
    which says that the last motion has ended.

    Raises:
        CommandRefused: the approval is not for this, or has run out; nothing was sent.
        InputError: the plan cannot be said in this protocol; nothing was sent.
        LinkError: no connection, no request in time, or the controller closed the link.
        ProtocolError: the controller said something unknown.
        JobCancelled: `cancelled` said so; the link is closed at once.
    """
    check_approval(plan, approval, cell, now())
    ready = messages(cell, plan)
    address = (cell.controller.host, cell.controller.port)
    try:
        link = socket.create_connection(address, CONNECT_SECONDS)
    except OSError as error:
        raise LinkError(
            f"no controller answers at {address[0]}:{address[1]} ({error.strerror or error})"
        ) from None
    with link:
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        requests = Requests()
        for number, message in enumerate(ready, start=1):
            where = f"message {number} of {len(ready)}"
            _await_request(link, requests, where, cancelled, answer_seconds)
            if number == 1:
                # The connection may have waited; the approval must hold when motion begins.
                check_approval(plan, approval, cell, now())
            try:
                link.sendall(message.text.encode("ascii"))
            except OSError as error:
                raise LinkError(f"the link broke at {where}: {error.strerror or error}") from None
            yield Receipt(now(), message.arm, message.kind, message.text, number, len(ready))
        _await_request(link, requests, "the end of the last motion", cancelled, answer_seconds)


def _await_request(
    link: socket.socket,
    requests: Requests,
    where: str,
    cancelled: Callable[[], bool],
    seconds: float,
) -> None:
    link.settimeout(POLL_SECONDS)
    until = time.monotonic() + seconds
    while True:
        if cancelled():
            raise JobCancelled(f"sending was stopped before {where}")
        try:
            data = link.recv(256)
        except TimeoutError:
            if time.monotonic() > until:
                raise LinkError(
                    f"the controller was silent for {seconds:.0f} s at {where}"
                ) from None
            continue
        except OSError as error:
            raise LinkError(f"the link broke at {where}: {error.strerror or error}") from None
        if not data:
            raise LinkError(f"the controller closed the link at {where}")
        if requests.hear(data):
            return


def watch_state(
    host: str, port: int, cancelled: Callable[[], bool] = lambda: False
) -> Iterator[ControllerState]:
    """The states that a controller reports, as they come: one JSON object a line.

    Raises:
        LinkError: nobody answers, or the report broke off.
        ProtocolError: a line is not a state.
    """
    try:
        link = socket.create_connection((host, port), CONNECT_SECONDS)
    except OSError as error:
        raise LinkError(
            f"no controller reports its state at {host}:{port} ({error.strerror or error})"
        ) from None
    with link:
        link.settimeout(POLL_SECONDS)
        heard = b""
        while not cancelled():
            try:
                data = link.recv(65536)
            except TimeoutError:
                continue
            except OSError as error:
                raise LinkError(f"the state report broke off: {error.strerror or error}") from None
            if not data:
                raise LinkError("the controller closed its state report")
            heard += data
            *lines, heard = heard.split(b"\n")
            if len(heard) > LONGEST_LINE:
                raise ProtocolError("a state report is too long")
            for line in lines:
                yield _state(line)


def _state(line: bytes) -> ControllerState:
    try:
        report: dict[str, Any] = json.loads(line)
        return ControllerState(
            joints={str(a): tuple(float(v) for v in q) for a, q in report["joints"].items()},
            openings={str(a): float(v) for a, v in report["openings"].items()},
            moving=str(report["moving"]),
            received=int(report["received"]),
            placed=int(report["placed"]),
            fault=str(report["fault"]),
        )
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise ProtocolError(f"{line[:60]!r} is no state report ({error})") from None
