"""The state and a few commands for a PLC, over OPC UA (IEC 62541); off unless asked for.

The library, asyncua, is optional and comes with the extra `opcua`.  Whoever calls a method acts as
one named operator, under the same rules as everybody: a plan that no person has approved is not
sent.
"""

import asyncio
import contextlib
import hmac
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

from asyncua import ua
from asyncua.common.node import Node
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.server import Server
from asyncua.server.user_managers import UserManager
from asyncua.ua.status_codes import StatusCodes

from workbench.app.core.people import Person
from workbench.app.runtime.bench import Bench
from workbench.model.errors import InputError, WorkbenchError
from workbench.web.access.lockout import MOST, WHILE
from workbench.web.http.origins import is_loopback
from workbench.web.opcua.bounds import LIMITS, bound, is_bound
from workbench.web.opcua.methods import METHODS, Method
from workbench.web.opcua.values import VARIABLES, values_of

log = logging.getLogger(__name__)

NAMESPACE = "urn:workbench:cell"
PROGRESS = 0.5
"""[s] Between two looks at a running task."""

STARTING = 60.0
"""[s] After which a server that has not begun does not begin any more."""

MOST_CLIENTS = 32
"""Connections at the same time; a PLC has one."""

LOGIN_SECONDS = 10.0
"""After which a connection is dropped that has not logged in."""


@dataclass(frozen=True, slots=True)
class Options:
    """Where to listen, and who calls; without a `password` only this machine may."""

    port: int
    operator: Person
    host: str = "127.0.0.1"
    password: str = ""


