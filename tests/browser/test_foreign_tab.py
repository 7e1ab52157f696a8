"""Tabs of other packages on the page: shown beside ours, and alone in what they break."""

import pytest
from installed_package import Plugged

from workbench.gui.page.server import serve

TABS = """
class Hours:
    title = "Hours"

    def __init__(self, visitor):
        self._text = visitor.gui.add_markdown("nothing yet")

    def show(self, old, new):
        self._text.content = f"the cell is {new.state.cell.name}, in phase {new.state.phase}"


class Falls:
    title = "Falls"

    def __init__(self, visitor):
        raise RuntimeError("no licence for this cell")


class Stumbles(Hours):
    def show(self, old, new):
        raise RuntimeError("later")
"""


@pytest.fixture
def url(bench, tmp_path, monkeypatch):
    plugged = Plugged(tmp_path / "site", monkeypatch)
    names = {"Hours": "Hours", "Falls": "Falls", "Stumbles": "Stumbles", "Gone": "NotThere"}
    plugged.install("maker", TABS, {"workbench.tabs": names})
    page = serve(bench, port=0, most_points=4000)
    yield page.url
    page.close()
    monkeypatch.undo()
    Plugged.forget()


def test_a_tab_of_another_package_works_and_a_broken_one_says_so(screen, reaches):
    screen.tab("Hours")
    screen.wait_for("the cell is yumi, in phase idle")
    screen.tab("Falls")
    screen.wait_for("no licence for this cell")
    screen.tab("Gone")
    screen.wait_for("This tab does not work")
    screen.shoot("foreign-tab")
    screen.tab("Cycle")
    screen.press("Scan")
    reaches("scanned")
    screen.tab("Hours")
    screen.wait_for("in phase scanned")
    assert screen.errors == []
