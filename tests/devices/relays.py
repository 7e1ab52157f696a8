"""Somebody between the workbench and a controller, on real sockets, who changes what is said."""

import select
import socket
import threading
from collections.abc import Callable, Sequence
from contextlib import contextmanager, suppress

from waiting import PATIENCE

Spoil = Callable[[int, bytes], Sequence[bytes]]
"""What becomes of a message: by which channel it came, and its bytes; usually itself alone."""

POLL = 0.02


def _socket(port=0):
    one = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    one.bind(("127.0.0.1", port))
    return one


@contextmanager
def between_datagrams(there: int, here: int, count: int, spoil: Spoil):
    """Forward UDP from ports `there`, `there` + 1... to `here`, ..., and the answers back.

    `spoil` changes what a controller sends there.
    """
    ins = [_socket(there + k) for k in range(count)]
    outs = [_socket() for _ in range(count)]
    over, senders = threading.Event(), [None] * count

    def run():
        while not over.is_set():
            for one in select.select([*ins, *outs], [], [], POLL)[0]:
                data, sender = one.recvfrom(1 << 16)
                if one in ins:
                    k = ins.index(one)
                    senders[k] = sender
                    for each in spoil(k, data):
                        outs[k].sendto(each, ("127.0.0.1", here + k))
                elif senders[k := outs.index(one)] is not None:
                    ins[k].sendto(data, senders[k])

    thread = threading.Thread(target=run)
    thread.start()
    try:
        yield outs
    finally:
        over.set()
        thread.join(PATIENCE)
        for one in (*ins, *outs):
            one.close()
        assert not thread.is_alive()


def as_it_is():
    """A connection of which nothing is changed: what the controller says, what is said to it."""
    return (lambda data: [data]), (lambda data: [data])


@contextmanager
def between_streams(
    host: str,
    to: Sequence[tuple[str, int]],
    ports: Sequence[int] | None = None,
    made: Callable[[int], tuple[Callable, Callable]] = lambda k: as_it_is(),
):
    """Listen at `host` on ports (0, and by default: free ones) and forward each connection to `to`.

    `made(k)` is called for each connection to the `k`-th port, and gives what becomes of the bytes
    of the controller, and of those that are said to it; they come as they are received, in any
    pieces.  Gives the ports, and an event that ends all connections.
    """
    listeners = [socket.create_server((host, port)) for port in ports or [0] * len(to)]
    over, cut, threads, open_ones = threading.Event(), threading.Event(), [], []

    def pump(source, target, spoil):
        with suppress(OSError):
            while not over.is_set() and not cut.is_set():
                if not select.select([source], [], [], POLL)[0]:
                    continue
                data = source.recv(1 << 16)
                if not data:
                    break
                for each in spoil(data):
                    target.sendall(each)
        for one in (source, target):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def accept(k, listener):
        while not over.is_set():
            if not select.select([listener], [], [], POLL)[0]:
                continue
            ours, _ = listener.accept()
            try:
                theirs = socket.create_connection(to[k], PATIENCE)
            except OSError:
                ours.close()
                continue
            open_ones.extend((ours, theirs))
            for one in (ours, theirs):
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            heard, said = made(k)
            begin(pump, theirs, ours, heard)
            begin(pump, ours, theirs, said)

    def begin(*call):
        threads.append(threading.Thread(target=call[0], args=call[1:]))
        threads[-1].start()

    for k, listener in enumerate(listeners):
        begin(accept, k, listener)
    try:
        yield [one.getsockname()[1] for one in listeners], cut
    finally:
        over.set()
        for thread in list(threads):
            thread.join(PATIENCE)
        for one in (*listeners, *open_ones):
            one.close()
