"""The HTTP interface: the commands and values of the bench for programs.

Every request is somebody's, every command passes the same rules as one from the page, and every
refusal is a sentence with a status.  Who asks is for `identify` to say.
"""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from http import HTTPStatus
from typing import Any

from aiohttp import web

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.sending import Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import NOBODY, Person
from workbench.app.runtime.bench import Bench
from workbench.formats.files.json_pieces import encode_json
from workbench.model.errors import NotAllowed, WorkbenchError
from workbench.model.messages.refusals import Refusal
from workbench.web.api.calls import CALLS, Call
from workbench.web.api.events import HEARTBEAT, MOST_LISTENERS, Events
from workbench.web.api.fields import LARGEST_BODY, body_of
from workbench.web.api.openapi import PREFIX, openapi
from workbench.web.api.problems import problem, problem_of
from workbench.web.api.reference import reference_html
from workbench.web.api.resources import JSON, READS, AnswerSource, Read
from workbench.web.http.broken_connections import is_broken_off
from workbench.web.http.long_answers import send_pieces
from workbench.web.http.refusals import log_refusal

log = logging.getLogger(__name__)

Identify = Callable[[web.Request], Awaitable[Person | None]]
"""Who asks; None when nobody has logged in."""

POLICY = "default-src 'none'; style-src 'unsafe-inline'; frame-ancestors 'none'"
"""Of the page that describes the interface: it has a style and nothing else."""

UNREADABLE = "the body is not encoded as its head says"

BODY_SECONDS = 30.0
"""That a body may take to arrive.  aiohttp 3.14 waits for ever for the end of a deflate stream that
is cut off."""

NAMED = frozenset({Approve, WatchPlan})
"""What a person answers for: nothing that a login without a name could say."""

NO_STORE = {"Cache-Control": "no-store"}

CHUNK = 2**18
"""[bytes] Of a long answer that are sent at once."""

READERS = 3
"""This many answers are made at once: clouds take memory and time."""

COMMANDERS = 4
"""This many commands are checked at once."""

Answer = Callable[[web.Request, Person], Awaitable[web.StreamResponse]]


def api_routes(
    bench: Bench, identify: Identify, *, heartbeat: float = HEARTBEAT
) -> list[web.RouteDef]:
    """The routes of the interface, below `/api/v1`.

    The description of the interface is for everybody, everything else for who has logged in.

    Args:
        bench: whose state is reported, and which takes the commands.
        identify: says who asks.
        heartbeat: [s] after which an event stream shows that it lives.
    """
    api = Api(bench, identify, Events(bench, heartbeat=heartbeat))
    routes = [
        web.get(PREFIX + read.path, api.make_handler(partial(api.read, read))) for read in READS
    ]
    routes += [
        web.post(PREFIX + call.path, api.make_handler(partial(api.give, call))) for call in CALLS
    ]
    routes += [
        web.get(f"{PREFIX}/me", api.make_handler(api.me)),
        web.get(f"{PREFIX}/events", api.make_handler(api.listen)),
        web.get(f"{PREFIX}/openapi.json", _describe),
        web.get(f"{PREFIX}/", _reference),
    ]
    return routes


