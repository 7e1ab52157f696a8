"""Bodies that do not decode, connections that go away: one line at most, and the right status."""

import gzip
import socket
import ssl
import struct
import zlib
from urllib.parse import urlsplit

import pytest
from aiohttp import web
from waiting import PATIENCE

from workbench.web.page.logins import read_form

FORM = b"name=Otto&password=wrong&pad=" + b"x" * 400
RESET = struct.pack("ii", 1, 0)


async def take(request):
    """A route that reads all of a form."""
    await read_form(request)
    return web.Response(text="taken")


async def leave(request):
    """A route that does not look at its body."""
    del request
    return web.Response(text="left")


@pytest.fixture
def heads(start, users):
    """Where bodies go, and the front that they go to."""
    front = start(routes=[web.post("/take", take), web.post("/leave", leave)])
    return front, {
        "/take": "Content-Type: application/x-www-form-urlencoded\r\n",
        "/login": "Content-Type: application/x-www-form-urlencoded\r\n",
        "/leave": "Content-Type: text/plain\r\n",
        "/nowhere": "Content-Type: text/plain\r\n",
    }


def head_of(front, path, more=""):
    address = urlsplit(front.url).netloc
    return f"POST {path} HTTP/1.1\r\nHost: {address}\r\nOrigin: {front.url}\r\n{more}".encode()


def exchanged(front, said):
    """What the front answers to these bytes, until it hangs up."""
    address = urlsplit(front.url)
    with socket.create_connection((address.hostname, address.port), PATIENCE) as client:
        client.sendall(said)
        heard = b""
        try:
            while piece := client.recv(65536):
                heard += piece
        except ConnectionError:
            pass
    return heard


def status_of(heard):
    return int(heard.split(b" ", 2)[1]) if heard else 0


def serves(front):
    """Whether it still answers."""
    address = urlsplit(front.url).netloc
    asked = f"GET /healthz HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n\r\n"
    return status_of(exchanged(front, asked.encode())) == 200


def has_no_trace(caplog, capfd):
    return "Traceback" not in "".join(capfd.readouterr()) + caplog.text


BODIES = {
    "gzip that is none": ("gzip", b"no gzip at all", {400}),
    "gzip with more behind": ("gzip", gzip.compress(FORM) + b"more", {400}),
    "GZIP that is none": ("GZIP", b"no gzip at all", {400}),
    "deflate that is none": ("deflate", b"\xff" * 20, {400}),
    "deflate that ends early": ("deflate", zlib.compress(FORM)[:-6], {400}),
    "br that is none": ("br", b"\xff" * 20, {400, 415}),
    "zstd that is none": ("zstd", b"\x28\xb5\x2f\xfd\xff\xff\xff\xff", {400, 415}),
    "twice": ("gzip, gzip", gzip.compress(gzip.compress(FORM)), {415}),
    "both": ("deflate, gzip", gzip.compress(zlib.compress(FORM)), {415}),
    "one nobody knows": ("rot13", FORM, {415}),
    "much from little": ("gzip", gzip.compress(bytes(80_000_000)), {400, 413}),
}


@pytest.mark.parametrize("is_chunked", [False, True])
@pytest.mark.parametrize("path", ["/take", "/login", "/leave", "/nowhere"])
@pytest.mark.parametrize("body", BODIES.items(), ids=lambda pair: pair[0])
def test_a_body_that_does_not_decode_is_one_line_and_the_right_status(
    heads, caplog, capfd, body, path, is_chunked
):
    front, heads = heads
    coding, content, statuses = body[1]
    head = head_of(front, path, f"{heads[path]}Content-Encoding: {coding}\r\nConnection: close\r\n")
    if is_chunked:
        head += b"Transfer-Encoding: chunked\r\n\r\n"
        content = b"%x\r\n%b\r\n0\r\n\r\n" % (len(content), content)
    else:
        head += b"Content-Length: %d\r\n\r\n" % len(content)
    # Before a body is looked at: forms have to say their length, and some routes read none.
    also = {411, 413} if is_chunked and path in ("/take", "/login") else set()
    also |= {200, 404} if path in ("/leave", "/nowhere") else set()
    assert status_of(exchanged(front, head + content)) in statuses | also
    assert serves(front)
    assert has_no_trace(caplog, capfd)
    assert len([line for line in caplog.records if line.name != "websockets.server"]) <= 1


def test_a_body_in_an_encoding_that_is_known_is_read(heads):
    front, heads = heads
    for coding, pack in (("gzip", gzip.compress), ("deflate", zlib.compress)):
        content = pack(FORM)
        about = f"{heads['/take']}Content-Encoding: {coding}\r\nConnection: close\r\n"
        head = head_of(front, "/take", about) + b"Content-Length: %d\r\n\r\n" % len(content)
        assert status_of(exchanged(front, head + content)) == 200


