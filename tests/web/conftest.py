"""A front before a real viser with a few widgets, a file of users, and raw browsers."""

import asyncio
import logging
import subprocess
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from argon2 import PasswordHasher
from attackers import PASSWORD, SECRET
from waiting import PATIENCE

from workbench.app.core.people import Person, Role
from workbench.gui.shared.viser_server import close_viser, open_viser, person_of
from workbench.web.access import passwords
from workbench.web.access.passwords import hash_of
from workbench.web.access.store import Store
from workbench.web.access.users import Users
from workbench.web.http.listening import TlsCertificate
from workbench.web.page.relay import Upstream
from workbench.web.server import Front, ServerOptions, serve_front


@dataclass
class Scene:
    """A guarded viser; each browser gets widgets of its own, what they do is kept."""

    url: str
    people: list[Person] = field(default_factory=list)
    presses: list[str] = field(default_factory=list)
    numbers: list[float] = field(default_factory=list)
    files: list[tuple[str, int]] = field(default_factory=list)
    buttons: dict[str, object] = field(default_factory=dict)
    moved: list[tuple[float, ...]] = field(default_factory=list)
    something: threading.Condition = field(default_factory=threading.Condition)

    def note(self, where: list, what: object) -> None:
        with self.something:
            where.append(what)
            self.something.notify_all()

    def wait(self, condition: Callable[[], bool]) -> None:
        with self.something:
            assert self.something.wait_for(condition, PATIENCE)


@pytest.fixture
def scene() -> Iterator[Scene]:
    server = open_viser("127.0.0.1", 0, SECRET)
    scene = Scene(f"http://127.0.0.1:{server.get_port()}")
    scene.server = server

    @server.on_client_connect
    def _(client) -> None:
        person = person_of(client)
        # All at once: what is done before somebody listens would be lost.
        with client.atomic():
            press = client.gui.add_button(f"press {person.name}")
            number = client.gui.add_number("number", 0.0)
            upload = client.gui.add_upload_button("file")
            gizmo = client.scene.add_transform_controls("/gizmo")
            press.on_click(lambda _: scene.note(scene.presses, person.name))
            number.on_update(lambda _: scene.note(scene.numbers, number.value))
            upload.on_upload(
                lambda _: scene.note(scene.files, (upload.value.name, len(upload.value.content)))
            )
            gizmo.on_update(lambda _: scene.note(scene.moved, tuple(gizmo.position)))
        scene.buttons[person.name] = press
        scene.note(scene.people, person)

    yield scene
    close_viser(server)


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "state" / "users.sqlite"


@pytest.fixture(scope="module", autouse=True)
def patient() -> Iterator[None]:
    """What is waited for by the clock waits as long as tests do."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("workbench.web.server.START_SECONDS", PATIENCE)
        patch.setattr("workbench.web.server.END_SECONDS", PATIENCE)
        yield


@pytest.fixture(scope="module", autouse=True)
def quick_to_try() -> Iterator[None]:
    """Trying a password takes 0.1 s and 64 MiB by design, and some hundred are tried here."""
    with pytest.MonkeyPatch.context() as patch:
        quick = PasswordHasher(time_cost=1, memory_cost=8, parallelism=1)
        patch.setattr(passwords, "_HASHER", quick)
        yield


@pytest.fixture(scope="module")
def kept() -> str:
    """The password's hash."""
    return hash_of(PASSWORD)


@pytest.fixture
def users(file: Path, kept: str, monkeypatch: pytest.MonkeyPatch) -> Iterator[Users]:
    """Vera who looks, Otto who works, Edda who builds; all with the same password."""
    monkeypatch.setattr("workbench.web.access.users.hash_of", lambda password: kept)
    store = Store(file)
    users = Users(store)
    for name, role in (
        ("Vera", Role.VIEWER),
        ("Otto", Role.OPERATOR),
        ("Edda", Role.ENGINEER),
    ):
        users.add(name, role, PASSWORD)
    yield users
    store.close()


@pytest.fixture
def start(scene: Scene, file: Path) -> Iterator[Callable[..., Front]]:
    """Starts a front; it ends with the test."""
    fronts = []

    def one(routes=(), **options) -> Front:
        upstream = Upstream(scene.url, SECRET)
        chosen = ServerOptions(**{"port": 0, **options})
        fronts.append(serve_front(upstream, file, chosen, title="Cell tested", routes=routes))
        return fronts[-1]

    yield one
    for front in fronts:
        front.close()


@pytest.fixture
def front(users: Users, start: Callable[..., Front]) -> Front:
    return start()


@pytest.fixture(scope="session")
def certificate(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tls")
    made = TlsCertificate(folder / "page.pem", folder / "page.key")
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256"),
            *("-nodes", "-days", "2", "-subj", "/CN=workbench of a test"),
            *("-addext", "subjectAltName=IP:127.0.0.1,DNS:localhost"),
            *("-keyout", str(made.key), "-out", str(made.certificate)),
        ],
        check=True,
        capture_output=True,
        timeout=PATIENCE,
    )
    return made


@pytest.fixture
def said(caplog: pytest.LogCaptureFixture) -> Callable[..., None]:
    """Waits until a refusal stands in the log, with all of these words."""
    caplog.set_level(logging.INFO, logger="workbench.web")

    def stands(*words: str) -> None:
        async def look() -> None:
            while not any(all(word in line for word in words) for line in caplog.messages):
                await asyncio.sleep(0.01)

        try:
            asyncio.run(asyncio.wait_for(look(), PATIENCE))
        except TimeoutError:
            raise AssertionError(f"{words} not in {caplog.messages}") from None

    return stands
