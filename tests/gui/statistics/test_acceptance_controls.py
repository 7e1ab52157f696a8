"""The acceptance record of a session as a file, where the extra that writes it is there."""

import sys

import pytest

from workbench.gui.statistics.acceptance import ACCEPTANCE_FILE, AcceptanceControls


@pytest.fixture
def saved(visitor, view_of, states):
    """Presses the button, and returns what was downloaded."""
    files = []
    visitor.client.send_file_download = lambda name, content: files.append((name, content))
    controls = AcceptanceControls(visitor)
    controls.show(view_of(states.planned))

    def press():
        visitor.attempt(controls._save)
        return files

    return press


def test_the_record_names_the_session_up_to_its_last_entry(saved, bench):
    ((name, content),) = saved()
    number, head = bench.head
    assert name == ACCEPTANCE_FILE
    assert f"{bench.folder.name}, {number} entries, head {head}" in content.decode()


def test_where_the_extra_is_missing_the_page_names_it(saved, visitor, monkeypatch):
    for module in [name for name in sys.modules if name.startswith("workbench.extras.evidence")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "workbench.extras.evidence", None)
    assert saved() == []
    assert "workbench.extras.evidence" in visitor.client.told[0]
