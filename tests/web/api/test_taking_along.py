"""What an engineer takes along from the page, and who gets nothing of it."""

import io
import logging
import shutil
import time
import urllib.error
import urllib.request
import zipfile
from contextlib import closing
from logging.handlers import RotatingFileHandler
from pathlib import Path

import pytest

from workbench.app.records.session_archive import import_session
from workbench.app.records.sessions import new_session
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.web.api.taking_along import taking_along

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture
def home(tmp_path):
    """A working directory with a cell and a part."""
    for name in ("robots/tx2_90", "parts/puck"):
        shutil.copytree(ROOT / name, tmp_path / "home" / name)
    return tmp_path / "home"


@pytest.fixture
def front(home, users, start):
    session = new_session(home / "sessions", read_cell("tx2_90"), time.time())
    yield start(taking_along(session.folder, home))
    session.close()


def asked(front, path, token=None):
    """Status and body of an answer to a program that shows a token."""
    headers = {} if token is None else {"Authorization": f"Bearer {token}"}
    try:
        with urllib.request.urlopen(
            urllib.request.Request(front.url + path, headers=headers)
        ) as answer:
            return answer.status, answer.read()
    except urllib.error.HTTPError as error:
        return error.code, error.read()


@pytest.mark.parametrize("path", ["/session.zip", "/backup.zip"])
def test_only_engineers_get_a_file(front, users, path):
    assert asked(front, path)[0] == 401
    status, body = asked(front, path, users.make_token("Otto", "line"))
    assert status == 403 and b"for engineers; you are" in body
    assert asked(front, path, users.make_token("Edda", "line"))[0] == 200


def test_the_session_can_be_taken_in_elsewhere_with_the_log_beside_it(front, users, tmp_path):
    handler = RotatingFileHandler(tmp_path / "log.jsonl")
    logging.getLogger().addHandler(handler)
    try:
        logging.getLogger("workbench.tests").warning("something was odd")
        status, body = asked(front, "/session.zip", users.make_token("Edda", "line"))
    finally:
        logging.getLogger().removeHandler(handler)
        handler.close()
    assert status == 200
    file = tmp_path / "taken.zip"
    file.write_bytes(body)
    with closing(Journal(import_session(file, tmp_path / "elsewhere"))) as journal:
        assert not journal.verify()
        assert journal.count == 1
    assert b"something was odd" in (tmp_path / "elsewhere/taken/log.jsonl").read_bytes()


def test_the_backup_holds_cells_and_parts_and_no_session(front, users, home):
    status, body = asked(front, "/backup.zip", users.make_token("Edda", "line"))
    assert status == 200
    with zipfile.ZipFile(io.BytesIO(body)) as archive:
        names = archive.namelist()
        assert archive.read("parts/puck/part.toml") == (home / "parts/puck/part.toml").read_bytes()
    assert "robots/tx2_90/cell.toml" in names and "backup.json" in names
    assert not [name for name in names if name.startswith(("sessions/", "users"))]


def test_an_engineer_gets_a_case_that_the_session_has_kept_and_no_other_file(front, users, home):
    (session,) = (home / "sessions").glob("*tx2_90*")
    (session / "cases").mkdir()
    name = "20231114-221320-tx2_90-3.zip"
    (session / "cases" / name).write_bytes(b"a case")
    (session / "cases" / "notes.txt").write_text("mine")
    edda = users.make_token("Edda", "line")
    assert asked(front, f"/cases/{name}", edda) == (200, b"a case")
    assert asked(front, f"/cases/{name}")[0] == 401
    status, body = asked(front, f"/cases/{name}", users.make_token("Otto", "line"))
    assert status == 403 and b"for engineers; you are" in body
    for other in ("notes.txt", name.replace("3.zip", "4.zip"), "..%2Fjournal.sqlite"):
        status, body = asked(front, f"/cases/{other}", edda)
        assert status == 404 and b"no case of this name" in body


def test_without_cells_and_parts_it_says_so(users, start, tmp_path):
    front = start(taking_along(tmp_path / "none", tmp_path))
    token = users.make_token("Edda", "line")
    status, body = asked(front, "/backup.zip", token)
    assert status >= 400 and b"neither cells" in body
