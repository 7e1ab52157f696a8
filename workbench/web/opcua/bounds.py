"""What a client may send at most: the library keeps whatever a header announces."""

import logging

from asyncua.common.connection import TransportLimits
from asyncua.server import server
from asyncua.server.binary_server_asyncio import BinaryServer, OPCUAProtocol
from asyncua.server.server import Server

log = logging.getLogger(__name__)

CHUNK = 64 * 1024 - 1
MOST_CHUNKS = 8
LIMITS = TransportLimits(CHUNK, CHUNK, MOST_CHUNKS, MOST_CHUNKS * CHUNK)
"""What is called or read here has a few hundred bytes."""


class _Connection(OPCUAProtocol):
    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        # What is left is the beginning of a chunk, of which a header says how long it will be.
        if len(self._buffer) > CHUNK and self.transport is not None:
            log.warning("cut off %s over OPC UA: its message is too long", self.peer_name)
            self._buffer = b""
            self.transport.close()


class _Listener(BinaryServer):
    def _make_protocol(self) -> OPCUAProtocol:
        return _Connection(
            iserver=self.iserver,
            policies=self._policies,
            clients=self.clients,
            closing_tasks=self.closing_tasks,
            limits=self.limits,
        )


def bound() -> None:
    """From now on servers of this process cut off whoever sends more."""
    # The library names its class where it starts and takes no other.
    server.BinaryServer = _Listener  # pyright: ignore[reportPrivateImportUsage]


def is_bound(started: Server) -> bool:
    """Whether a server that has started does so."""
    return isinstance(started.bserver, _Listener)
