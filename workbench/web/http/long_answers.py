"""Long answers, sent in pieces; a client that does not read them is disconnected."""

import asyncio
import contextlib
from collections.abc import Iterable

from aiohttp import web

PIECE_SECONDS = 60.0
"""[s] Longest time for a client to take one piece of a long answer."""


async def send_pieces(
    request: web.Request, response: web.StreamResponse, pieces: Iterable[bytes]
) -> web.StreamResponse:
    """Send a long answer, whose headers state its length.

    A client that does not read would keep the answer in memory, or its file on the disk.
    """
    with contextlib.suppress(ConnectionResetError):
        await response.prepare(request)
        for piece in pieces:
            await write_within(PIECE_SECONDS, request, response, piece)
        await response.write_eof()
    return response


async def write_within(
    seconds: float, request: web.Request, response: web.StreamResponse, data: bytes
) -> None:
    """Write to a client that has `seconds` to read.

    Raises:
        ConnectionResetError: the client has gone, or does not read and is disconnected.
    """
    try:
        async with asyncio.timeout(seconds):
            await response.write(data)
    except TimeoutError:
        if request.transport is not None:
            request.transport.abort()
        raise ConnectionResetError("the client does not read") from None
