"""Jobs and state for small PLCs, over Modbus TCP; off unless asked for.

The library, pymodbus, is optional and comes with the extra `modbus`; it reads requests and writes
answers.  Modbus has no logins: only stated addresses may connect, and they act as an operator who
approves nothing.
"""

import asyncio
import contextlib
import ipaddress
import logging
import struct
import threading
from collections.abc import Coroutine, Sequence
from dataclasses import dataclass, field
from typing import Any

from pymodbus.constants import ExcCodes
from pymodbus.pdu import DecodePDU, ExceptionResponse, ModbusPDU

from workbench.app.runtime.bench import Bench
from workbench.extras.modbus.jobs import Jobs
from workbench.extras.modbus.registers import SIZE, WRITTEN, Register, values_of
from workbench.model.errors import InputError

log = logging.getLogger(__name__)

MOST_CLIENTS = 8
"""Largest number of connections; a PLC has one."""

SILENCE = 60.0
"""[s] A connection without a request for longer is closed."""

FRAME = 5.0
"""[s] Longest time for the rest of a request, and for the client to take the answer."""

PAUSE = 0.005
"""[s] Pause after each answer, so that no client keeps the process busy."""

FUNCTIONS = (3, 6, 16, 23)
"""Read registers, write one, write several, write and read."""

HEADER = struct.Struct(">HHHB")
"""Transaction, protocol, length of what follows, unit (MODBUS Messaging on TCP/IP, 3.1.3)."""

LONGEST_FRAME = 254
"""[bytes] Largest length in a header."""

STARTING = 60.0
"""[s] Longest time for the start and for the end of the server."""

Address = ipaddress.IPv4Address | ipaddress.IPv6Address


@dataclass(frozen=True, slots=True)
class ModbusOptions:
    """Where to listen, and the client addresses; empty: only this machine may connect."""

    port: int
    host: str = "127.0.0.1"
    clients: tuple[str, ...] = ()


@dataclass(eq=False, slots=True)
class Exchange:
    """One connection: the registers that it has written, and the registers that it reads.

    `heard`: whether it has sent a request, and the time of the last one [s].
    """

    bench: Bench
    jobs: Jobs
    transport: asyncio.WriteTransport
    heard: tuple[bool, float]
    words: list[int] = field(default_factory=lambda: [0] * WRITTEN)

    async def async_getValues(
        self, unit: int, function: int, address: int, count: int
    ) -> list[int] | ExcCodes:
        """The values of registers."""
        if address + count > SIZE:
            return ExcCodes.ILLEGAL_ADDRESS
        values = values_of(self.bench.state, self.bench.live) | self.jobs.values()
        row = [*self.words, *(values.get(k, 0) for k in range(WRITTEN, SIZE))]
        return row[address : address + count]

    async def async_setValues(
        self, unit: int, function: int, address: int, values: Sequence[int]
    ) -> ExcCodes | None:
        """Write registers; the one with the counter starts the command."""
        end = address + len(values)
        if end > WRITTEN:
            return ExcCodes.ILLEGAL_ADDRESS
        words = [*self.words[:address], *values, *self.words[end:]]
        is_command = address <= Register.COUNTER < end
        before, self.words = self.words, words
        if is_command and not await asyncio.to_thread(self.jobs.give, words):
            self.words = before if self.words is words else self.words
            return ExcCodes.ILLEGAL_VALUE
        return None


