"""Measures the page over a slow line: `PYTHONPATH=.:tests/web python tests/web/slow_page.py`.

Tells how much a first load brings and how long it takes, without a screen: what a browser asks
for, six requests side by side, with a password that is there at once or typed for `TYPED` seconds,
in which two connections fetch ahead; then how long a command and a stop take to arrive while the
page is drawn anew all the time, and how much of what is drawn waits between scene and browser.
"""

import asyncio
import re
import socket
import statistics
import sys
import tempfile
import threading
import time
from pathlib import Path

from slow_line import Line, slow_line

import workbench.web.server as server
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.people import Role
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.gui.page.server import serve
from workbench.studies.load.raw_browser import RawBrowser, raw_browser
from workbench.web.access.identity import identify
from workbench.web.access.store import Store
from workbench.web.access.users import Users
from workbench.web.api.routes import api_routes
from workbench.web.page.bar import bar_of
from workbench.web.page.relay import Upstream

SECRET, PASSWORD = "a secret of this start", "correct horse battery"
STOPS = 60
TYPED = 8.0


def main() -> None:
    """Measure on a line as asked for: bits a second, seconds each way, share lost."""
    rate, delay, loss = (float(word) for word in (sys.argv[1:4] or ("1e6", "0.1", "0.02")))
    folder = Path(tempfile.mkdtemp())
    store = Store(folder / "users.sqlite")
    Users(store).add("Edda", Role.ENGINEER, PASSWORD)
    store.close()
    cell = read_cell("yumi")
    bench = Bench(cell, new_session(folder, cell, time.time()))
    commands = (TakeScan(0, 2), FindParts(0), MakePlan(threshold=cell.policy.threshold, seed=0))
    for command in commands:
        bench.do(command, "Edda")
        state = bench.wait(lambda state: state.job is None, 600)
        print(state.message, flush=True)
    page = serve(bench, port=0, secret=SECRET)
    stops: list[float] = []

    def stop(person: object) -> str:
        stops.append(time.monotonic())
        return ""

    with slow_line(rate, delay, loss) as line:
        server.listen = lambda host, port: line.bound
        front = server.serve_front(
            Upstream(page.url, SECRET),
            folder / "users.sqlite",
            server.ServerOptions(),
            title="slow",
            routes=api_routes(bench, identify),
            bar=bar_of(bench),
            stop=stop,
        )
        try:
            if "bbr" in sys.argv:
                line.bound.setsockopt(socket.IPPROTO_TCP, socket.TCP_CONGESTION, b"bbr")
            for typed in (0.0, TYPED) * 3:
                print(asyncio.run(first_load(line, typed)), flush=True)
            print(asyncio.run(used(line.url, stops)), flush=True)
        finally:
            front.close()
            page.close()
            bench.close()


async def first_load(line: Line, typed: float) -> str:
    """What a browser asks for from the address to the first widgets, and how long that takes.

    The password is typed for that long [s].  What has not come to its end by then comes again.
    """
    began, carried, url = time.monotonic(), line.carried(), line.url
    async with raw_browser(url) as browser:
        form = await fetched(browser, "/login")
        await asyncio.gather(*(fetched(browser, f"/static/login.{one}") for one in ("css", "js")))
        form_at = time.monotonic()
        waiting = re.search(r'data-pieces="(.*?)"', form)[1].split()  # type: ignore[index]
        kept: set[str] = set()

        async def ahead() -> None:
            while waiting:
                piece = waiting.pop(0)
                await fetched(browser, piece)
                kept.add(piece)

        fetching = [asyncio.create_task(ahead()) for _ in range(2)]
        await asyncio.sleep(typed)
        typed_at = time.monotonic()
        assert await browser.log_in("Edda", PASSWORD) == 303
        await fetched(browser, "/")
        for task in fetching:
            task.cancel()
        await asyncio.gather(*fetching, return_exceptions=True)
        in_at = time.monotonic()
        shell = ("shell.css", "shell.js", "tour.css", "tour.js", "logo.svg")
        files = (fetched(browser, f"/static/{name}") for name in shell)
        *_, text = await asyncio.gather(*files, fetched(browser, "/scene/"))
        pieces = re.findall(r'"(/scene/pieces/\w+)"', text)
        await asyncio.gather(*(fetched(browser, path) for path in pieces if path not in kept))
        page_at, page = time.monotonic(), line.carried() - carried
        await browser.open()
        await browser.find("Scan")
        widgets_at = time.monotonic()
        return (
            f"typed {typed:g} s, {len(kept)} of {len(pieces)} pieces fetched ahead; "
            f"{page / 1e3:.0f} kB of page, {(line.carried() - carried - page) / 1e3:.0f} kB of "
            f"scene; form {form_at - began:.1f} s, logged in {in_at - typed_at:.1f} s, page "
            f"{page_at - in_at:.1f} s, scene and widgets {widgets_at - page_at:.1f} s; without "
            f"typing {widgets_at - began - typed:.1f} s"
        )


async def fetched(browser: RawBrowser, path: str) -> str:
    """An answer, packed on its way."""
    _, text = await browser.get(path, **{"Accept-Encoding": "gzip"})
    return text


async def used(url: str, stops: list[float]) -> str:
    """Commands and stops while the plan is scrubbed; what waits on its way."""
    async with raw_browser(url) as browser:
        await browser.log_in("Edda", PASSWORD)
        await browser.open()
        await browser.find_enabled("Time [s]")
        presence = await browser.session.ws_connect(url + "/presence", headers={"Origin": url})
        reading = asyncio.create_task(browser.close_code())
        hearing = asyncio.create_task(_heard(presence))
        taken: dict[str, list[float]] = {"presence": [], "request": [], "either": []}
        for number in range(STOPS):
            for step in range(10):
                await browser.set("Time [s]", round((number * 10 + step) % 100 * 0.05, 2))
                await asyncio.sleep(1 / 20)
            began, seen = time.monotonic(), len(stops)
            await presence.send_str("stop")
            asked = asyncio.create_task(_asked(browser, began))
            while len(stops) == seen and time.monotonic() < began + 10:
                await asyncio.sleep(0.005)
            taken["presence"].append(stops[-1] - began)
            taken["request"].append(await asked)
            taken["either"].append(min(taken["presence"][-1], taken["request"][-1]))
        for task in (reading, hearing):
            task.cancel()
        await asyncio.gather(reading, hearing, return_exceptions=True)
    lines = [f"{STOPS} stops, to the server (request: there and half the way back taken off)"]
    for name, all_of_them in taken.items():
        ordered = sorted(all_of_them)
        lines.append(
            f"  {name}: median {statistics.median(ordered):.3f} s, 95 % within "
            f"{ordered[int(0.95 * (len(ordered) - 1))]:.3f} s, longest {ordered[-1]:.3f} s, "
            f"within 0.5 s: {sum(one <= 0.5 for one in ordered)}"
        )
    return "\n".join(lines)


async def _asked(browser: RawBrowser, began: float) -> float:
    async with browser.session.post(
        browser.url + "/api/v1/stop", headers={"Origin": browser.url}
    ) as answer:
        await answer.read()
    return time.monotonic() - began - 0.1


async def _heard(presence: object) -> None:
    async for _ in presence:  # type: ignore[attr-defined]
        pass


if __name__ == "__main__":
    threading.excepthook = lambda about: None
    main()
