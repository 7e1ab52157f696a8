"""The front: everything that browsers and programs reach, on one port, in a thread of its own."""

import asyncio
import concurrent.futures
import logging
import socket
import ssl
import threading
import time
from collections.abc import Iterable
from contextlib import ExitStack
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from aiohttp import web

from workbench.model.messages.message import Message
from workbench.plugins.addresses import is_loopback
from workbench.web.access.first_key import FirstKey
from workbench.web.access.guard import guard, strictly
from workbench.web.access.identity import ACCESS, Access, identify
from workbench.web.access.lockout import Lockout
from workbench.web.access.sessions import HOURS, Sessions
from workbench.web.access.store import Store
from workbench.web.access.users import Users
from workbench.web.http.broken_connections import is_broken_off
from workbench.web.http.connection_limits import ConnectionLimits, room_for
from workbench.web.http.gate import Gate, descriptors
from workbench.web.http.listening import TlsCertificate, listen
from workbench.web.http.origins import WILDCARDS, Origins
from workbench.web.http.sparing import sparing
from workbench.web.page.bar import Bar, Stopper, stop_nothing, without_robot
from workbench.web.page.connections import Connections
from workbench.web.page.languages import choice
from workbench.web.page.logins import Logins, read_form
from workbench.web.page.pages import Pages
from workbench.web.page.pieces import PATH
from workbench.web.page.presence import Presence
from workbench.web.page.relay import Relay, Upstream
from workbench.web.page.shell import Shell

log = logging.getLogger(__name__)

MOST_BODY = 1024 * 1024
"""Bytes of a request; who takes more reads it piece by piece."""

START_SECONDS = 30.0
END_SECONDS = 5.0

CLOSING_SECONDS = 2.0
"""[s] How long browsers have to close their connections when the front ends."""

Routes = Iterable[web.AbstractRouteDef]


@dataclass(frozen=True, slots=True)
class ServerOptions:
    """How the front is served.

    Attributes:
        host: address or name to listen on.
        port: 0 takes a free one.
        names: under which browsers may ask for it beside host, addresses and `localhost`.
        certificate: to serve over TLS with.
        hours: how long a login lasts.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    names: tuple[str, ...] = ()
    certificate: TlsCertificate | None = None
    hours: float = HOURS


class Front:
    """A front that serves.

    Lifetime: from `serve_front` until `close`.

    Concurrency: any thread; the front itself lives in one thread with one event loop.
    """

    def __init__(self, url: str, first: FirstKey, store: Store, running: "_Running"):
        """Made by `serve_front`."""
        self.url = url
        self._first = first
        self._store = store
        self._running = running

    @property
    def link(self) -> str:
        """Where to begin: with the key that lets one browser in, while there are no users."""
        key = self._first.key
        return f"{self.url}/first?key={key}" if key else self.url

    def close(self) -> None:
        """Cut off all browsers and stop listening; twice does no harm."""
        self._running.end()
        self._store.close()


def serve_front(
    upstream: Upstream,
    users: Path,
    options: ServerOptions,
    *,
    title: Message | str,
    routes: Routes = (),
    bar: Bar = without_robot,
    stop: Stopper = stop_nothing,
) -> Front:
    """Serve viser's page to those who have logged in.

    Returns when browsers can come.

    Args:
        upstream: the guarded viser.
        users: file of users; made when there is none.
        options: where and how.
        title: of the page.
        routes: more of them.  Who may use one is for its handler to say (`identity.identify`);
            that it comes from a page of ours, or shows a token, is checked before.
        bar: what the bar above the scene says of the robot.
        stop: what its button does.

    Raises:
        InputError: the address cannot be had.
        FileError: users, certificate or our own pages cannot be read.
    """
    tls = None if options.certificate is None else options.certificate.context()
    pages = Pages.read()
    with ExitStack() as undo:
        store = Store(users)
        undo.callback(store.close)
        bound = listen(options.host, options.port)
        undo.callback(bound.close)
        scheme, port = "http" if tls is None else "https", int(bound.getsockname()[1])
        access = Access(
            Users(store),
            Sessions(store, hours=options.hours),
            # Browsers do not tell ports apart; two workbenches on a machine are to.
            f"{'' if tls is None else '__Host-'}workbench-{port}",
        )
        first = FirstKey(access.users, from_anywhere=not is_loopback(options.host))
        connections = Connections(access.sessions)
        limits = ConnectionLimits(_is_login, time.monotonic, room_for(descriptors()))
        relay = Relay(upstream, connections)
        logins = Logins(pages, Lockout(store), first, connections, title, relay.ahead)
        presence = Presence(connections, bar, stop)
        app = web.Application(
            middlewares=[limits.note, guard(Origins(scheme, options.host, options.names))],
            client_max_size=MOST_BODY,
        )
        app[ACCESS] = access
        app.on_response_prepare.append(strictly)
        own = _own_routes(pages, logins, relay, Shell(pages, title), presence)
        app.add_routes([*own, *routes])
        running = _Running(app, bound, tls, relay, connections, limits)
        running.start()
        undo.pop_all()
    return Front(f"{scheme}://{_format_host(options.host)}:{port}", first, store, running)


def log_loop_problem(loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Log what nobody waited for: in full, except for connections that broke off.

    These end at any moment, in the libraries as well, and are no fault of anybody's here.
    """
    error = context.get("exception")
    if is_broken_off(error):
        log.debug("a connection broke off: %s", error)
    else:
        loop.default_exception_handler(context)


