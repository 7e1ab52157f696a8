"""Requests that are none, each kind once: an answer or an end, no trace, and others are served."""

import asyncio
import contextlib
import socket
from urllib.parse import urlsplit

import pytest
from attackers import PASSWORD, cookie_of, run
from waiting import PATIENCE

from workbench.studies.load.raw_browser import raw_browser

OURS = b"Host: 127.0.0.1:%d\r\n"
UNFINISHED = (b"name=", b"one\r\n")
REFUSED = {400, 403, 404, 405, 408, 411, 413, 414, 421, 431, 501, 505}


@pytest.fixture
def talk(front):
    """Says bytes to the front; what it answers, or nothing where it hangs up."""
    port = urlsplit(front.url).port

    def say(text: bytes) -> bytes:
        with socket.create_connection(("127.0.0.1", port), PATIENCE) as client:
            client.sendall(text.replace(b"{host}", OURS % port))
            heard = b""
            with contextlib.suppress(ConnectionError):
                # Who hangs up first gets no answer; some wait for the rest of what they heard.
                while b"\r\n\r\n" not in heard and not text.endswith(UNFINISHED):
                    piece = client.recv(65536)
                    heard += piece
                    if not piece:
                        return heard
                client.shutdown(socket.SHUT_WR)
                while piece := client.recv(65536):
                    heard += piece
            return heard

    return say


def status_of(heard: bytes) -> int:
    return int(heard.split(b" ", 2)[1]) if heard else 0


@pytest.mark.parametrize(
    "request_",
    {
        "no words": b"\r\n\r\none\r\n",
        "one word": b"GET\r\n\r\n",
        "not text": bytes(range(128, 256)) + b"\r\n\r\n",
        "TLS": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03" + b"\x00" * 40,
        "HTTP/2": b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n",
        "HTTP/9": b"GET / HTTP/9.9\r\n{host}\r\n",
        "method": b"G\x00T / HTTP/1.1\r\n{host}\r\n",
        "method of another": b"CONNECT evil.example:443 HTTP/1.1\r\n{host}\r\n",
        "long address": b"GET /" + b"a" * 20_000 + b" HTTP/1.1\r\n{host}\r\n",
        "long header": b"GET / HTTP/1.1\r\n{host}X: " + b"a" * 20_000 + b"\r\n\r\n",
        "many headers": b"GET / HTTP/1.1\r\n{host}" + b"X: a\r\n" * 9_000 + b"\r\n",
        "header without a name": b"GET / HTTP/1.1\r\n{host}: x\r\n\r\n",
        "space before the colon": b"GET / HTTP/1.1\r\n{host}X : x\r\n\r\n",
        "nul in a header": b"GET / HTTP/1.1\r\n{host}X: a\x00b\r\n\r\n",
        "folded header": b"GET / HTTP/1.1\r\n{host}\r\n folded: x\r\n\r\n"[:-2],
        "two hosts": b"GET / HTTP/1.1\r\n{host}Host: evil.example\r\n\r\n",
        "no host": b"GET / HTTP/1.1\r\n\r\n",
        "absolute form": b"GET http://evil.example/ HTTP/1.1\r\n{host}\r\n",
        "length that is none": b"POST /login HTTP/1.1\r\n{host}Content-Length: x\r\n\r\n",
        "length below nothing": b"POST /login HTTP/1.1\r\n{host}Content-Length: -1\r\n\r\n",
        "length with a sign": b"POST /login HTTP/1.1\r\n{host}Content-Length: +4\r\n\r\nabcd",
        "two lengths": b"POST /login HTTP/1.1\r\n{host}Content-Length: 4\r\n"
        b"Content-Length: 5\r\n\r\nabcde",
        "length and chunks": b"POST /login HTTP/1.1\r\n{host}Content-Length: 4\r\n"
        b"Transfer-Encoding: chunked\r\n\r\n0\r\n\r\n",
        "unknown transfer": b"POST /login HTTP/1.1\r\n{host}Transfer-Encoding: rot13\r\n\r\nx",
        "chunk that is none": b"POST /login HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n"
        b"\r\nzz\r\nx\r\n0\r\n\r\n",
        "chunk below nothing": b"POST /login HTTP/1.1\r\n{host}Transfer-Encoding: chunked\r\n"
        b"\r\n-1\r\nx\r\n0\r\n\r\n",
        "body that ends early": b"POST /login HTTP/1.1\r\n{host}Content-Length: 100\r\n\r\nname=",
        "cookie that is none": b"GET /who HTTP/1.1\r\n{host}Cookie: \xff;=;;a\r\n\r\n",
        "token that is none": b"GET /api/v1/state HTTP/1.1\r\n{host}"
        b"Authorization: Bearer \xff\xfe\r\n\r\n",
        "websocket of no version": b"GET /presence HTTP/1.1\r\n{host}Upgrade: websocket\r\n"
        b"Connection: Upgrade\r\nSec-WebSocket-Version: 99\r\n\r\n",
    }.items(),
    ids=lambda pair: pair[0],
)
def test_a_request_that_is_none_is_refused_in_one_line(talk, front, caplog, request_):
    heard = talk(request_[1])
    assert status_of(heard) in {0, 303, 401, *REFUSED}
    # The page and what it may talk to are never those of a name that is not ours.
    assert b"evil.example" not in heard.partition(b"\r\n\r\n")[0]
    assert "Traceback" not in caplog.text
    assert len(caplog.records) <= 2
    good = talk(b"GET /healthz HTTP/1.1\r\n{host}Connection: close\r\n\r\n")
    assert status_of(good) == 200


