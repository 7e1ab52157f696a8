"""`workbench serve` as people start it: the link that is printed leads to the page."""

import json
import re
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from contextlib import closing
from http.cookiejar import CookieJar
from pathlib import Path

import pytest
from idle import Idle
from waiting import PATIENCE

from workbench.app.core.commands import UseDetections
from workbench.app.core.people import Role
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.web.access.store import Store
from workbench.web.access.users import Users


@pytest.fixture
def words():
    """More that is typed."""
    return ()


@pytest.fixture
def serving(tmp_path, words):
    """The first line that a served page prints; it ends as by Ctrl-C."""
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", "serve", "--port", "0", *words],
        cwd=tmp_path,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    yield process.stdout.readline()
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=PATIENCE)
    assert process.returncode == 0
    assert "Traceback" not in errors


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

    def test_it_is_where_it_ended(self, serving, token):
        url = re.search(r"http://[^/\s]+", serving)[0]
        request = urllib.request.Request(
            f"{url}/api/v1/state", headers={"Authorization": f"Bearer {token}"}
        )
        with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
            state = json.load(answer)
        assert (state["phase"], state["detections"]) == ("localized", 1)


def test_the_page_waits_for_no_library_of_its_worker():
    code = (
        "import sys, workbench.cli.serving.serve, workbench.gui.page.server\n"
        "print(sorted({'open3d', 'toppra', 'matplotlib', 'mujoco', 'ompl'} & set(sys.modules)))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=PATIENCE, check=True
    )
    assert ended.stdout == "[]\n"
