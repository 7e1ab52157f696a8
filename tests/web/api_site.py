"""The HTTP interface of a bench on loopback; who asks is told by a token."""

import asyncio
import json
import sqlite3
import threading
from collections.abc import Generator, Iterator, Mapping
from contextlib import closing, contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import pytest
import requests
from aiohttp import web
from prepared_bench import Canned, Results, make_results
from waiting import PATIENCE

from workbench.app.core.people import Person, Role
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.web.api.routes import api_routes

PEOPLE = {
    "Bearer ada": Person("Ada", Role.ENGINEER),
    "Bearer bob": Person("Bob", Role.OPERATOR),
    "Bearer vic": Person("Vic", Role.VIEWER),
}


@dataclass
class Site:
    """Where the interface is, and one person's hands on it; `effects` where they are canned."""

    bench: Bench
    effects: Any
    url: str
    session: requests.Session
    folder: Path

    def get(self, path: str, who: str = "ada", **about):
        return self.session.get(self.url + path, headers=self.token(who), timeout=PATIENCE, **about)

    def post(self, path: str, who: str = "ada", **body):
        return self.session.post(
            self.url + path, json=body, headers=self.token(who), timeout=PATIENCE
        )

    def token(self, who: str) -> dict[str, str]:
        return {"Authorization": f"Bearer {who}"} if who else {}

    def stand(self, off: float) -> None:
        """The controller reports joints so far [rad] from where plans start."""
        arms = self.bench.state.cell.arms
        homes = {j: q + off for arm in arms for j, q in zip(arm.joints, arm.home, strict=True)}
        self.effects.live = replace(self.effects.live, joints=homes)

    def on_record(self, kind: str) -> list[dict[str, Any]]:
        """What the journal holds of a command, in its order."""
        path = self.folder / "journal.sqlite"
        with closing(sqlite3.connect(path)) as connection:
            rows = connection.execute("SELECT body FROM entries WHERE kind = ?", (kind,)).fetchall()
        return [json.loads(body) for (body,) in rows]

    def reach(self, phase: str) -> None:
        state = self.bench.wait(lambda state: state.phase == phase and not state.job, PATIENCE)
        assert state.phase == phase, state.message


@pytest.fixture(scope="session")
def results() -> Results:
    return make_results()


@pytest.fixture
def people() -> dict[str, Person]:
    """Whose each token is; one that is taken out is nobody's any more."""
    return dict(PEOPLE)


@pytest.fixture
def heartbeat() -> float:
    return 10.0


async def _ended(runner: web.AppRunner) -> None:
    await runner.cleanup()
    # A stream notices that nobody listens any more when it next has something to say.
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)


@pytest.fixture
def site(results, people, heartbeat, tmp_path) -> Iterator[Site]:
    made: list[Canned] = []

    def effects(cell, do, now):
        made.append(Canned(results, do))
        return made[0]

    bench = Bench(results.cell, Journal(tmp_path / "session"), effects=effects)
    with serve_site(bench, people, heartbeat) as (url, session):
        yield Site(bench, made[0], url, session, tmp_path / "session")
    bench.close()


@contextmanager
def serve_site(
    bench: Bench, people: Mapping[str, Person] = PEOPLE, heartbeat: float = 10.0
) -> Generator[tuple[str, requests.Session]]:
    """The address of a bench's interface on loopback, and a client, as long as the block runs."""

    async def identify(request: web.Request) -> Person | None:
        return people.get(request.headers.get("Authorization", ""))

    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    app = web.Application()
    app.add_routes(api_routes(bench, identify, heartbeat=heartbeat))
    runner = web.AppRunner(app, shutdown_timeout=1.0)

    async def serve() -> int:
        await runner.setup()
        await web.TCPSite(runner, "127.0.0.1", 0).start()
        return runner.addresses[0][1]

    port = asyncio.run_coroutine_threadsafe(serve(), loop).result(PATIENCE)
    with requests.Session() as session:
        yield f"http://127.0.0.1:{port}/api/v1", session
    asyncio.run_coroutine_threadsafe(_ended(runner), loop).result(PATIENCE)
    loop.call_soon_threadsafe(loop.stop)
    thread.join()
    loop.close()
