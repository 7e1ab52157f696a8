"""`workbench serve` as people start it: the link that is printed leads to the page."""

import re
import signal
import subprocess
import sys
import urllib.error
import urllib.request
from http.cookiejar import CookieJar
from pathlib import Path

import pytest

PATIENCE = 120


@pytest.fixture
def serving(tmp_path):
    """The first line that a served page prints; it ends as by Ctrl-C."""
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", "serve", "--port", "0"],
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
