"""`workbench serve` as people start it: the link that is printed leads to the page."""

import json
import re
import signal
import sqlite3
import subprocess
import sys
import time
import urllib.error
import urllib.request
from contextlib import closing, contextmanager
from http.cookiejar import CookieJar
from pathlib import Path

import pytest
from idle import Idle
from waiting import PATIENCE

from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.people import Role
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.web.access.store import Store
from workbench.web.access.users import Users


@pytest.fixture
def words():
    """More that is typed."""
    return ()


@contextmanager
def serve(folder, *words):
    """A served page; it ends as by Ctrl-C, if it has not ended before."""
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", "serve", "--port", "0", *words],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        yield process
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            _, errors = process.communicate(timeout=PATIENCE)
            assert process.returncode == 0
            assert "Traceback" not in errors
    finally:
        process.kill()
        process.communicate()


def entries_of(folder):
    with closing(Journal(Path(folder))) as journal:
        return journal.count


@pytest.fixture
def serving(tmp_path, words):
    """The first line that a served page prints; it ends as by Ctrl-C."""
    with serve(tmp_path, *words) as process:
        yield process.stdout.readline()


def test_the_link_that_is_printed_leads_to_the_page(serving, tmp_path):
    link = re.search(r"http://\S+", serving)[0]
    url = link.partition("/first")[0]
    browser = urllib.request.build_opener(urllib.request.HTTPCookieProcessor(CookieJar()))
    with browser.open(url, timeout=PATIENCE) as answer:
        assert "There are no users yet" in answer.read().decode()
    with browser.open(link, timeout=PATIENCE) as answer:
        assert answer.status == 200
    with browser.open(url, timeout=PATIENCE) as answer:
        assert "Cell yumi" in answer.read().decode()
    with browser.open(f"{url}/scene/", timeout=PATIENCE) as answer:
        assert b"Viser" in answer.read()
    with pytest.raises(urllib.error.HTTPError, match="401"):
        urllib.request.urlopen(link, timeout=PATIENCE)
    file = Path(tmp_path / "sessions" / "users.sqlite")
    assert file.stat().st_mode & 0o077 == 0


class TestASessionThatGoesOn:
    @pytest.fixture
    def token(self, tmp_path):
        """Of a user who looks."""
        (tmp_path / "sessions").mkdir()
        with closing(Store(tmp_path / "sessions" / "users.sqlite")) as store:
            users = Users(store)
            users.add("Vic", Role.VIEWER, "only to look at")
            return users.make_token("Vic", "test")

    @pytest.fixture
    def words(self, tmp_path, token):
        cell = read_cell("yumi")
        journal = new_session(tmp_path / "sessions", cell, time.time())
        bench = Bench(cell, journal, effects=Idle)
        at = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.03))
        bench.do(UseDetections((Detection("keyed_cylinder", at),)), "Anna")
        bench.close()
        return ("--session", str(journal.folder))

    @pytest.mark.extensive
    def test_it_is_where_it_ended(self, serving, token):
        url = re.search(r"http://[^/\s]+", serving)[0]
        request = urllib.request.Request(
            f"{url}/api/v1/state", headers={"Authorization": f"Bearer {token}"}
        )
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            state = json.load(answer)
        assert (state["phase"], state["detections"]) == ("localized", 1)

    @pytest.mark.extensive
    def test_is_only_looked_at_where_another_program_writes_to_it(self, serving, words, tmp_path):
        before = entries_of(words[1])
        with serve(tmp_path, *words) as second:
            says, page = second.stdout.readline(), second.stdout.readline()
            assert re.search(r"is written to by process \d+ on .* since 20", says)
            assert "to look at only" in page
        assert entries_of(words[1]) == before

    @pytest.mark.extensive
    @pytest.mark.parametrize(
        "tampering",
        [
            "DELETE FROM entries WHERE number = (SELECT max(number) FROM entries)",
            "UPDATE entries SET hash = 'f' WHERE number = 2",
            "DELETE FROM entries",
        ],
    )
    def test_is_not_gone_on_with_when_it_was_changed(self, words, tmp_path, tampering):
        with closing(sqlite3.connect(Path(words[1]) / "journal.sqlite")) as database:
            database.executescript(
                "PRAGMA foreign_keys = OFF; DROP TRIGGER entries_stay; DROP TRIGGER entries_remain;"
                + tampering
            )
        with serve(tmp_path, *words) as refused:
            assert refused.wait(PATIENCE) == 1
            says = refused.stderr.read()
            assert "nothing is added to a session that was changed" in says
        with serve(tmp_path, "--after", words[1]) as follower:
            folder = [follower.stdout.readline() for _ in range(3)][2].split()[1]
            with closing(Journal(tmp_path / folder)) as journal:
                follows = json.loads(next(journal.entries()).body)["follows"]
        assert follows["session"] == Path(words[1]).name
        assert follows["problems"]


def test_the_page_waits_for_no_library_of_its_worker():
    code = (
        "import sys, workbench.cli.serving.serve, workbench.gui.page.server\n"
        "print(sorted({'open3d', 'toppra', 'matplotlib', 'mujoco', 'ompl'} & set(sys.modules)))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE, check=True
    )
    assert ended.stdout == "[]\n"