class Api:
    """Handlers of the interface.

    Lifetime: as long as its routes.

    Concurrency: the event loop; what takes time goes to threads.  A stop has a thread of its own,
    other commands have theirs: neither waits for readers, however many, nor for passwords that are
    being tried.
    """

    def __init__(self, bench: Bench, identify: Identify, events: Events):
        """Nothing is asked yet."""
        self._bench = bench
        self._identify = identify
        self._events = events
        self._source = AnswerSource(bench)
        self._stopping = ThreadPoolExecutor(1, thread_name_prefix="stop")
        self._giving = ThreadPoolExecutor(COMMANDERS, thread_name_prefix="commands")
        self._reading = ThreadPoolExecutor(READERS, thread_name_prefix="reads")

    def make_handler(
        self, answer: Answer
    ) -> Callable[[web.Request], Awaitable[web.StreamResponse]]:
        """A handler that answers people only, and errors with their sentences."""

        async def handler(request: web.Request) -> web.StreamResponse:
            person = await self._identify(request)
            if person is None:
                headers = {"WWW-Authenticate": "Bearer"}
                return problem(HTTPStatus.UNAUTHORIZED, "log in first", headers=headers)
            try:
                return await answer(request, person)
            except WorkbenchError as error:
                return problem_of(error)
            except web.RequestPayloadError as error:
                log_refusal("body", why=str(error), origin=request.remote, who=person.name)
                return problem(HTTPStatus.BAD_REQUEST, UNREADABLE)
            except web.HTTPException:
                raise
            except Exception as error:
                if is_broken_off(error):
                    raise
                # A rim: whatever goes wrong with one request is in the log, not in the answer.
                log.exception("%s %s failed", request.method, request.path)
                return problem(HTTPStatus.INTERNAL_SERVER_ERROR, "internal error, see the log")

        return handler

    async def read(self, read: Read, request: web.Request, person: Person) -> web.StreamResponse:
        """Answer with a value as it is now."""
        loop = asyncio.get_running_loop()
        content = await loop.run_in_executor(self._reading, self._make, read)
        if content is None:
            return problem(HTTPStatus.NOT_FOUND, f"it is not there yet: {read.missing}")
        if len(content) > CHUNK:
            return await _send(request, content, read.kind)
        return web.Response(body=content, content_type=read.kind, headers=NO_STORE)

    async def give(self, call: Call, request: web.Request, person: Person) -> web.Response:
        """Give a command in the name of who asks."""
        if person.name == NOBODY and call.kind in NAMED:
            raise NotAllowed(Refusal.NEEDS_NAME(command=call.kind.right.says()))
        content = await _body(request)
        if isinstance(content, web.Response):
            return content
        command = call.command(body_of(content, call.fields))
        threads = self._stopping if call.kind is Stop else self._giving
        state = await asyncio.get_running_loop().run_in_executor(
            threads, self._bench.do, command, person.name, person.role
        )
        done = {
            "number": state.number,
            "phase": str(state.phase),
            "message": str(state.message),
            "job": None if state.job is None else state.job.number,
        }
        status = HTTPStatus.ACCEPTED if call.begins else HTTPStatus.OK
        headers = {"Location": f"{PREFIX}/jobs/current"} if call.begins else {}
        return _json(done, status=status, headers=headers)

    async def me(self, request: web.Request, person: Person) -> web.Response:
        """Answer who asks."""
        may = [call.path for call in CALLS if person.role.covers(call.kind.right.role)]
        return _json({"name": person.name, "role": str(person.role), "may": may})

    async def listen(self, request: web.Request, person: Person) -> web.StreamResponse:
        """Tell every new state until the listener goes or is somebody else."""
        if self._events.is_full:
            said = f"{MOST_LISTENERS} streams are open already; close one first"
            return problem(HTTPStatus.SERVICE_UNAVAILABLE, said)

        async def is_still_allowed() -> bool:
            return await self._identify(request) == person

        return await self._events.stream(request, is_still_allowed)

    def _make(self, read: Read) -> bytes | None:
        value = read.answer(self._source)
        return value if value is None or isinstance(value, bytes) else encode_json(value)


async def _body(request: web.Request) -> bytes | web.Response:
    """The body, as long as it may be, or what is wrong with it."""
    too_long = f"a body may have {LARGEST_BODY} bytes"
    if request.content_length is not None and request.content_length > LARGEST_BODY:
        return problem(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, too_long)
    content = bytearray()
    try:
        async with asyncio.timeout(BODY_SECONDS):
            async for chunk in request.content.iter_any():
                content += chunk
                if len(content) > LARGEST_BODY:
                    return problem(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, too_long)
    except TimeoutError:
        said = f"the body did not arrive within {BODY_SECONDS:g} s"
        return problem(HTTPStatus.REQUEST_TIMEOUT, said)
    if content and request.content_type != JSON:
        said = f"the body must be {JSON}, not {request.content_type[:60]}"
        return problem(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, said)
    return bytes(content)


async def _send(request: web.Request, content: bytes, kind: str) -> web.StreamResponse:
    """A long answer, piece by piece: nothing else would be served while all of it is copied."""
    response = web.StreamResponse(headers=NO_STORE)
    response.content_type, response.content_length = kind, len(content)
    pieces = (content[begin : begin + CHUNK] for begin in range(0, len(content), CHUNK))
    return await send_pieces(request, response, pieces)


def _json(value: Any, **about: Any) -> web.Response:
    return web.Response(body=encode_json(value), content_type=JSON, **about)


async def _describe(request: web.Request) -> web.Response:
    return _json(openapi())


async def _reference(request: web.Request) -> web.Response:
    return web.Response(
        text=reference_html(openapi()),
        content_type="text/html",
        headers={"Content-Security-Policy": POLICY},
    )