def test_what_follows_a_body_is_not_taken_for_the_request_of_somebody_else(talk):
    """Two lengths of one request are how something is smuggled past a proxy."""
    hidden = b"GET /healthz HTTP/1.1\r\n{host}\r\n"
    heard = talk(
        b"POST /login HTTP/1.1\r\n{host}Content-Length: %d\r\nTransfer-Encoding: chunked\r\n\r\n"
        b"0\r\n\r\n" % (5 + len(hidden)) + hidden
    )
    assert b'"ok"' not in heard


FRAMES = {
    "not masked": b"\x82\x01a",
    "reserved bits": b"\xf2\x81\0\0\0\0a",
    "no such kind": b"\x83\x81\0\0\0\0a",
    "long ping": b"\x89\xfe\x00\x80\0\0\0\0" + b"a" * 128,
    "ping in pieces": b"\x09\x81\0\0\0\0a",
    "goes on with nothing": b"\x80\x81\0\0\0\0a",
    "begins twice": b"\x02\x81\0\0\0\0a\x02\x81\0\0\0\0a",
    "length of half the world": b"\x82\xff\x7f\xff\xff\xff\xff\xff\xff\xff\0\0\0\0",
    "length with a sign": b"\x82\xff\xff\xff\xff\xff\xff\xff\xff\xff\0\0\0\0",
    "close without a reason": b"\x88\x81\0\0\0\0a",
    "close with no such code": b"\x88\x82\0\0\0\0\x00\x01",
    "text that is none": b"\x81\x82\0\0\0\0\xff\xfe",
    "packed that is not": b"\xc2\x84\0\0\0\0\xff\xff\xff\xff",
    "half a frame": b"\x82\xfe",
}


@pytest.mark.parametrize("path", ["/scene", "/presence"])
@pytest.mark.parametrize("frame", FRAMES.items(), ids=lambda pair: pair[0])
def test_frames_that_are_none_end_their_own_websocket_alone(front, scene, caplog, path, frame):
    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Otto", PASSWORD)
            address = urlsplit(front.url)
            reader, writer = await asyncio.open_connection(address.hostname, address.port)
            writer.write(
                f"GET {path} HTTP/1.1\r\nHost: {address.netloc}\r\nOrigin: {front.url}\r\n"
                f"Cookie: {await cookie_of(browser)}\r\nUpgrade: websocket\r\n"
                "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
                "Sec-WebSocket-Extensions: permessage-deflate\r\n"
                "Sec-WebSocket-Protocol: viser-v1.1.1\r\n"
                "Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n".encode()
            )
            assert b" 101 " in await reader.readline()
            writer.write(frame[1])
            writer.write_eof()
            while await reader.read(65536):
                pass
            writer.close()
            await browser.open()
            await browser.find("number")

    run(look())
    assert "Traceback" not in caplog.text


def test_a_small_message_that_unpacks_to_a_large_one_is_not_unpacked(front, said):
    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Otto", PASSWORD)
            await browser.open()
            assert browser.socket.compress
            await browser.find("number")
            await browser.send_raw(b"\0" * (40 * 1024 * 1024))
            assert await browser.close_code() in (1009, 1006)

    run(look())
    said("refused connection", "too big", '"Otto"')
