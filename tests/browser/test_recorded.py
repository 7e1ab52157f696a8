"""A recorded session in Chromium: it never looks live, and its events can be jumped to."""

import shutil
from pathlib import Path

import pytest
from playwright.sync_api import expect

from workbench.app.review.history import History
from workbench.gui.page.server import serve
from workbench.journal.journal import Journal

EXAMPLE = Path(__file__).resolve().parents[2] / "sessions" / "example"


@pytest.fixture
def url(history):
    page = serve(history, port=0, most_points=4000)
    yield page.url
    page.close()


@pytest.fixture
def history(tmp_path):
    # A copy, since whoever opens a journal writes beside it.
    journal = Journal(shutil.copytree(EXAMPLE, tmp_path / "example"))
    yield History(journal)
    journal.close()


def test_a_recording_is_framed_its_buttons_are_grey_and_its_events_can_be_jumped_to(
    screen, history, wait
):
    rows = screen.page.locator(".wb-events tbody tr")
    rows.first.wait_for()
    screen.page.locator('.wb-mode[data-mode="recorded"]').wait_for()
    expect(screen.page.locator(".wb-status-recorded")).to_have_count(1)
    expect(screen.page.locator(".wb-status-busy")).to_have_count(0)
    frame = "getComputedStyle(document.body, '::after').borderTopWidth"
    assert screen.page.evaluate(frame) == "4px"
    # All messages of the sending are one row.
    assert rows.count() < 25 < history.count
    sent = rows.filter(has_text="essage").filter(has_text="(")
    expect(sent).to_have_count(1)
    screen.shoot("recorded")
    rows.filter(has_text="An approval").click()
    wait(lambda: history.state.phase == "approved", "the moment of the approval")
    # Play is pressed in what is seen: the page has to have come there too.
    expect(screen.page.locator(".wb-status").first).to_contain_text("approved by demo")
    screen.tab("Cycle")
    for name in ("Scan", "Find parts", "Plan", "Approve", "Send", "Stop"):
        expect(screen.button(name)).to_be_disabled()
    expect(screen.page.get_by_text("Take control")).to_have_count(0)
    expect(screen.page.get_by_text("in control")).to_have_count(0)
    screen.tab("Plan")
    screen.press("Play")
    screen.button("Pause").wait_for()
    assert screen.errors == []
