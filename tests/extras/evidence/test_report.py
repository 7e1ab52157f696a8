"""What people read of a session: everything that counts, and nothing that a browser would run."""

import re
import shutil
import subprocess
from contextlib import closing
from html.parser import HTMLParser
from pathlib import Path

import pytest

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of
from workbench.extras.evidence.bundle import moments_of
from workbench.extras.evidence.pages import COLUMNS, _lines, html_page, pdf_pages
from workbench.extras.evidence.report import ReportTable, tables_of
from workbench.extras.evidence.signing import time_stamp_request
from workbench.journal.journal import Journal
from workbench.model.scan import Scan

ROOT = Path(__file__).resolve().parents[3]
TAGS = set(re.findall(r"\w+", "html head meta title style body h1 h2 p table tr th td"))
EVIL = ReportTable("<script>x</script>", "<img src=x>", ("<b>", "x"), (("<a href=x>", "1" * 3000),))


class Tags(HTMLParser):
    """Which tags a page has."""

    def __init__(self, page):
        super().__init__()
        self.found = set()
        self.feed(page.decode())

    def handle_starttag(self, tag, attrs):
        self.found.add(tag)


@pytest.fixture(scope="module")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("session") / "example"
    shutil.copytree(ROOT / "sessions" / "example", folder)
    with closing(Journal(folder)) as journal:
        moments = list(replay(journal, cell_of(journal)))
        return tables_of({"session": "example"}, moments, "")


def test_the_report_tells_who_when_what_was_shown_proven_sent_and_heard(tables):
    titles = [table.title for table in tables]
    assert titles == [
        "Session",
        "What ran",
        "Who acted",
        "Sending 1",
        "Interventions and faults",
        "Log",
    ]
    told = {row[0]: row[1] for row in tables[3].rows}
    assert "holds" in told["proof"] and "5.9 mm" in told["proof"]
    assert "told by a program" in told["shown"]
    assert "by demo (engineer)" in told["approved"]
    assert "no page has shown it" in told["approval"]
    assert told["messages"].startswith("72 in ")
    assert "2 of 2 parts reported placed" in told["the robot said"]
    report, _ = tables[4].rows
    assert report[2:4] == ("Ada", "ReportPick")
    assert len(tables[5].rows) == 84 - 72
    assert [row[3] for row in tables[5].rows if row[3].startswith("JobEnded")] == [
        "JobEnded (scan)",
        "JobEnded (parts)",
        "JobEnded (plan)",
    ]
    assert told["plan"].endswith(": 2 parts, strategy alternated, one-at-a-time")
    load = "tool 0.23 kg, centre of gravity 8, 12, 52 mm from the flange; with the part 0.35 kg, "
    assert told["load, left arm"].startswith(load)


def test_what_a_printed_row_says_goes_on_under_itself_and_long_names_push_nothing_off_the_page():
    long = ReportTable("Log", "", ("who", "says"), (("Anna", "word " * 60), ("n" * 64, "x" * 300)))
    lines = [line for line, _ in _lines("Evidence", [long])]
    assert all(len(line) <= COLUMNS for line in lines)
    row = next(place for place, line in enumerate(lines) if line.startswith("Anna"))
    begins = lines[row].index("word")
    assert lines[row + 1][:begins].isspace() and lines[row + 1][begins:].startswith("word")


def test_a_page_runs_and_fetches_nothing_whatever_a_session_holds(tables):
    page = html_page("<script>", [*tables, EVIL])
    assert Tags(page).found <= TAGS
    assert b"default-src 'none'" in page


@pytest.mark.extensive
def test_the_printed_report_is_the_same_each_time_and_breaks_no_line_off(tables):
    pages = pdf_pages("Evidence", [*tables, EVIL])
    assert pages.startswith(b"%PDF-")
    assert pages == pdf_pages("Evidence", [*tables, EVIL])
    long = ReportTable("Log", "", (), tuple(("$x$ ж é", str(number)) for number in range(400)))
    assert pdf_pages("Evidence", [long]).count(b"/Type /Page ") == 5


@pytest.mark.skipif(shutil.which("openssl") is None, reason="openssl is not installed")
def test_a_time_stamp_request_is_one_to_openssl_too(tmp_path):
    (tmp_path / "content").write_bytes(b"content")
    (tmp_path / "asked.tsq").write_bytes(time_stamp_request(b"content"))
    said = subprocess.run(
        ["openssl", "ts", "-query", "-in", "asked.tsq", "-text"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    assert "Hash Algorithm: sha256" in said
    assert "Certificate required: yes" in said
    assert "ed 70 02 b4 39 e9 ac 84-5f 22 35 7d 82 2b ac 14" in said


def test_the_report_needs_no_points_of_scans_which_would_fill_the_memory(tmp_path):
    shutil.copytree(ROOT / "sessions" / "example", tmp_path / "example")
    with closing(Journal(tmp_path / "example")) as journal:
        whole = list(replay(journal, cell_of(journal)))
        kept, broke = moments_of(journal, journal.count)
    assert broke == "" and len(kept) == len(whole)
    assert tables_of({}, kept) == tables_of({}, whole)
    results = [entry.command.result for entry, _ in kept if isinstance(entry.command, JobEnded)]
    scans = [result for result in results if isinstance(result, Scan)]
    assert scans and all(len(scan.points) == 1 for scan in scans)
    assert all(state.scan is None for _, state in kept)
