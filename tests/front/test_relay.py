"""The websocket to viser: what passes, what does not, and when it is cut."""

import asyncio

import aiohttp
import pytest
import websockets
from attackers import PASSWORD, PATIENCE, SECRET, at_the_page, cookie_of, run

from workbench.app.people import Person, Role
from workbench.front.connections import MOST_OF_ONE, OVER
from workbench.front.conversation import MOST_REFUSED
from workbench.front.pace import AT_ONCE
from workbench.front.raw_browser import PROTOCOL, raw_browser
from workbench.front.uploads import MOST_BYTES, PART_BYTES

GIZMO = {"name": "/gizmo", "wxyz": (1.0, 0.0, 0.0, 0.0)}


async def refused_with(opening):
    """The status that a websocket is refused with."""
    with pytest.raises(aiohttp.WSServerHandshakeError) as caught:
        await opening
    return caught.value.status


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
        ("GetRenderResponseMessage", {"payload": b"", "render_uuid": "x"}),
        ("NoSuchMessage", {}),
        ("TransformControlsUpdateMessage", {**GIZMO, "position": (9e9, 0.0, 0.0)}),
        ("TransformControlsUpdateMessage", {**GIZMO, "position": (float("nan"), 0.0, 0.0)}),
        ("TransformControlsUpdateMessage", {**GIZMO, "position": (0.0, 0.0)}),
    ],
    ids=str,
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


async def announce(browser, size, parts=None, transfer="t"):
    await browser.send(
        "FileTransferStartUpload",
        source_component_uuid=browser.widgets["file"],
        transfer_uuid=transfer,
        filename="scan.ply",
        mime_type="",
        part_count=-(-size // PART_BYTES) if parts is None else parts,
        size_bytes=size,
    )


async def send_part(browser, index, content, transfer="t"):
    await browser.send(
        "FileTransferPart",
        source_component_uuid=browser.widgets["file"],
        transfer_uuid=transfer,
        part_index=index,
        content=content,
    )


def test_a_file_arrives_whole(front, scene):
    size = 3 * PART_BYTES + 17

    async def look():
        async with at_the_page(front, "Otto") as browser:
            await browser.find("file")
            reading = asyncio.create_task(browser.close_code())
            await announce(browser, size)
            for index in range(4):
                await send_part(browser, index, b"x" * min(PART_BYTES, size - index * PART_BYTES))
            await asyncio.to_thread(scene.wait, lambda: scene.files)
            reading.cancel()

    run(look())
    assert scene.files == [("scan.ply", size)]


def test_a_viewer_sends_no_files(front, scene, said):
    async def look():
        async with at_the_page(front, "Vera") as browser:
            await browser.find("file")
            await announce(browser, 10)
            await send_part(browser, 0, b"x" * 10)
            await browser.set("number", 1)
            await asyncio.to_thread(scene.wait, lambda: scene.numbers)

    run(look())
    assert scene.files == []
    said("refused message", "FileTransferStartUpload", '"Vera"')


@pytest.mark.parametrize(
    "attack",
    [
        pytest.param([(10, None), (0, 90_000)], id="more than announced"),
        pytest.param([(10, 200)], id="more parts than the size has"),
        pytest.param([(MOST_BYTES + 1, None)], id="too big"),
        pytest.param([(10**12, 100_000)], id="a terabyte"),
        pytest.param([(2 * PART_BYTES, None), (1, PART_BYTES)], id="out of order"),
        pytest.param([(2 * PART_BYTES, None), (0, 5)], id="short part"),
    ],
)
def test_files_that_are_not_as_announced_cut(front, scene, said, attack):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            await browser.find("file")
            size, parts = attack[0]
            await announce(browser, size, parts)
            for index, length in attack[1:]:
                await send_part(browser, index, b"x" * length)
            assert await browser.close_code() == 1008

    run(look())
    said("refused connection", "bytes" if len(attack) < 2 or attack[1][0] == 0 else "part")
    assert scene.files == []


def test_logging_out_cuts_all_windows_of_the_browser(front):
    async def look():
        async with at_the_page(front, "Otto") as browser, at_the_page(front, "Otto") as other:
            cookie = await cookie_of(browser)
            presence = await browser.session.ws_connect(
                f"{front.url}/presence", headers={"Origin": front.url, "Cookie": cookie}
            )
            assert await browser.post("/logout", {}) == 303
            assert await browser.close_code() == OVER
            await presence.receive(timeout=PATIENCE)
            assert presence.close_code == OVER
            assert (await browser.get("/who", Cookie=cookie))[0] == 401
            assert await refused_with(browser.open(Cookie=cookie)) == 401
            await other.find("press Otto")
            assert not other.socket.closed
            assert (await other.get("/who"))[0] == 200

    run(look())


@pytest.mark.parametrize(
    "change",
    [
        lambda users: users.set_disabled("Otto", True),
        lambda users: users.set_role("Otto", Role.VIEWER),
        lambda users: users.set_password("Otto", "another password"),
        lambda users: users.remove("Otto"),
    ],
    ids=["disabled", "role", "password", "removed"],
)
def test_what_another_process_does_to_a_user_cuts(front, users, change):
    async def look():
        async with at_the_page(front, "Otto") as browser, at_the_page(front, "Vera") as other:
            await asyncio.to_thread(change, users)
            assert await browser.close_code() == OVER
            assert (await browser.get("/who"))[0] == 401
            assert (await other.get("/who"))[0] == 200

    run(look())


def test_a_login_that_expires_cuts(users, start):
    front = start(hours=2.0 / 3600)

    async def look():
        async with at_the_page(front, "Otto") as browser:
            cookie = await cookie_of(browser)
            assert await browser.close_code() == OVER
            assert await refused_with(browser.open(Cookie=cookie)) == 401

    run(look())


def test_a_browser_that_never_reads_is_cut_all_the_same(front, scene):
    """And what waits for it does not pile up, here or in viser."""

    async def look():
        async with at_the_page(front, "Otto") as browser:
            browser.socket._conn.transport.pause_reading()
            for number in range(60):
                scene.server.scene.add_image(
                    "/noise", image=noise(number), render_width=1.0, render_height=1.0
                )
                await asyncio.sleep(0.02)
            assert await browser.post("/logout", {}) == 303
            await gone(scene)

    async def gone(scene):
        while scene.server.get_clients():
            await asyncio.sleep(0.02)

    def noise(seed):
        import numpy as np

        return np.random.default_rng(seed).integers(0, 255, (500, 500, 3), dtype=np.uint8)

    run(look())


def test_one_user_cannot_take_all_places(front, said):
    async def look():
        async with raw_browser(front.url) as browser, raw_browser(front.url) as other:
            await browser.log_in("Otto", PASSWORD)
            await other.log_in("Vera", PASSWORD)
            sockets = []
            for _ in range(MOST_OF_ONE):
                await browser.open()
                sockets.append(browser.socket)
            assert await refused_with(browser.open()) == 429
            await other.open()
            for socket in sockets:
                await socket.close()

    run(look())
    said("refused websocket", "too many", '"Otto"')


def test_when_the_front_ends_browsers_are_told_to_come_again(front):
    async def look():
        async with at_the_page(front, "Otto") as browser:
            closing = asyncio.create_task(browser.close_code())
            await asyncio.to_thread(front.close)
            assert await closing == 1012

    run(look())
