"""What is no Modbus, too much, too slow or too many: nobody else notices."""

import contextlib
import random
import socket
import struct
import threading

import pytest
from waiting import PATIENCE, wait_until

from workbench.extras.modbus import server as modbus_server
from workbench.extras.modbus.registers import MAP_VERSION, SIZE, Register
from workbench.extras.modbus.server import MOST_CLIENTS, ModbusOptions, ModbusServer
from workbench.model.errors import InputError

HEADER = struct.Struct(">HHHB")


@pytest.fixture
def server(site):
    with contextlib.closing(ModbusServer(site.bench, ModbusOptions(0))) as one:
        yield one


def connected(server, **where):
    return socket.create_connection(server.address, timeout=PATIENCE, **where)


def frame(body, protocol=0, length=None, transaction=1):
    return HEADER.pack(transaction, protocol, len(body) + 1 if length is None else length, 1) + body


READ = frame(struct.pack(">BHH", 3, Register.VERSION, 1))


def received(link, count):
    data = b""
    while len(data) < count and (more := link.recv(count - len(data))):
        data += more
    return data


def answer(link, request):
    """The answer to one request, without its header."""
    link.sendall(request)
    header = received(link, HEADER.size)
    return received(link, HEADER.unpack(header)[2] - 1) if header else b""


GOOD = struct.pack(">BBH", 3, 2, MAP_VERSION)


def is_cut_off(link):
    with contextlib.suppress(ConnectionError):
        return link.recv(1) == b""
    return True


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (b"\x03", b"\x83\x03"),
        (struct.pack(">BHH", 3, 0, 0), b"\x83\x03"),
        (struct.pack(">BHH", 3, 0, 126), b"\x83\x03"),
        (struct.pack(">BHH", 3, 0, SIZE + 1), b"\x83\x02"),
        (struct.pack(">BHHB", 16, 0, 2, 4) + b"\0\1", b"\x90\x03"),
        (struct.pack(">BHHB", 16, 0, 5, 2) + b"\0\1", b"\x90\x03"),
        (struct.pack(">BHHB", 16, 0, 0, 0), b"\x90\x03"),
        (struct.pack(">BHH", 6, 10, 1), b"\x86\x02"),
        (struct.pack(">BHHHHB", 23, 0, 1, 10, 1, 2) + b"\0\1", b"\x97\x02"),
        (struct.pack(">BHHHHB", 23, 0, 1, 0, 9, 2) + b"\0\1", b"\x97\x03"),
        (b"\x00", b"\x80\x01"),
        (b"\x2b\x0e\x01\x00", b"\xab\x01"),
        (b"\x83\x02", b"\x83\x01"),
        (b"\xff" * 253, b"\xff\x01"),
    ],
)
def test_a_request_that_cannot_be_is_refused_and_the_next_one_answered(server, body, said):
    with connected(server) as link:
        assert answer(link, frame(body)) == said
        assert answer(link, READ) == GOOD


@pytest.mark.parametrize(
    "sent",
    [
        b"GET / HTTP/1.1\r\n\r\n",
        frame(b"\x03\0\0\0\1", protocol=1),
        frame(b"", length=1),
        frame(b"", length=0),
        frame(b"\x03", length=255),
        frame(b"\x03", length=65535),
    ],
)
def test_who_sends_no_modbus_is_cut_off(server, sent):
    with connected(server) as link, connected(server) as other:
        link.sendall(sent)
        assert is_cut_off(link)
        assert answer(other, READ) == GOOD


def test_requests_that_come_split_or_together_are_each_answered(server):
    with connected(server) as link:
        for byte in READ:
            link.sendall(bytes([byte]))
        assert received(link, HEADER.size + 4)[-4:] == GOOD
        link.sendall(READ * 20)
        assert received(link, 20 * (HEADER.size + 4)).count(GOOD) == 20


def test_a_half_request_is_not_waited_for(server, monkeypatch):
    monkeypatch.setattr(modbus_server, "FRAME", 0.2)
    with connected(server) as link:
        link.sendall(READ[:-1])
        assert is_cut_off(link)


def test_a_client_that_hangs_is_dropped(server, monkeypatch):
    monkeypatch.setattr(modbus_server, "SILENCE", 0.2)
    with connected(server) as link:
        assert is_cut_off(link)


def test_a_client_that_takes_no_answers_is_dropped(server, monkeypatch):
    monkeypatch.setattr(modbus_server, "FRAME", 0.2)
    monkeypatch.setattr(modbus_server, "PAUSE", 0.0)
    with socket.socket() as link:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1024)
        link.settimeout(PATIENCE)
        link.connect(server.address)
        whole = frame(struct.pack(">BHH", 3, 0, SIZE))
        with pytest.raises(ConnectionError):
            while True:
                link.sendall(whole * 1000)


def test_thousands_of_connections_leave_the_plc_its_own(server):
    with connected(server) as plc, contextlib.ExitStack() as crowd:
        assert answer(plc, READ) == GOOD
        for number in range(2000):
            link = connected(server)
            if number % 20:
                link.close()
            else:
                crowd.enter_context(link)
        assert answer(plc, READ) == GOOD
        wait_until(lambda: len(server._here) <= MOST_CLIENTS)


def test_who_is_silent_longest_gives_way(server):
    with contextlib.ExitStack() as opened:
        links = [opened.enter_context(connected(server)) for _ in range(MOST_CLIENTS)]
        for link in links:
            assert answer(link, READ) == GOOD
        newest = opened.enter_context(connected(server))
        assert answer(newest, READ) == GOOD
        assert is_cut_off(links[0])
        assert answer(links[1], READ) == GOOD


def test_addresses_that_are_not_stated_are_refused(site):
    options = ModbusOptions(0, "127.0.0.1", ("127.0.0.2",))
    with contextlib.closing(ModbusServer(site.bench, options)) as server:
        with connected(server, source_address=("127.0.0.2", 0)) as link:
            assert answer(link, READ) == GOOD
        with connected(server) as link:
            assert is_cut_off(link)


@pytest.mark.parametrize("clients", [(), ("::1",)])
def test_addresses_of_ipv6_are_compared_as_they_are(site, clients):
    try:
        server = ModbusServer(site.bench, ModbusOptions(0, "::1", clients))
    except InputError:
        pytest.skip("this machine has no IPv6")
    with contextlib.closing(server), connected(server) as link:
        assert answer(link, READ) == GOOD


def test_random_bytes_change_nothing(site, server):
    chance = random.Random(3)
    before = site.bench.state
    for _ in range(300):
        with connected(server) as link, contextlib.suppress(OSError):
            body = chance.randbytes(chance.randint(1, 253))
            is_framed = chance.random() < 0.7
            link.sendall(frame(body) if is_framed else body)
            link.shutdown(socket.SHUT_WR)
            while link.recv(4096):
                pass
    with connected(server) as link:
        assert answer(link, READ) == GOOD
    assert site.bench.state is before


def test_the_server_ends_with_clients_connected(site):
    server = ModbusServer(site.bench, ModbusOptions(0))
    with connected(server) as link:
        assert answer(link, READ) == GOOD
        server.close()
        assert is_cut_off(link)
    assert not [one for one in threading.enumerate() if one.name == "modbus"]
