"""Our end of the robot link: an approved plan goes out, message by message, or nothing does."""

import socket
from collections.abc import Callable, Iterator
from contextlib import suppress

from workbench.devices.abb_socket.connecting import connect
from workbench.devices.abb_socket.messages import Requests, messages
from workbench.devices.abb_socket.program import program_of
from workbench.devices.abb_socket.sending import SocketSending
from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled, LinkError, WorkbenchError
from workbench.model.messages.devices import DeviceText
from workbench.model.messages.message import Message
from workbench.model.messages.work import StopText
from workbench.model.plan import Plan
from workbench.model.release import Approval, LinkStatus, Receipt
from workbench.plugins.progress import Cancelled
from workbench.plugins.robot_link import LinkPatience, check_approval, none_let

MOST_HEARD = 65536
"""Bytes taken at once: many times what a controller says within the longest silence."""


def send_program(
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
    """Send a plan by `abb-socket/2`, which loads it as a program and then runs it.

    One receipt for each message that went out, and for each that says something new.  Nothing is
    sent twice: after any error the link is closed, and what was sent stands in the receipts.  The
    iterator ends when the controller has reported the end of the last motion.

    Arguments and errors are those of `plugins.robot_link.SteppedLink.send`; in addition:

    Raises:
        ProtocolError: the controller said or does something that cannot be.
    """

    def check() -> None:
        check_approval(plan, approval, cell, now())

    check()
    program = program_of(cell, plan, approval)
    talk = SocketSending(
        cell, plan, program, now=now, released=check, let=let, silence=patience.silence
    )
    with connect(cell.controller.host, cell.controller.port) as link:
        yield from _converse(link, talk, cancelled, show, patience)


def send_messages(
    plan: Plan,
    approval: Approval,
    cell: Cell,
    *,
    now: Callable[[], float],
    cancelled: Cancelled,
    show: Callable[[LinkStatus], None],
    patience: LinkPatience,
) -> Iterator[Receipt]:
    """Send a plan by `abb-socket`, message by message, each when the controller asks for it.

    As `send_program`; the iterator ends when the controller has asked once more.
    """
    check_approval(plan, approval, cell, now())
    ready = messages(cell, plan)
    with connect(cell.controller.host, cell.controller.port) as link:
        requests, total = Requests(), len(ready)
        for number, message in enumerate(ready, start=1):
            where = DeviceText.MESSAGE(number=number, total=total)
            _await_request(link, requests, where, cancelled, patience)
            if number == 1:
                # The connection may have waited; the approval must hold when motion begins.
                check_approval(plan, approval, cell, now())
            show(LinkStatus("abb-socket", "sending", number, total, "send", now(), now()))
            _say(link, message.text.encode("ascii"), where)
            yield Receipt(now(), message.arm, message.kind, message.text, number, total)
        _await_request(link, requests, DeviceText.LAST_MOTION(), cancelled, patience)
        show(LinkStatus("abb-socket", "done", total, total, "send", now(), now()))


def _converse(
    link: socket.socket,
    talk: SocketSending,
    cancelled: Cancelled,
    show: Callable[[LinkStatus], None],
    patience: LinkPatience,
) -> Iterator[Receipt]:
    """Send and receive until the end; in all other cases, command the robot to stop."""
    clock = patience.clock
    try:
        while not talk.is_over:
            if cancelled():
                yield from _stop(link, talk, show, patience)
            if data := talk.say(clock()):
                _say(link, data, talk.where)
            before, began = talk.status, clock()
            data = _receive(link, talk)
            # How long the receipts are worked on is not the controller's silence, nor is how long
            # this process stood still: what has come meanwhile is heard first.
            yield from talk.hear(data, clock())
            talk.check(began)
            if talk.status is not before:
                show(talk.status)
    except WorkbenchError:
        yield from talk.open_receipts()
        raise
    finally:
        if talk.is_begun and not talk.is_over and not talk.has_stopped:
            # The controller stops by itself when the link ends; this is quicker.
            with suppress(OSError):
                link.sendall(talk.abort(clock()))


def _stop(
    link: socket.socket,
    talk: SocketSending,
    show: Callable[[LinkStatus], None],
    patience: LinkPatience,
) -> Iterator[Receipt]:
    """Ask the controller to stop, and wait for its word.

    Raises:
        JobCancelled: always; it states what came of it.
    """
    if not talk.is_begun:
        raise JobCancelled(StopText.NOT_SPOKEN())
    yield from talk.open_receipts()
    missing = StopText.NOT_ACKNOWLEDGED()
    try:
        _say(link, talk.abort(patience.clock()), talk.where)
        until = patience.clock() + patience.stop
        while not talk.has_stopped and patience.clock() < until:
            yield from talk.hear(_receive(link, talk), patience.clock())
    except LinkError as error:
        why = StopText.SINCE(what=missing, why=error.message)
        raise JobCancelled(StopText.AT(where=talk.where, how=why)) from None
    show(talk.status)
    raise JobCancelled(StopText.AT(where=talk.where, how=talk.status.stop or missing))


def _receive(link: socket.socket, talk: SocketSending) -> bytes:
    """All that has arrived; nothing when nothing does within a moment."""
    try:
        data = link.recv(MOST_HEARD)
    except TimeoutError:
        return b""
    except OSError as error:
        raise LinkError(_broken(talk.where, error)) from None
    if not data:
        closed = DeviceText.CLOSED if talk.status.version else DeviceText.CLOSED_OLD
        raise LinkError(closed(where=talk.where))
    return data


def _say(link: socket.socket, data: bytes, where: Message) -> None:
    try:
        link.sendall(data)
    except OSError as error:
        raise LinkError(_broken(where, error)) from None


def _broken(where: Message, error: OSError) -> Message:
    return DeviceText.BROKEN(where=where, reason=error.strerror or str(error))


def _await_request(
    link: socket.socket,
    requests: Requests,
    where: Message,
    cancelled: Cancelled,
    patience: LinkPatience,
) -> None:
    until = patience.clock() + patience.answer
    while True:
        if cancelled():
            raise JobCancelled(StopText.BEFORE(where=where))
        try:
            data = link.recv(256)
        except TimeoutError:
            if patience.clock() > until:
                silent = DeviceText.SILENT(seconds=patience.answer, where=where)
                raise LinkError(silent) from None
            continue
        except OSError as error:
            raise LinkError(_broken(where, error)) from None
        if not data:
            raise LinkError(DeviceText.CLOSED(where=where))
        if requests.hear(data):
            return