class ModbusServer:
    """A server for a bench.

    Lifetime: from construction, which returns when clients can connect, until `close`.

    Concurrency: the server has a thread with an event loop; other threads carry out commands.
    """

    def __init__(self, bench: Bench, options: ModbusOptions):
        """Listen.

        Raises:
            InputError: the address is not available, or no client address is stated.
        """
        self._clients = _check(options)
        self._bench, self._decoder = bench, DecodePDU(True)
        self._here: dict[Exchange, asyncio.Task[Any] | None] = {}
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="modbus", daemon=True)
        self._thread.start()
        self._jobs = Jobs(bench)
        try:
            self._server = self._wait(asyncio.start_server(self._serve, options.host, options.port))
        except OSError as error:
            self._end()
            raise InputError(
                f"Modbus cannot be served on {options.host} port {options.port}: "
                f"{error.strerror or error}; choose another port"
            ) from error

    @property
    def address(self) -> tuple[str, int]:
        """The address and the port of the server."""
        return self._server.sockets[0].getsockname()[:2]

    def close(self) -> None:
        """Close all connections and stop listening."""
        self._wait(self._stop())
        self._end()

    def _wait(self, work: Coroutine[Any, Any, Any]) -> Any:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(STARTING)

    async def _stop(self) -> None:
        self._server.close()
        tasks = [task for task in self._here.values() if task is not None]
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        await self._loop.shutdown_default_executor()

    def _end(self) -> None:
        self._jobs.close()
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    async def _serve(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        """Serve one connection until its end; a client that sends no Modbus is disconnected."""
        peer = writer.get_extra_info("peername")
        if not peer or not self._is_stated(_address(peer[0])):
            # The client has gone, or may not connect.
            log.warning("refused a connection over Modbus from %s: not stated", peer)
            writer.transport.abort()
            return
        if len(self._here) >= MOST_CLIENTS:
            silent = min(self._here, key=lambda known: known.heard)
            log.warning("cut off a connection over Modbus: too many, and it is silent longest")
            silent.transport.abort()
            del self._here[silent]
        exchange = Exchange(self._bench, self._jobs, writer.transport, (False, self._loop.time()))
        self._here[exchange] = asyncio.current_task()
        try:
            with contextlib.suppress(TimeoutError, EOFError, ConnectionError):
                while await self._answer(exchange, reader, writer):
                    await asyncio.sleep(PAUSE)
        finally:
            self._here.pop(exchange, None)
            writer.transport.abort()

    def _is_stated(self, address: Address) -> bool:
        return address in self._clients if self._clients else address.is_loopback

    async def _answer(
        self, exchange: Exchange, reader: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> bool:
        """Answer one request; False: the bytes are no Modbus."""
        async with asyncio.timeout(SILENCE):
            header = await reader.readexactly(HEADER.size)
        transaction, protocol, length, unit = HEADER.unpack(header)
        if protocol or not 2 <= length <= LONGEST_FRAME:
            log.warning("cut off a connection over Modbus: what it sends is no Modbus")
            return False
        async with asyncio.timeout(FRAME):
            body = await reader.readexactly(length - 1)
        exchange.heard = (True, self._loop.time())
        answer = await self._response(exchange, body, unit)
        said = bytes([answer.function_code]) + answer.encode()
        writer.write(HEADER.pack(transaction, 0, len(said) + 1, unit) + said)
        async with asyncio.timeout(FRAME):
            await writer.drain()
        return True

    async def _response(self, exchange: Exchange, body: bytes, unit: int) -> ModbusPDU:
        function = body[0]
        if function not in FUNCTIONS:
            return ExceptionResponse(function & 0x7F, ExcCodes.ILLEGAL_FUNCTION)
        request = self._decoder.decode(body)
        if request is None:
            return ExceptionResponse(function, ExcCodes.ILLEGAL_VALUE)
        context: Any = exchange  # it has the two methods that the library calls
        return await request.datastore_update(context, unit)


def _address(text: str) -> Address:
    """An address without its zone; the IPv4 address if it is a mapped one."""
    found = ipaddress.ip_address(text.partition("%")[0])
    return (isinstance(found, ipaddress.IPv6Address) and found.ipv4_mapped) or found


def _check(options: ModbusOptions) -> frozenset[Address]:
    """The client addresses; empty: only this machine may connect.

    Raises:
        InputError: the host or a client is no address, or no client is stated for another host.
    """
    try:
        host = _address(options.host)
        clients = frozenset(map(_address, options.clients))
    except ValueError as error:
        raise InputError(f"Modbus takes addresses, no names: {error}") from error
    if host.is_unspecified:
        raise InputError(
            f"Modbus has no logins: state one address of this machine, not {options.host}"
        )
    if not clients and not host.is_loopback:
        raise InputError(
            f"Modbus on {options.host} could be used by anybody: state who may connect, or listen "
            "on 127.0.0.1"
        )
    return clients
