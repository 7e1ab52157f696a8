"""A client that asks for much shares it with others, and is disconnected if it does not read."""

import io
import socket
from contextlib import suppress
from urllib.parse import urlsplit

import numpy as np
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.scanning import TakeScan
from workbench.web.api import resources
from workbench.web.http import long_answers

LONG = 64 * 2**20
"""[bytes] More than the machine takes from the server while nobody reads."""


def scanned(site):
    site.bench.do(TakeScan(seed=1), "ada")
    site.reach("scanned")


def test_all_clients_get_the_points_that_were_packed_once(site, monkeypatch):
    scanned(site)
    packed, pack = [], np.savez_compressed

    def count(file, **values):
        packed.append(values)
        pack(file, **values)

    monkeypatch.setattr(np, "savez_compressed", count)
    resources._packed_points.cache_clear()  # another test may have asked for the same scan
    answers = [site.get("/scan/points", who).content for who in ("ada", "bob", "vic")]
    assert len(packed) == 1 and answers[0] == answers[1] == answers[2]
    assert len(np.load(io.BytesIO(answers[0]))["points"]) == len(site.bench.state.scan.points)


def test_a_client_that_does_not_read_a_long_answer_is_disconnected(site, monkeypatch):
    ended, write = [], long_answers.write_within

    async def noted(*given):
        try:
            await write(*given)
        except ConnectionResetError as error:
            ended.append(str(error))
            raise

    monkeypatch.setattr(long_answers, "write_within", noted)
    monkeypatch.setattr(long_answers, "PIECE_SECONDS", 0.1)
    monkeypatch.setattr(resources, "_packed_points", lambda scan: bytes(LONG))
    scanned(site)
    where = urlsplit(site.url)
    lines = (f"GET {where.path}/scan/points HTTP/1.1", "Host: here", "Authorization: Bearer vic")
    with socket.create_connection((where.hostname, where.port), PATIENCE) as client:
        client.sendall("\r\n".join([*lines, "", ""]).encode())
        wait_until(lambda: ended)
        received = 0
        with suppress(ConnectionResetError):
            while data := client.recv(2**20):
                received += len(data)
    assert ended == ["the client does not read"]
    assert received < LONG
    assert site.get("/scan").status_code == 200
