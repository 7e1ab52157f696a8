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


def untouched(k, data):
    return [data]


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


@contextmanager
def between_streams(
    host: str,
    ports: Sequence[int],
    to: Sequence[tuple[str, int]],
    heard: Spoil = untouched,
    said: Spoil = untouched,
):
    """Listen at `host` on ports (0: a free one) and forward each connection to where `to` says.

    `heard` changes what the controller says, `said` what is said to it; both get the place of the
    port in `ports`.  What comes is given to them as it is received, in any pieces.  Gives the
    ports, and a function that ends all connections.
    """
    listeners = [socket.create_server((host, port)) for port in ports]
    over, cut, threads, open_ones = threading.Event(), threading.Event(), [], []

    def pump(k, source, target, spoil):
        source.settimeout(POLL)
        with suppress(OSError):
            while not over.is_set() and not cut.is_set():
                try:
                    data = source.recv(1 << 16)
                except TimeoutError:
                    continue
                if not data:
                    break
                for each in spoil(k, data):
                    target.sendall(each)
        for one in (source, target):
            with suppress(OSError):
                one.shutdown(socket.SHUT_RDWR)

    def accept(k, listener):
        listener.settimeout(POLL)
        while not over.is_set():
            try:
                ours, _ = listener.accept()
            except TimeoutError:
                continue
            try:
                theirs = socket.create_connection(to[k], PATIENCE)
            except OSError:
                ours.close()
                continue
            open_ones.extend((ours, theirs))
            for one in (ours, theirs):
                one.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            begin(pump, k, theirs, ours, heard)
            begin(pump, k, ours, theirs, said)

    def begin(*call):
        threads.append(threading.Thread(target=call[0], args=call[1:], daemon=True))
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