CUT = {
    "in its head": b"POST /take HTTP/1.1\r\nHost: 127",
    "before its body": b"Content-Length: 100\r\n\r\n",
    "in its body": b"Content-Length: 100\r\n\r\nabc",
    "in a chunk": b"Transfer-Encoding: chunked\r\n\r\n5\r\nab",
    "between chunks": b"Transfer-Encoding: chunked\r\n\r\n2\r\nab\r\n",
    "in a packed body": b"Content-Encoding: gzip\r\nContent-Length: 500\r\n\r\n"
    + gzip.compress(FORM)[:20],
    "with garbage behind": b"Content-Length: 2\r\n\r\nabGARBAGE\x00\xff\r\n\r\n",
}


@pytest.mark.parametrize("resets", [False, True])
@pytest.mark.parametrize("path", ["/take", "/login", "/leave", "/nowhere"])
@pytest.mark.parametrize("cut", CUT.items(), ids=lambda pair: pair[0])
def test_who_goes_in_the_middle_of_a_request_leaves_no_trace(
    heads, caplog, capfd, cut, path, resets
):
    front, heads = heads
    address = urlsplit(front.url)
    said = cut[1] if cut[1].startswith(b"POST") else head_of(front, path, heads[path]) + cut[1]
    with socket.create_connection((address.hostname, address.port), PATIENCE) as client:
        client.sendall(said)
        if resets:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
    assert serves(front)
    assert has_no_trace(caplog, capfd)
    assert len([line for line in caplog.records if line.name != "websockets.server"]) <= 1


@pytest.mark.parametrize("count", [1, 200, 3000])
def test_garbage_behind_requests_in_a_row_ends_that_connection_alone(heads, caplog, capfd, count):
    front, _ = heads
    address = urlsplit(front.url).netloc
    asked = f"GET /healthz HTTP/1.1\r\nHost: {address}\r\n\r\n".encode()
    heard = exchanged(front, asked * count + b"\x00\x01 no request\r\n\r\n")
    assert status_of(heard) in {200, 400}
    assert serves(front)
    assert has_no_trace(caplog, capfd)


@pytest.mark.parametrize(
    "flood",
    {
        "many headers": b"".join(b"X-%d: a\r\n" % k for k in range(2000)),
        "a long header": b"X: " + b"a" * 12_000 + b"\r\n",
        "many cookies": b"Cookie: " + b"a=b; " * 1600 + b"\r\n",
        "long cookies": b"Cookie: a=" + b"b" * 7000 + b"\r\n" * 1,
    }.items(),
    ids=lambda pair: pair[0],
)
def test_a_flood_of_headers_is_refused_or_answered(heads, caplog, capfd, flood):
    front, _ = heads
    address = urlsplit(front.url).netloc
    head = f"GET /who HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\n".encode()
    assert status_of(exchanged(front, head + flood[1] + b"\r\n")) in {0, 200, 303, 400, 401, 431}
    assert serves(front)
    assert has_no_trace(caplog, capfd)


HELLOS = {
    "HTTP": b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n",
    "garbage": bytes(range(256)) * 4,
    "a record too long": b"\x16\x03\x01\xff\xff" + b"\x00" * 400,
    "SSL 3": b"\x16\x03\x00\x00\x2f\x01\x00\x00\x2b\x03\x00" + b"\x00" * 40,
    "half a hello": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    "an alert": b"\x15\x03\x01\x00\x02\x02\x28",
    "nothing": b"",
}


@pytest.mark.parametrize("resets", [False, True])
@pytest.mark.parametrize("hello", HELLOS.items(), ids=lambda pair: pair[0])
def test_a_tls_hello_that_is_none_ends_its_own_connection(
    users, start, certificate, caplog, capfd, hello, resets
):
    front = start(certificate=certificate)
    address = urlsplit(front.url)
    with socket.create_connection((address.hostname, address.port), PATIENCE) as client:
        client.sendall(hello[1])
        if resets:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, RESET)
    trusting = ssl.create_default_context(cafile=certificate.certificate)
    with (
        socket.create_connection((address.hostname, address.port), PATIENCE) as plain,
        trusting.wrap_socket(plain, server_hostname="localhost") as client,
    ):
        asked = (
            f"GET /healthz HTTP/1.1\r\nHost: localhost:{address.port}\r\nConnection: close\r\n\r\n"
        )
        client.sendall(asked.encode())
        assert client.recv(65536).split(b" ", 2)[1] == b"200"
    assert has_no_trace(caplog, capfd)
