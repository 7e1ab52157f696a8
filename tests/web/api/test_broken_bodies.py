"""What programs send that breaks off or does not decode: an answer or none, and no trace."""

import gzip
import socket
import struct
import zlib
from urllib.parse import urlsplit

import pytest
import requests
from idle import Idle
from waiting import PATIENCE

from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.web.access.identity import identify
from workbench.web.api import routes
from workbench.web.api.routes import api_routes

RESET = struct.pack("ii", 1, 0)
JSON = {"Content-Type": "application/json"}
PACKED = gzip.compress(b"{}", mtime=0)


@pytest.fixture
def bench(tmp_path):
    bench = Bench(read_cell("yumi"), Journal(tmp_path / "session"), effects=Idle)
    yield bench
    bench.close()


@pytest.fixture
def asked(bench, users, start):
    """Where the interface is behind the front, and the header of somebody who may scan."""
    front = start(routes=api_routes(bench, identify))
    token = users.make_token("Edda", "line")
    return f"{front.url}/api/v1", {"Authorization": f"Bearer {token}"}


def is_answered(asked):
    url, token = asked
    return requests.get(f"{url}/state", headers=token, timeout=PATIENCE).status_code == 200


@pytest.mark.parametrize(
    ("coding", "content"),
    [
        ("gzip", b"no gzip at all"),
        ("gzip", PACKED + b"more"),
        ("deflate", b"\xff" * 20),
    ],
)
def test_a_body_that_does_not_decode_is_a_bad_request(asked, bench, caplog, coding, content):
    url, token = asked
    before = bench.state.number
    headers = token | JSON | {"Content-Encoding": coding}
    answer = requests.post(f"{url}/scan", data=content, headers=headers, timeout=PATIENCE)
    assert answer.status_code == 400
    assert answer.json()["detail"] == "the body is not encoded as its head says"
    assert is_answered(asked)
    assert "Traceback" not in caplog.text
    assert len([line for line in caplog.messages if "refused body" in line]) == 1
    assert bench.state.number == before


def test_a_body_that_is_cut_off_is_answered(asked, bench, caplog, monkeypatch):
    """Whether aiohttp sees the end of the stream depends on how the bytes arrive."""
    monkeypatch.setattr(routes, "BODY_SECONDS", 0.5)
    url, token = asked
    before, cut = bench.state.number, zlib.compress(b"{}" * 500)[:-6]
    headers = token | JSON | {"Content-Encoding": "deflate"}
    for _ in range(4):
        answer = requests.post(f"{url}/scan", data=cut, headers=headers, timeout=PATIENCE)
        assert answer.status_code in (400, 408)
    assert is_answered(asked)
    assert "Traceback" not in caplog.text
    assert bench.state.number == before


def test_a_body_that_does_not_arrive_is_a_timeout(asked, monkeypatch):
    monkeypatch.setattr(routes, "BODY_SECONDS", 0.1)
    url, token = asked
    where = urlsplit(url)
    lines = [
        f"POST {where.path}/scan HTTP/1.1",
        f"Host: {where.netloc}",
        *(f"{name}: {value}" for name, value in (token | JSON).items()),
        "Content-Length: 100",
    ]
    with socket.create_connection((where.hostname, where.port), PATIENCE) as client:
        client.sendall("\r\n".join(lines).encode() + b"\r\n\r\n{")
        assert b" 408 " in client.recv(65536).splitlines()[0]
    assert is_answered(asked)


@pytest.mark.parametrize("resets", [False, True])
@pytest.mark.parametrize(
    "rest",
    [
        b"Content-Length: 100\r\n\r\n{",
        b"Content-Length: 100\r\n\r\n",
        b"Transfer-Encoding: chunked\r\n\r\n5\r\n{",
        b"Transfer-Encoding: chunked\r\n\r\n1\r\n{\r\n",
        b"Content-Encoding: gzip\r\nContent-Length: 90\r\n\r\n" + PACKED[:12],
    ],
)
def test_a_program_that_goes_in_the_middle_of_its_body_leaves_no_trace(
    asked, bench, caplog, capfd, rest, resets
):
    before = bench.state.number
    url, token = asked
    address = urlsplit(url)
    head = (
        f"POST {address.path}/scan HTTP/1.1\r\nHost: {address.netloc}\r\n"
        f"Authorization: {token['Authorization']}\r\nContent-Type: application/json\r\n"
    )
    with socket.create_connection((address.hostname, address.port), PATIENCE) as client:
        client.sendall(head.encode() + rest)
        client.settimeout(0.3)
        with pytest.raises(TimeoutError):
            client.recv(1)  # its body is being read now
        if resets:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
    assert is_answered(asked)
    assert "Traceback" not in "".join(capfd.readouterr()) + caplog.text
    assert bench.state.number == before
