"""What the listening socket hands on to every connection that comes in by it."""

import socket

from workbench.web.http.listening import MOST_UNSENT, listen


def test_little_waits_in_the_machine_for_a_slow_line():
    with listen("127.0.0.1", 0) as bound, socket.create_connection(bound.getsockname()):
        taken, _ = bound.accept()
        with taken:
            told = taken.getsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT)
            assert told == MOST_UNSENT