class OpcUa:
    """A server beside a bench.

    Lifetime: from construction, which returns when clients can come, until `close`.

    Concurrency: an event loop in a thread of its own; commands are given from other threads.
    """

    def __init__(self, bench: Bench, options: Options):
        """Listen.

        Args:
            bench: whose state is told, and which takes the commands.
            options: where, and who calls.

        Raises:
            InputError: the address cannot be had, or others could call without a password.
        """
        _check(options)
        self._bench, self._options = bench, options
        self._nodes: dict[str, Node] = {}
        self._told: dict[str, Any] = {}
        self._loop = asyncio.new_event_loop()
        self._changed = asyncio.Event()
        self._thread = threading.Thread(target=self._loop.run_forever, name="opcua", daemon=True)
        self._thread.start()
        self._closed = False
        try:
            self._server, self._teller = self._wait(self._begin())
        except OSError as error:
            self._end_loop()
            raise InputError(
                f"OPC UA cannot be served on {options.host} port {options.port}: "
                f"{error.strerror or error}; choose another port"
            ) from error
        self._unsubscribe = bench.subscribe(lambda old, new: self._wake())
        # The state may have changed since it was first told.
        self._wake()

    def close(self) -> None:
        """Cut clients off and stop listening; twice does no harm."""
        if self._closed:
            return
        self._closed = True
        self._unsubscribe()
        self._wait(self._end())
        self._end_loop()

    def _wait(self, work: Any) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(STARTING)

    def _wake(self) -> None:
        # The loop may have ended in between: then there is nobody left to tell.
        with contextlib.suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._changed.set)

    def _end_loop(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    async def _begin(self) -> tuple[Server, asyncio.Task[None]]:
        options = self._options
        bound()
        server = Server(user_manager=_Door(options))
        server.limits = LIMITS
        await server.init()
        server.iserver.max_connections = MOST_CLIENTS
        server.iserver.max_pending_activation_seconds = LOGIN_SECONDS
        server.set_endpoint(f"opc.tcp://{options.host}:{options.port}/workbench")
        server.set_server_name("Workbench")
        server.set_security_policy([ua.SecurityPolicyType.NoSecurity])
        space = await server.register_namespace(NAMESPACE)
        cell = await server.nodes.objects.add_object(space, "Workbench")
        for name, kind in VARIABLES.items():
            first = ua.Variant(_nothing(kind), kind)
            self._nodes[name] = await cell.add_variable(space, name, first)
        for method in METHODS:
            await cell.add_method(
                space,
                method.name,
                partial(self._called, method),
                [argument.described() for argument in method.arguments],
                [ua.VariantType.Boolean, ua.VariantType.String],
            )
        await self._tell()
        await server.start()
        if not is_bound(server):
            raise InputError("this version of asyncua cannot be kept from keeping what is sent")
        return server, asyncio.create_task(self._go_on_telling())

    async def _end(self) -> None:
        self._teller.cancel()
        await asyncio.gather(self._teller, return_exceptions=True)
        await self._server.stop()

    async def _called(self, method: Method, parent: Any, *variants: Any) -> Any:
        """Give the command of a method; whether it was carried out, and what is said to it."""
        del parent
        if len(variants) < len(method.arguments):
            return ua.StatusCode(ua.UInt32(StatusCodes.BadArgumentsMissing))
        if len(variants) > len(method.arguments):
            return ua.StatusCode(ua.UInt32(StatusCodes.BadTooManyArguments))
        operator = self._options.operator
        try:
            command = method.make([variant.Value for variant in variants])
            state = await asyncio.to_thread(self._bench.do, command, operator.name, operator.role)
        except WorkbenchError as error:
            done, says = False, str(error)
        except Exception as error:
            # A rim: what goes wrong with one call ends no other.
            log.exception("the method %s failed", method.name)
            done, says = False, f"internal error, see the log: {type(error).__name__}"
        else:
            done, says = True, state.message
        return [
            ua.Variant(done, ua.VariantType.Boolean),
            ua.Variant(says, ua.VariantType.String),
        ]

    async def _go_on_telling(self) -> None:
        while True:
            with contextlib.suppress(TimeoutError):
                patience = PROGRESS if self._bench.state.job is not None else None
                await asyncio.wait_for(self._changed.wait(), patience)
            self._changed.clear()
            try:
                await self._tell()
            except ua.UaError:
                log.exception("the state cannot be told over OPC UA")

    async def _tell(self) -> None:
        """Write what has changed."""
        now: Mapping[str, Any] = values_of(self._bench.state, self._bench.live)
        for name, value in now.items():
            if name not in self._told or self._told[name] != value:
                await self._nodes[name].write_value(ua.Variant(value, VARIABLES[name]))
                self._told[name] = value


class _Door(UserManager):
    """Lets in whoever knows the password; everybody when there is none.

    After too many wrong ones nobody is let in for a while; who is in stays.
    """

    def __init__(self, options: Options, now: Callable[[], float] = time.monotonic):
        self._options, self._now = options, now
        self._failed: deque[float] = deque(maxlen=MOST)

    def get_user(
        self,
        iserver: Any,
        username: str | None = None,
        password: str | None = None,
        certificate: Any = None,
    ) -> User | None:
        del iserver, certificate
        name, wanted = self._options.operator.name, self._options.password
        if wanted and not (username and password):
            # Programs that look around come like this: it is no try.
            return None
        if len(self._failed) == MOST and self._now() - self._failed[0] < WHILE:
            return None
        is_right = hmac.compare_digest((password or "").encode(), wanted.encode())
        if not wanted or (username == name and is_right):
            return User(role=UserRole.User, name=name)
        self._failed.append(self._now())
        log.warning("refused a login over OPC UA as %r", username)
        if len(self._failed) == MOST and self._now() - self._failed[0] < WHILE:
            log.warning("for %g s nobody logs in over OPC UA: too many wrong passwords", WHILE)
        return None


def _check(options: Options) -> None:
    if not options.password and not is_loopback(options.host):
        raise InputError(
            f"OPC UA on {options.host} could be used by anybody: give a password, or listen on "
            "127.0.0.1"
        )


def _nothing(kind: ua.VariantType) -> Any:
    if kind is ua.VariantType.String:
        return ""
    return False if kind is ua.VariantType.Boolean else 0
