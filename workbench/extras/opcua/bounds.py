"""What a client may send at most, and who may open a channel at all.

The library keeps whatever a header announces, opens channels for any certificate, and goes on with
a connection whose messages are wrong.
"""

import logging
from collections.abc import Sequence
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any

from asyncua import ua
from asyncua.common.connection import TransportLimits
from asyncua.common.utils import Buffer
from asyncua.server import server
from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol
from asyncua.server.server import Server
from asyncua.ua.status_codes import StatusCodes
from asyncua.ua.ua_binary import uatcp_to_binary

log = logging.getLogger(__name__)

CHUNK = 64 * 1024 - 1
MOST_CHUNKS = 8
LIMITS = TransportLimits(CHUNK, CHUNK, MOST_CHUNKS, MOST_CHUNKS * CHUNK)
"""What is called or read here has a few hundred bytes."""


@dataclass(frozen=True, slots=True)
class Caller:
    """Whose message is worked on: the address, and how the channel is protected."""

    address: str
    mode: ua.MessageSecurityMode


CALLER: ContextVar[Caller] = ContextVar("opcua_caller")
"""Set in the task of a connection for each message."""


class _Connection(OPCUAProtocol):
    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        # What is left is the beginning of a chunk, of which a header says how long it will be.
        if len(self._buffer) > CHUNK and self.transport is not None:
            log.warning("cut off %s over OPC UA: its message is too long", self.peer_name)
            self._buffer = b""
            self.transport.close()

    async def _process_one_msg(self, header: Any, buf: Buffer) -> bool:
        if self.processor is None:
            return False
        # The library has no other way to ask it.
        policy = self.processor._connection.security_policy  # pyright: ignore[reportPrivateUsage]
        address = str((self.peer_name or ("",))[0])
        CALLER.set(Caller(address, ua.MessageSecurityMode(policy.Mode)))
        try:
            return await super()._process_one_msg(header, buf)
        except Exception as error:
            # After a message that cannot be trusted a channel is closed (OPC 10000-6, 6.7).
            problem = str(error) or type(error).__name__
            log.warning("cut off %s over OPC UA: %s", self.peer_name, problem)
            if self.transport is not None:
                status = ua.StatusCode(ua.UInt32(StatusCodes.BadSecurityChecksFailed))
                said = ua.ErrorMessage(status, ua.String(""))
                error_kind: Any = ua.MessageType.Error  # bytes, whatever the library's hint says
                self.transport.write(uatcp_to_binary(error_kind, said))
                self.transport.close()
            return False


class _Checked:
    """A policy that makes a channel only for clients that `door` lets in."""

    def __init__(self, policy: Any, door: Any) -> None:
        self._policy, self._door = policy, door

    def matches(self, uri: str, mode: Any = None) -> bool:
        return self._policy.matches(uri, mode)

    def create(self, peer_certificate: bytes | None) -> Any:
        if self._policy.mode != ua.MessageSecurityMode.None_:
            problem = self._door.problem(peer_certificate)
            if problem:
                raise ua.UaError(problem)
        return self._policy.create(peer_certificate)


class _Listener(BinaryServer):
    def set_policies(self, policies: Sequence[Any]) -> None:
        door = self.iserver.user_manager
        # Servers of others in this process have a door of the library.
        checked = hasattr(door, "problem")
        super().set_policies([_Checked(policy, door) if checked else policy for policy in policies])

    def _make_protocol(self) -> OPCUAProtocol:
        return _Connection(
            iserver=self.iserver,
            policies=self._policies,
            clients=self.clients,
            closing_tasks=self.closing_tasks,
            limits=self.limits,
        )


def limit_messages() -> None:
    """From now on servers of this process cut off whoever sends more."""
    # The library names its class where it starts and takes no other.
    server.BinaryServer = _Listener  # pyright: ignore[reportPrivateImportUsage]


def is_bound(started: Server) -> bool:
    """Whether a server that has started does so."""
    return isinstance(started.bserver, _Listener)
