"""The state and a few commands for a PLC, over OPC UA (IEC 62541); off unless asked for.

The library, asyncua, is optional and comes with the extra `opcua`.  Whoever calls a method acts as
one named operator, under the same rules as everybody: a plan that no person has approved is not
sent.
"""

import asyncio
import contextlib
import logging
import socket
import threading
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from asyncua import ua
from asyncua.common.node import Node
from asyncua.server.server import Server
from asyncua.ua.status_codes import StatusCodes

from workbench.app.core.cycle.sending import Stop
from workbench.app.runtime.bench import Bench
from workbench.extras.opcua.admission import PERSON, Door, OpcUaOptions
from workbench.extras.opcua.bounds import LIMITS, is_bound, limit_messages
from workbench.extras.opcua.certificates import CERTIFICATE, KEY, application_uri, read_certificate
from workbench.extras.opcua.methods import METHODS, Method
from workbench.extras.opcua.robotics.space import standard_space
from workbench.extras.opcua.robotics.system import OWN, System
from workbench.extras.opcua.values import VARIABLES, values_of
from workbench.model.errors import FileError, InputError, WorkbenchError
from workbench.plugins.addresses import is_loopback

log = logging.getLogger(__name__)

NAMESPACE = "urn:workbench:cell"
PROGRESS = 0.5
"""[s] Between two looks at a running task, and at a robot that reports nothing."""

MOVING = 0.1
"""[s] Between two looks at a robot that reports where it stands."""

STARTING = 60.0
"""[s] After which a server that has not begun does not begin any more."""

MOST_CLIENTS = 32
"""Connections at the same time; a PLC has one."""

LOGIN_SECONDS = 10.0
"""After which a connection is dropped that has not logged in."""

SECURE = (
    ua.SecurityPolicyType.Basic256Sha256_Sign,
    ua.SecurityPolicyType.Basic256Sha256_SignAndEncrypt,
    ua.SecurityPolicyType.Aes128Sha256RsaOaep_Sign,
    ua.SecurityPolicyType.Aes128Sha256RsaOaep_SignAndEncrypt,
    ua.SecurityPolicyType.Aes256Sha256RsaPss_Sign,
    ua.SecurityPolicyType.Aes256Sha256RsaPss_SignAndEncrypt,
)
"""Policies with certificates; those before them count as broken (OPC 10000-7)."""


