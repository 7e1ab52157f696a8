"""The websocket to viser: what passes, what does not, and when it is cut."""

import asyncio
import socket

import pytest
import websockets
from attackers import PASSWORD, SECRET, at_the_page, refused_with, run

from workbench.app.core.people import Person, Role
from workbench.studies.load.raw_browser import PROTOCOL, raw_browser
from workbench.web.page.conversation import MOST_REFUSED
from workbench.web.page.rate_limit import AT_ONCE
from workbench.web.page.relay import Upstream, panel_width
from workbench.web.server import ServerOptions, serve_front

GIZMO = {"name": "/gizmo", "wxyz": (1.0, 0.0, 0.0, 0.0)}


def test_viser_itself_answers_nobody_but_the_front(scene):
    async def look():
        url = scene.url.replace("http", "ws")
        for headers in (
            {},
            {"X-WB-Key": "guessed"},
            {"X-WB-Key": SECRET},  # names nobody
            {"X-WB-Key": SECRET, "X-WB-User": "Eve", "X-WB-Role": "king"},
        ):
            with pytest.raises(websockets.InvalidStatus) as caught:
                await websockets.connect(url, subprotocols=[PROTOCOL], additional_headers=headers)
            assert caught.value.response.status_code == 403
        async with raw_browser(scene.url) as browser:
            assert (await browser.get("/"))[0] == 403
            assert (await browser.get("/", **{"X-WB-Key": "guessed"}))[0] == 403
            assert (await browser.get("/", **{"X-WB-Key": SECRET}))[0] == 200

    run(look())


def test_the_page_knows_who_sits_at_a_browser(front, scene):
    async def look():
        for name in ("Vera", "Otto", "Edda"):
            async with at_the_page(front, name):
                pass

    run(look())
    assert scene.people == [
        Person("Vera", Role.VIEWER),
        Person("Otto", Role.OPERATOR),
        Person("Edda", Role.ENGINEER),
    ]


def test_what_a_browser_says_of_itself_does_not_count(front, scene):
    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Vera", PASSWORD)
            claims = {"X-WB-User": "Edda", "X-WB-Role": "engineer", "X-WB-Key": SECRET}
            await browser.open(**claims)
            await browser.find("number")

    run(look())
    assert scene.people == [Person("Vera", Role.VIEWER)]


@pytest.mark.parametrize(
    ("cookie", "width"),
    [("620", "620"), ("319", ""), ("1201", ""), ("+620", ""), ("6.2e2", ""), ("٦٢٠", ""), ("", "")],
)
def test_a_width_of_the_controls_is_a_number_of_pixels_within_bounds(cookie, width):
    assert panel_width(cookie) == width


def test_without_a_login_there_is_no_websocket(front, users, said):
    async def look():
        async with raw_browser(front.url) as browser:
            assert await refused_with(browser.open()) == 401
            forged = {"Cookie": f"workbench-{front.url.rpartition(':')[2]}=forged"}
            assert await refused_with(browser.open(**forged)) == 401
            token = {"Authorization": "Bearer wb_forged"}
            assert await refused_with(browser.open(**token)) == 401
            good = {"Authorization": f"Bearer {users.make_token('Otto', 'line')}"}
            assert await refused_with(browser.open(**good)) == 401  # tokens are for programs
            assert await refused_with(browser.open("/presence")) == 401

    run(look())
    said("refused websocket", "no login", "127.0.0.1")


@pytest.mark.parametrize("origin", ["http://evil.example", "null", ""])
def test_a_page_of_another_site_gets_no_websocket(front, said, origin):
    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Otto", PASSWORD)
            assert await refused_with(browser.open(Origin=origin)) == 403
            assert await refused_with(browser.open("/presence", Origin=origin)) == 403

    run(look())
    said("refused origin")


def test_only_the_page_itself_is_relayed(front):
    async def look():
        async with raw_browser(front.url) as browser:
            await browser.log_in("Otto", PASSWORD)
            assert await refused_with(browser.open("/scene?websocket=ws://evil.example")) == 400
            status, _ = await browser.get("/scene/?websocket=ws://evil.example")
            assert status == 303

    run(look())


def test_a_viser_that_does_not_answer_is_said(users, file, monkeypatch):
    monkeypatch.setattr("workbench.web.page.relay.ANSWER_SECONDS", 0.2)
    with socket.create_server(("127.0.0.1", 0)) as mute:
        upstream = Upstream(f"http://127.0.0.1:{mute.getsockname()[1]}", SECRET)
        front = serve_front(upstream, file, ServerOptions(port=0), title="mute")

        async def look():
            async with raw_browser(front.url) as browser:
                await browser.log_in("Otto", PASSWORD)
                assert (await browser.get("/scene/"))[0] == 503
                assert await refused_with(browser.open()) == 503

        run(look())
        front.close()