def _log_end(task: "asyncio.Task[None]") -> None:
    """Log why a task has ended that should last as long as the front."""
    if not task.cancelled() and (error := task.exception()) is not None:
        log.critical("a task of the front has ended: nobody new may come in", exc_info=error)


async def _is_login(request: web.Request) -> bool:
    """Whether a request comes from somebody."""
    return await identify(request) is not None


def _format_host(host: str) -> str:
    """A host as a link has it."""
    shown = "localhost" if host in WILDCARDS else host
    return f"[{shown}]" if ":" in shown else shown


def _own_routes(
    pages: Pages, logins: Logins, relay: Relay, shell: Shell, presence: Presence
) -> list[web.RouteDef]:
    return [
        web.get("/", shell.page),
        web.get("/who", shell.who),
        web.get("/healthz", shell.health),
        web.get("/login", logins.form),
        web.post("/login", logins.login),
        web.get("/first", logins.by_link),
        web.post("/logout", logins.logout),
        web.post("/language", choice(read_form)),
        web.get("/presence", presence.socket),
        web.get("/scene", relay.socket),
        web.get("/scene/", relay.page),
        web.get(f"{PATH}/{{name}}", relay.piece),
        web.get("/static/{name}", pages.file),
        web.get("/manual", pages.show_manual),
    ]


@dataclass(eq=False)
class _Running:
    """The thread with its event loop."""

    app: web.Application
    bound: socket.socket
    tls: ssl.SSLContext | None
    relay: Relay
    connections: Connections
    limits: ConnectionLimits
    started: "concurrent.futures.Future[None]" = field(default_factory=concurrent.futures.Future)
    loop: asyncio.AbstractEventLoop | None = None
    stop: asyncio.Event | None = None
    thread: threading.Thread | None = None

    def start(self) -> None:
        """Return when browsers can come; raises what went wrong."""
        self.thread = threading.Thread(
            target=lambda: asyncio.run(self._serve()), name="front", daemon=True
        )
        self.thread.start()
        self.started.result(START_SECONDS)

    def end(self) -> None:
        """Stop listening, and wait until all is closed."""
        if self.loop is None or self.stop is None or self.thread is None:
            return
        loop, self.loop = self.loop, None
        loop.call_soon_threadsafe(self.stop.set)
        self.thread.join(END_SECONDS)

    async def _serve(self) -> None:
        with sparing():
            await self._serve_until_stopped()

    async def _serve_until_stopped(self) -> None:
        self.loop, self.stop = asyncio.get_running_loop(), asyncio.Event()
        self.loop.set_exception_handler(log_loop_problem)
        # Requests go on when the browser goes: a password is being tried in a thread, and how
        # many of them there are is counted by their requests.
        runner = web.AppRunner(self.app, shutdown_timeout=CLOSING_SECONDS)
        tasks = [asyncio.create_task(self.connections.watch())]
        try:
            await self.relay.open()
            await runner.setup()
            assert runner.server is not None
            gate = Gate(self.bound, self.tls, self.limits, runner.server)
            tasks.append(asyncio.create_task(gate.serve()))
            for task in tasks:
                task.add_done_callback(_log_end)
            self.started.set_result(None)
            await self.stop.wait()
        except Exception as error:
            # A rim: whoever waits for the start, in another thread, is to know.
            self.started.set_exception(error)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            self.bound.close()
            self.connections.close()
            await runner.cleanup()
            await self.relay.close()
