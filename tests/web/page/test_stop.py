"""A stop comes by the websocket of the bar as well, which is open all the time."""

import asyncio
import json
import threading

import pytest
from attackers import PASSWORD, SECRET, run
from waiting import PATIENCE

from workbench.studies.load.raw_browser import raw_browser
from workbench.web.page.relay import Upstream
from workbench.web.server import ServerOptions, serve_front


@pytest.fixture
def stops():
    return []


@pytest.fixture
def stoppable(users, file, scene, stops):
    def stop(person):
        stops.append(person)
        return "" if person.name == "Otto" else "a viewer stops nothing"

    front = serve_front(
        Upstream(scene.url, SECRET), file, ServerOptions(port=0), title="stopped", stop=stop
    )
    yield front
    front.close()


async def answer_of(presence):
    async with asyncio.timeout(PATIENCE):
        while True:
            said = json.loads((await presence.receive()).data)
            if "stopped" in said:
                return said


@pytest.mark.parametrize(
    ("name", "answer"),
    [
        ("Otto", {"stopped": True, "why": ""}),
        ("Vera", {"stopped": False, "why": "a viewer stops nothing"}),
    ],
)
def test_a_stop_is_done_in_the_name_of_the_login_and_answered(stoppable, stops, name, answer):
    async def look():
        async with raw_browser(stoppable.url) as browser:
            await browser.log_in(name, PASSWORD)
            origin = {"Origin": stoppable.url}
            presence = await browser.session.ws_connect(f"{stoppable.url}/presence", headers=origin)
            for _ in range(2):
                await presence.send_str("stop")
                assert await answer_of(presence) == answer

    run(look())
    assert [person.name for person in stops] == [name, name]


def test_a_stop_waits_for_no_passwords_that_are_being_tried(stoppable, stops):
    may_end, loop = threading.Event(), stoppable._running.loop

    async def look():
        async with raw_browser(stoppable.url) as browser:
            await browser.log_in("Otto", PASSWORD)
            origin = {"Origin": stoppable.url}
            presence = await browser.session.ws_connect(f"{stoppable.url}/presence", headers=origin)
            for _ in range(64):  # more than asyncio has threads
                loop.call_soon_threadsafe(loop.run_in_executor, None, may_end.wait, PATIENCE)
            await presence.send_str("stop")
            assert (await answer_of(presence))["stopped"]

    try:
        run(look())
    finally:
        may_end.set()
    assert len(stops) == 1


@pytest.mark.parametrize("said", ["", "Stop", "stop ", '{"stop": true}', b"stop"])
def test_anything_else_stops_nothing_and_ends_the_websocket(stoppable, stops, said):
    async def look():
        async with raw_browser(stoppable.url) as browser:
            await browser.log_in("Otto", PASSWORD)
            origin = {"Origin": stoppable.url}
            presence = await browser.session.ws_connect(f"{stoppable.url}/presence", headers=origin)
            await (presence.send_bytes if isinstance(said, bytes) else presence.send_str)(said)
            async for _ in presence:
                pass

    run(look())
    assert not stops


def test_a_login_that_is_over_stops_nothing(stoppable, stops, users):
    async def look():
        async with raw_browser(stoppable.url) as browser:
            await browser.log_in("Otto", PASSWORD)
            origin = {"Origin": stoppable.url}
            presence = await browser.session.ws_connect(f"{stoppable.url}/presence", headers=origin)
            await presence.receive()
            await asyncio.to_thread(users.set_disabled, "Otto", True)
            async for _ in presence:
                pass
            with pytest.raises(ConnectionError):
                await presence.send_str("stop")

    run(look())
    assert not stops
