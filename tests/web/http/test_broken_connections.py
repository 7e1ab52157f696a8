"""A connection that breaks off inside a library is no traceback in the log; all else is."""

import asyncio
import errno
import logging

import pytest

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
