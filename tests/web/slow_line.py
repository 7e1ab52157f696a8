"""A slow network, of real TCP: packets wait, queue and get lost between two network namespaces.

The kernel's own emulation (netem) is not in every kernel.  So each of two namespaces gets a
network device whose packets a program sees (tun), and a process between them holds each packet
up, lets out no more than the line carries, and drops some.  Nothing here needs rights of the
machine's administrator: the namespaces lie in user namespaces of their own.

    server --(a socket that listens there)-- tun ~~ line ~~ tun -- forwarder -- browser

The forwarder takes what comes to an address of this machine and opens a connection of its own
through the line for each; what it reads it passes on at once.
"""

import asyncio
import contextlib
import fcntl
import heapq
import os
import random
import select
import shutil
import socket
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ALONE = ("unshare", "--user", "--map-root-user", "--net")
SERVER, CLIENT, PORT = "10.77.0.1", "10.77.0.2", 8080

TUNSETIFF, IFF_TUN, IFF_NO_PI = 0x400454CA, 0x0001, 0x1000

QUEUE = 64
"""Packets that wait for their turn each way; more are dropped, as a router does."""

LARGEST_PACKET = 2048


@dataclass(frozen=True)
class Line:
    """Both ends of a slow line.

    `bound` listens at its far end, for a server in this process; whoever comes to `url` comes
    through the line.
    """

    bound: socket.socket
    url: str
    client: int
    """The process at the browser's end."""

    def carried(self) -> int:
        """Bytes that have come to the browser's end, everything that TCP adds included."""
        rows = Path(f"/proc/{self.client}/net/dev").read_text().splitlines()
        (row,) = (row for row in rows if row.strip().startswith("line:"))
        return int(row.partition(":")[2].split()[0])


@contextlib.contextmanager
def slow_line(
    rate: float = 1e6, delay: float = 0.1, loss: float = 0.02, seed: int = 0
) -> Iterator[Line]:
    """A line with so many bits a second, seconds, and share of lost packets, each way."""
    with contextlib.ExitStack() as stack:
        inside = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
        inside.listen(64)
        _, tun, bound = _end(stack, "server")
        bound_socket = stack.enter_context(socket.socket(fileno=bound))
        arguments = (str(number) for number in (rate, delay, loss, seed))
        client, own_tun, _ = _end(stack, "client", *arguments, given=(tun, inside.fileno()))
        os.close(tun)
        os.close(own_tun)
        yield Line(bound_socket, f"http://127.0.0.1:{inside.getsockname()[1]}", client.pid)


def can_be_had() -> bool:
    """Whether namespaces and their devices can be had here."""
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return False
    tried = [*ALONE, sys.executable, __file__, "try"]
    return subprocess.run(tried, check=False, capture_output=True).returncode == 0


def _end(
    stack: contextlib.ExitStack, *arguments: str, given: tuple[int, ...] = ()
) -> tuple[subprocess.Popen[bytes], int, int]:
    """Start one end in a namespace of its own; its device, and a socket that listens there."""
    ours, theirs = socket.socketpair()
    with ours, theirs:
        number = theirs.fileno()
        process = subprocess.Popen(
            [*ALONE, sys.executable, __file__, *arguments, str(number), *map(str, given)],
            pass_fds=(number, *given),
            stdin=subprocess.PIPE,
        )
        stack.callback(process.wait, 10)
        assert process.stdin is not None
        # Its end is the end of what it reads from.
        stack.callback(process.stdin.close)
        ours.settimeout(60)
        _, received, _, _ = socket.recv_fds(ours, 1, 2)
    return process, received[0], received[-1]


def _tun(address: str) -> int:
    """A device of this namespace."""
    device = os.open("/dev/net/tun", os.O_RDWR)
    fcntl.ioctl(device, TUNSETIFF, struct.pack("16sH", b"line", IFF_TUN | IFF_NO_PI))
    for command in (
        f"ip addr add {address}/24 dev line",
        "ip link set line up",
        "ip link set lo up",
    ):
        subprocess.run(command.split(), check=True)
    return device


def _until_the_end() -> None:
    while os.read(0, 1):
        pass


def serve(number: str) -> None:
    """The server's end: a device, a socket that listens; the rest is somebody else's."""
    device = _tun(SERVER)
    bound = socket.create_server((SERVER, PORT), backlog=64)
    # Every machine has this one, and none makes less of a line that loses packets.
    bound.setsockopt(socket.IPPROTO_TCP, socket.TCP_CONGESTION, b"reno")
    with socket.socket(fileno=int(number)) as told:
        socket.send_fds(told, [b"x"], [device, bound.fileno()])
    os.close(device)
    bound.close()
    _until_the_end()


def connect(
    rate: str, delay: str, loss: str, seed: str, number: str, far: str, inside: str
) -> None:
    """The browser's end: the line itself, and the forwarder."""
    device = _tun(CLIENT)
    line = (device, int(far), float(rate), float(delay), float(loss), int(seed))
    threading.Thread(target=_carry, args=line, daemon=True).start()
    with socket.socket(fileno=int(number)) as told:
        socket.send_fds(told, [b"x"], [device])
    asyncio.run(_forward(socket.socket(fileno=int(inside))))


def _carry(near: int, far: int, rate: float, delay: float, loss: float, seed: int) -> None:
    """Bring packets from each device to the other one, for ever."""
    chance = random.Random(seed)
    under_way: list[tuple[float, int, int, bytes]] = []
    free = {near: 0.0, far: 0.0}
    """When the line is free again in the direction that begins there."""
    count = 0
    while True:
        wait = max(0.0, under_way[0][0] - time.monotonic()) if under_way else None
        readable, _, _ = select.select([near, far], [], [], wait)
        now = time.monotonic()
        for device in readable:
            packet = os.read(device, LARGEST_PACKET)
            takes = len(packet) * 8 / rate
            is_full = (free[device] - now) * rate / 8 > QUEUE * 1500
            if is_full or chance.random() < loss:
                continue
            free[device] = max(now, free[device]) + takes
            count += 1
            other = far if device == near else near
            heapq.heappush(under_way, (free[device] + delay, count, other, packet))
        while under_way and under_way[0][0] <= now:
            _, _, device, packet = heapq.heappop(under_way)
            with contextlib.suppress(OSError):
                os.write(device, packet)


async def _forward(inside: socket.socket) -> None:
    """Pass on what comes to `inside`, until the test ends."""
    server = await asyncio.start_server(_pass_on, sock=inside)
    async with server:
        await asyncio.to_thread(_until_the_end)
        os._exit(0)


async def _pass_on(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    try:
        far_reader, far_writer = await asyncio.open_connection(SERVER, PORT)
    except OSError:
        writer.transport.abort()
        return
    for each in (writer, far_writer):
        each.get_extra_info("socket").setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    await asyncio.gather(_copy(reader, far_writer), _copy(far_reader, writer))


async def _copy(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):
        while piece := await reader.read(16384):
            writer.write(piece)
            await writer.drain()
    with contextlib.suppress(OSError):
        writer.close()


if __name__ == "__main__":
    {"server": serve, "client": connect, "try": lambda: os.close(_tun(SERVER))}[sys.argv[1]](
        *sys.argv[2:]
    )
