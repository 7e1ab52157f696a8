"""Our end of the robot link: an approved plan goes out, message by message, or nothing does."""

import socket
import time
from collections.abc import Callable, Iterator
from contextlib import suppress

from workbench.devices.abb_socket.connecting import connected
from workbench.devices.abb_socket.messages import Requests, messages
from workbench.devices.abb_socket.patience import USUAL, Patience
from workbench.devices.abb_socket.program import program_of
from workbench.devices.abb_socket.sending import Sending
from workbench.devices.abb_socket.status import LinkStatus
from workbench.model.cell import Cell
from workbench.model.errors import CommandRefused, JobCancelled, LinkError, WorkbenchError
from workbench.model.plan import Plan
from workbench.model.release import Approval, Receipt

MOST_HEARD = 65536
"""Bytes taken at once: many times what a controller says within the longest silence."""


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
    if now < approval.at:
        raise CommandRefused(
            f"the approval begins in {approval.at - now:.0f} s: a clock has been set back"
        )
    if not now <= approval.until:
        raise CommandRefused(f"the approval ran out {now - approval.until:.0f} s ago")


def send(
    plan: Plan,
    approval: Approval,
    cell: Cell,
    *,
    now: Callable[[], float] = time.time,
    cancelled: Callable[[], bool] = lambda: False,
    show: Callable[[LinkStatus], None] = lambda status: None,
    patience: Patience = USUAL,
) -> Iterator[Receipt]:
    """Send a plan to the controller of the cell, in the protocol of the cell.

    One receipt for each message that went out, and for each that says something new.  Nothing is
    sent twice: after any error the link is closed, and what was sent stands in the receipts.  The
    iterator ends when the controller has reported the end of the last motion, by asking once more
    (`abb-socket`) or in so many words (`abb-socket/2`).

    Args:
        plan: what is sent.
        approval: that lets it out.
        cell: as it is now.
        now: seconds since the epoch.
        cancelled: asked all the time; True stops the robot as far as the protocol can.
        show: takes how the link stands, when that changes.
        patience: how long the controller is waited for.

    Raises:
        CommandRefused: the approval is not for this, or has run out; nothing has moved.
        InputError: the plan cannot be said in this protocol; nothing was sent.
        LinkError: no connection, silence, a refusal, or the controller closed the link.
        ProtocolError: the controller said or does something that cannot be.
        JobCancelled: `cancelled` said so; the link is closed.
    """

    def check() -> None:
        check_approval(plan, approval, cell, now())

    check()
    controller = cell.controller
    if controller.protocol == "abb-socket/2":
        program = program_of(cell, plan, approval)
        silence = patience.silence
        talk = Sending(cell, plan, program, now=now, released=check, silence=silence)
        with connected(controller.host, controller.port, "answers") as link:
            yield from _converse(link, talk, cancelled, show, patience)
        return
    ready = messages(cell, plan)
    with connected(controller.host, controller.port, "answers") as link:
        requests, total = Requests(), len(ready)
        for number, message in enumerate(ready, start=1):
            _await_request(link, requests, f"message {number} of {total}", cancelled, patience)
            if number == 1:
                # The connection may have waited; the approval must hold when motion begins.
                check()
            show(LinkStatus("abb-socket", "sending", number, total, "send", now(), now()))
            _say(link, message.text.encode("ascii"), f"message {number} of {total}")
            yield Receipt(now(), message.arm, message.kind, message.text, number, total)
        _await_request(link, requests, "the end of the last motion", cancelled, patience)
        show(LinkStatus("abb-socket", "done", total, total, "send", now(), now()))


def _converse(
    link: socket.socket,
    talk: Sending,
    cancelled: Callable[[], bool],
    show: Callable[[LinkStatus], None],
    patience: Patience,
) -> Iterator[Receipt]:
    """Say and hear until the end; whatever else happens, the robot is told to stop."""
    clock = patience.clock
    try:
        while not talk.is_over:
            if cancelled():
                yield from _stop(link, talk, show, patience)
            if data := talk.say(clock()):
                _say(link, data, talk.where)
            before = talk.status
            data, at = _received(link, talk), clock()
            # How long the receipts are worked on is not the controller's silence.
            yield from talk.hear(data, at)
            talk.check(at)
            if talk.status is not before:
                show(talk.status)
    except WorkbenchError:
        yield from talk.unanswered()
        raise
    finally:
        if talk.is_begun and not talk.is_over and not talk.has_stopped:
            # The controller stops by itself when the link ends; this is quicker.
            with suppress(OSError):
                link.sendall(talk.abort(clock()))


def _stop(
    link: socket.socket, talk: Sending, show: Callable[[LinkStatus], None], patience: Patience
) -> Iterator[Receipt]:
    """Ask the controller to stop, and wait for its word.

    Raises:
        JobCancelled: always; it tells what came of it.
    """
    where = f"sending was stopped at {talk.where}"
    if not talk.is_begun:
        raise JobCancelled(f"{where}, before the controller was spoken to")
    yield from talk.unanswered()
    missing = "the controller did not acknowledge the stop: use the emergency stop"
    try:
        _say(link, talk.abort(patience.clock()), talk.where)
        until = patience.clock() + patience.stop
        while not talk.has_stopped and patience.clock() < until:
            yield from talk.hear(_received(link, talk), patience.clock())
    except LinkError as error:
        raise JobCancelled(f"{where}; {missing} ({error})") from None
    show(talk.status)
    raise JobCancelled(f"{where}; {talk.status.stop or missing}")


def _received(link: socket.socket, talk: Sending) -> bytes:
    """All that has arrived; nothing when nothing does within a moment."""
    try:
        data = link.recv(MOST_HEARD)
    except TimeoutError:
        return b""
    except OSError as error:
        raise LinkError(f"the link broke at {talk.where}: {error.strerror or error}") from None
    if not data:
        hint = "" if talk.status.version else "; perhaps it speaks abb-socket alone"
        raise LinkError(f"the controller closed the link at {talk.where}{hint}")
    return data


def _say(link: socket.socket, data: bytes, where: str) -> None:
    try:
        link.sendall(data)
    except OSError as error:
        raise LinkError(f"the link broke at {where}: {error.strerror or error}") from None


def _await_request(
    link: socket.socket,
    requests: Requests,
    where: str,
    cancelled: Callable[[], bool],
    patience: Patience,
) -> None:
    until = patience.clock() + patience.answer
    while True:
        if cancelled():
            raise JobCancelled(f"sending was stopped before {where}")
        try:
            data = link.recv(256)
        except TimeoutError:
            if patience.clock() > until:
                raise LinkError(
                    f"the controller was silent for {patience.answer:.0f} s at {where}"
                ) from None
            continue
        except OSError as error:
            raise LinkError(f"the link broke at {where}: {error.strerror or error}") from None
        if not data:
            raise LinkError(f"the controller closed the link at {where}")
        if requests.hear(data):
            return
