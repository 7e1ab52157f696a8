"""When a websocket ends: with the login, with the front, and when there are too many."""

import asyncio
import time

import pytest
from attackers import PASSWORD, at_the_page, cookie_of, refused_with, run
from waiting import PATIENCE

from workbench.app.core.people import Role
from workbench.studies.load.raw_browser import raw_browser
from workbench.web.access.store import Store
from workbench.web.page.connections import MOST_OF_ONE, OVER


def test_logging_out_cuts_all_windows_of_the_browser(front):
    async def look():
        async with at_the_page(front, "Otto") as browser, at_the_page(front, "Otto") as other:
            cookie = await cookie_of(browser)
            presence = await browser.session.ws_connect(
                f"{front.url}/presence", headers={"Origin": front.url, "Cookie": cookie}
            )
            assert await browser.post("/logout", {}) == 303
            assert await browser.close_code() == OVER
            while not presence.closed:  # what the bar says comes before
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


def test_a_login_that_expires_cuts(users, start, file):
    front = start(hours=3.0)

    def let_expire() -> None:
        store = Store(file)
        with store.change() as connection:
            ((until,),) = connection.execute("SELECT expires_at FROM sessions").fetchall()
            assert 2 * 3600 < until - time.time() <= 3 * 3600
            connection.execute("UPDATE sessions SET expires_at = ?", (time.time() - 1,))
        store.close()

    async def look():
        async with at_the_page(front, "Otto") as browser:
            cookie = await cookie_of(browser)
            await asyncio.to_thread(let_expire)
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
            browser.socket._conn.transport.abort()  # or it would wait for an answer that it ignores

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
