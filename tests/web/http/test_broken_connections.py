"""A connection that breaks off inside a library is no traceback in the log; all else is."""

import asyncio
import errno
import logging

import pytest
import requests
from waiting import PATIENCE

from workbench.web.http.connection_limits import ConnectionLimits
from workbench.web.server import log_loop_problem


@pytest.mark.parametrize(
    ("error", "is_told"),
    [
        (ConnectionResetError("Cannot write to closing transport"), False),
        (OSError(errno.ENOTCONN, "Transport endpoint is not connected"), False),
        (OSError(errno.ENOSPC, "No space left on device"), True),
        (ValueError("ours"), True),
    ],
)
def test_only_what_somebody_has_to_look_at_is_told(caplog, error, is_told):
    async def fail():
        loop = asyncio.get_running_loop()
        loop.set_exception_handler(log_loop_problem)

        def broken():
            raise error

        loop.call_soon(broken)
        await asyncio.sleep(0)
        await asyncio.sleep(0)

    with caplog.at_level(logging.WARNING):
        asyncio.run(fail())
    assert bool(caplog.records) == is_told
    assert not is_told or caplog.records[0].exc_info[1] is error


def test_the_front_tells_so(front):
    running = front._running
    assert running.loop.get_exception_handler() is log_loop_problem


def test_a_connection_that_cannot_be_taken_in_ends_no_other(front, monkeypatch):
    enter, failed = ConnectionLimits.enter, []

    def fail_once(limits, *about):
        if not failed:
            failed.append(about)
            raise ValueError("a peer without an address")
        return enter(limits, *about)

    monkeypatch.setattr(ConnectionLimits, "enter", fail_once)
    with pytest.raises(requests.ConnectionError):
        requests.get(f"{front.url}/healthz", timeout=PATIENCE)
    assert failed
    assert requests.get(f"{front.url}/healthz", timeout=PATIENCE).ok