def test_presses_and_values_arrive(front, scene):
    async def look():
        async with at_the_page(front, "Vera") as browser:
            await browser.find("press Vera")
            await browser.set("press Vera", True)
            await browser.set("number", 4)
            await asyncio.to_thread(scene.wait, lambda: scene.presses and scene.numbers)

    run(look())
    assert scene.presses == ["Vera"]
    assert scene.numbers == [4.0]


@pytest.mark.parametrize(
    ("kind", "fields"),
    [
        ("ShareUrlRequest", {}),
        ("ShareUrlDisconnect", {}),
        ("RunJavascriptMessage", {"source": "alert(1)"}),
        ("GetRenderResponseMessage", {"payload": bytes(200_000), "render_uuid": "x"}),
        ("NoSuchMessage", {}),
        ("TransformControlsUpdateMessage", {**GIZMO, "position": (9e9, 0.0, 0.0)}),
        ("TransformControlsUpdateMessage", {**GIZMO, "position": (float("nan"), 0.0, 0.0)}),
        ("TransformControlsUpdateMessage", {**GIZMO, "position": (0.0, 0.0)}),
    ],
    ids=lambda value: str(value)[:80],
)
def test_what_the_page_never_says_is_dropped(front, scene, said, kind, fields):
    async def look():
        async with at_the_page(front, "Edda") as browser:
            await browser.send(kind, **fields)
            await browser.set("number", 1)
            await asyncio.to_thread(scene.wait, lambda: scene.numbers)

    run(look())
    said("refused message", '"Edda"')
    assert scene.moved == []


@pytest.mark.parametrize(
    "updates",
    [
        {"update_cb": []},
        {"value": 1, "update_cb": []},
        {"removed": True},
        {},
        {"value": float("inf")},
        {"value": float("nan")},
        {"value": {"a": 1}},
        {"value": b"bytes"},
        {"value": "x" * 30_000},
        {"value": [[0] * 10]},
    ],
    ids=lambda updates: str(updates)[:30],
)
def test_of_a_widget_only_its_value_can_be_set(front, scene, said, updates):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            number = browser.widgets["number"]
            await browser.send("GuiUpdateMessage", uuid=number, updates=updates)
            await browser.set("number", 1)
            await asyncio.to_thread(scene.wait, lambda: scene.numbers)

    run(look())
    said("refused message", '"Otto"')
    assert scene.numbers == [1.0]


def test_garbage_is_dropped_and_too_much_of_it_cuts(front, said):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            for number in range(MOST_REFUSED):
                await browser.send_raw((b"\xc1", b"", b"\x91" * 5000, b"\x81\xa4type")[number % 4])
            assert await browser.close_code() == 1008

    run(look())
    said("refused message", "malformed")
    said("refused connection", "too much was refused")


def test_text_is_no_message(front, said):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            await browser.socket.send_str("{}")
            assert await browser.close_code() == 1003

    run(look())
    said("refused connection", "only binary")


def test_a_message_that_is_too_big_cuts(front, said):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            await browser.send_raw(b"\x00" * (2 * 1024 * 1024))
            assert await browser.close_code() == 1009

    run(look())
    said("refused connection", "too big", '"Otto"')


def test_of_a_flood_of_values_the_newest_arrives(front, scene):
    count = 20 * AT_ONCE

    async def look():
        async with at_the_page(front, "Otto") as browser:
            reading = asyncio.create_task(browser.close_code())
            for number in range(count):
                await browser.set("number", number + 1)
            await asyncio.to_thread(scene.wait, lambda: float(count) in scene.numbers)
            reading.cancel()

    run(look())
    assert len(scene.numbers) < count


def test_presses_are_not_overtaken_and_too_many_cut(front, scene, said):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            await browser.find("press Otto")
            for _ in range(AT_ONCE + 40):
                await browser.set("press Otto", True)
            await asyncio.to_thread(scene.wait, lambda: len(scene.presses) == AT_ONCE + 40)
            for _ in range(5000):
                await browser.set("press Otto", True)
            assert await browser.close_code() == 1008

    run(look())
    said("refused connection", "more messages than a hand")


def test_a_viewer_cannot_press_what_an_operator_has(front, scene, said):
    async def look():
        async with at_the_page(front, "Otto") as otto, at_the_page(front, "Vera") as vera:
            await otto.find("press Otto")
            await vera.find("press Vera")
            theirs = otto.widgets["press Otto"]
            await vera.send("GuiUpdateMessage", uuid=theirs, updates={"value": True})
            await vera.send("TransformControlsUpdateMessage", **GIZMO, position=(1.0, 0.0, 0.0))
            await vera.set("press Vera", True)
            await asyncio.to_thread(scene.wait, lambda: scene.presses)

    run(look())
    assert scene.presses == ["Vera"]
    assert scene.moved == []
    said("refused message", "TransformControlsUpdateMessage", '"Vera"')