class OpcUa:
    """A server beside a bench.

    Lifetime: from construction, which returns when clients can come, until `close`.

    Concurrency: an event loop in a thread of its own, which never waits for the bench's disk.
    Commands are given from other threads; a stop has a thread of its own.
    """

    def __init__(self, bench: Bench, options: OpcUaOptions):
        """Listen.

        Args:
            bench: whose state is reported, and which takes the commands.
            options: where, and who calls.

        Raises:
            InputError: the address cannot be had, or others could call without a password.
        """
        _check(options)
        self._bench, self._options, self._door = bench, options, Door(options)
        self._nodes: dict[str, Node] = {}
        self._told: dict[str, Any] = {}
        self._loop = asyncio.new_event_loop()
        self._changed = asyncio.Event()
        self._stopping = ThreadPoolExecutor(1, thread_name_prefix="opcua stop")
        self._thread = threading.Thread(target=self._loop.run_forever, name="opcua", daemon=True)
        self._thread.start()
        self._closed = False
        try:
            self._server, self._teller = self._wait(self._begin())
        except WorkbenchError:
            self._end_loop()
            raise
        except OSError as error:
            self._end_loop()
            raise InputError(
                f"OPC UA cannot be served on {options.host} port {options.port}: "
                f"{error.strerror or error}; choose another port"
            ) from error
        self._unsubscribe = bench.subscribe(lambda old, new: self._wake())
        # The state may have changed since it was first told.
        self._wake()

    @property
    def url(self) -> str:
        """Where it is served, with the port that it has got."""
        port = self._server.bserver.port if self._server.bserver else self._options.port
        return f"opc.tcp://{self._options.host}:{port}/workbench"

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
        self._stopping.shutdown(wait=False)

    async def _begin(self) -> tuple[Server, asyncio.Task[None]]:
        options = self._options
        limit_messages()
        server = await _secure(options, self._door)
        server.iserver.max_connections = MOST_CLIENTS
        server.iserver.max_pending_activation_seconds = LOGIN_SECONDS
        server.set_endpoint(f"opc.tcp://{options.host}:{options.port}/workbench")
        server.set_server_name("Workbench")
        space = await server.register_namespace(NAMESPACE)
        self._system = System(await standard_space(server, {OWN: space}))
        cell = await server.nodes.objects.add_object(space, "Workbench")
        for name, kind in VARIABLES.items():
            first = ua.Variant(_nothing(kind), kind)
            self._nodes[name] = await cell.add_variable(space, name, first)
        for method in METHODS:
            await cell.add_method(
                space,
                method.name,
                partial(self._call, method),
                [argument.describe() for argument in method.arguments],
                [ua.VariantType.Boolean, ua.VariantType.String],
            )
        await self._write_changes()
        await server.start()
        if not is_bound(server):
            raise InputError("this version of asyncua cannot be kept from keeping what is sent")
        return server, asyncio.create_task(self._go_on_telling())

    async def _end(self) -> None:
        self._teller.cancel()
        await asyncio.gather(self._teller, return_exceptions=True)
        await self._server.stop()

    async def _call(self, method: Method, parent: Any, *variants: Any) -> Any:
        """Give the command of a method; whether it was carried out, and what is said to it."""
        if len(variants) < len(method.arguments):
            return ua.StatusCode(ua.UInt32(StatusCodes.BadArgumentsMissing))
        if len(variants) > len(method.arguments):
            return ua.StatusCode(ua.UInt32(StatusCodes.BadTooManyArguments))
        person = PERSON.get() or self._options.operator
        if not self._door.is_still_in(person):
            return ua.StatusCode(ua.UInt32(StatusCodes.BadUserAccessDenied))
        try:
            command = method.make(*(variant.Value for variant in variants))
            # None: the threads of all other commands.
            threads = self._stopping if isinstance(command, Stop) else None
            state = await self._loop.run_in_executor(
                threads, self._bench.do, command, person.name, person.role
            )
        except WorkbenchError as error:
            done, says = False, str(error)
        except Exception as error:
            # A rim: what goes wrong with one call ends no other.
            log.exception("the method %s failed", method.name)
            done, says = False, f"internal error, see the log: {type(error).__name__}"
        else:
            done, says = True, str(state.message)
        return [
            ua.Variant(done, ua.VariantType.Boolean),
            ua.Variant(says, ua.VariantType.String),
        ]

    async def _go_on_telling(self) -> None:
        logged = ""
        while True:
            with contextlib.suppress(TimeoutError):
                # Not `wait_for`, which forgets that it was cancelled when both happen at once.
                async with asyncio.timeout(MOVING if self._bench.live.joints else PROGRESS):
                    await self._changed.wait()
            self._changed.clear()
            try:
                await self._write_changes()
                logged = ""
            except Exception as error:
                # A rim: a PLC that reads old values for ever would take them for the state.
                if logged != repr(error):
                    log.exception("the state cannot be written over OPC UA")
                logged = repr(error)

    async def _write_changes(self) -> None:
        """Write what has changed."""
        now: Mapping[str, Any] = values_of(self._bench.state, self._bench.live, self._bench.head)
        for name, value in now.items():
            if name not in self._told or self._told[name] != value:
                await self._nodes[name].write_value(ua.Variant(value, VARIABLES[name]))
                self._told[name] = value
        await self._system.write_changes(self._bench.state, self._bench.live)


async def _secure(options: OpcUaOptions, door: Door) -> Server:
    """A server that offers the policies, with its certificate if there is one.

    Raises:
        FileError: certificate or key cannot be read.
    """
    server = Server(user_manager=door)
    server.limits = LIMITS
    policies = [ua.SecurityPolicyType.NoSecurity] if options.takes_plain else []
    uri = f"urn:{socket.gethostname()}:workbench"
    if options.certificates is not None:
        certificate = read_certificate(options.certificates / CERTIFICATE)
        uri = application_uri(certificate) or uri
        await server.load_certificate(options.certificates / CERTIFICATE)
        try:
            await server.load_private_key(options.certificates / KEY)
        except (OSError, ValueError, TypeError) as error:
            raise FileError(options.certificates / KEY, f"is no key: {error}") from error
        policies += SECURE
    await server.init()
    await server.set_application_uri(uri)
    server.set_security_policy(policies)
    server.set_identity_tokens([ua.AnonymousIdentityToken, ua.UserNameIdentityToken])
    return server


def _check(options: OpcUaOptions) -> None:
    is_guarded = bool(options.password) or not options.takes_plain
    if not is_guarded and not is_loopback(options.host):
        raise InputError(
            f"OPC UA on {options.host} could be used by anybody: give a password or make a "
            "certificate, or listen on 127.0.0.1"
        )


def _nothing(kind: ua.VariantType) -> Any:
    if kind is ua.VariantType.String:
        return ""
    return False if kind is ua.VariantType.Boolean else 0
