"""The stream of states: every listener is told the newest one, and nobody is waited for."""

import asyncio
import json

import pytest
import requests
from aiohttp import web

from workbench.app.core.control import TakeControl
from workbench.app.runtime.live import Live
from workbench.app.runtime.worker import GettingReady
from workbench.web.api import events


def heard(lines):
    """Events of a stream as they come: name and content."""
    name = ""
    for line in lines:
        if line.startswith("event: "):
            name = line.removeprefix("event: ")
        elif line.startswith("data: "):
            yield name, json.loads(line.removeprefix("data: "))
        elif line.startswith(":"):
            yield "beat", None


@pytest.fixture
def listen(site):
    opened = []

    def one():
        answer = site.get("/events", stream=True)
        opened.append(answer)
        assert answer.headers["Content-Type"] == "text/event-stream"
        return heard(answer.iter_lines(decode_unicode=True))

    yield one
    for answer in opened:
        answer.close()


def test_a_listener_is_told_the_state_and_every_later_one(site, listen):
    stream = listen()
    assert next(stream)[1]["phase"] == "idle"
    site.bench.do(TakeControl(), "Ada")
    name, state = next(stream)
    assert (name, state["control"], state["number"]) == ("state", "Ada", 2)


def test_a_running_task_is_told_too(site, listen):
    site.effects.hold.set()
    stream = listen()
    next(stream)
    site.post("/scan")
    told = {name: content for name, content in (next(stream), next(stream))}
    assert told["job"]["job"]["name"] == "scan"


def test_that_it_is_ready_is_told_when_nothing_else_has_changed(site, listen):
    site.effects.live = Live(getting_ready=GettingReady(0.4, "getting ready"))
    stream = listen()
    assert next(stream)[1]["getting_ready"]["done"] == 0.4
    name, told = next(stream)
    assert (name, told["job"], told["getting_ready"]["done"]) == ("job", None, 0.4)
    site.effects.live = Live()
    name, told = next(stream)
    assert (name, told["getting_ready"]) == ("state", None)


@pytest.mark.parametrize("heartbeat", [0.05])
def test_who_listens_to_nothing_hears_that_the_stream_lives(listen):
    stream = listen()
    assert [next(stream)[0] for _ in range(3)] == ["state", "beat", "beat"]


@pytest.mark.parametrize("heartbeat", [0.05])
def test_a_login_that_ends_ends_the_stream(people, listen):
    stream = listen()
    next(stream)
    people.pop("Bearer ada")
    assert all(name == "beat" for name, _ in stream), "and it ends"


def test_a_listener_that_does_not_read_is_cut(listen, site, monkeypatch):
    stream = listen()
    next(stream)
    monkeypatch.setattr(events, "WRITE_SECONDS", 0.1)

    async def never(response, data):
        await asyncio.Event().wait()

    monkeypatch.setattr(web.StreamResponse, "write", never)
    site.bench.do(TakeControl(), "Ada")
    with pytest.raises(requests.exceptions.ChunkedEncodingError):
        next(stream)


def test_so_many_listen_and_no_more(site, listen, monkeypatch):
    monkeypatch.setattr(events, "MOST_LISTENERS", 2)
    streams = [listen() for _ in range(2)]
    for stream in streams:
        next(stream)
    answer = site.get("/events")
    assert answer.status_code == 503
    assert "close one first" in answer.json()["detail"]
