"""The TX2-90 whose own program asks the pick server."""

import json
import tomllib

import pytest

from workbench.cli.main import main
from workbench.formats.files.shipped import find

FOLDER = find("robots", "tx2_90")


def test_it_is_the_cell_of_the_tx2_90_but_for_its_controller():
    asking, other = (
        tomllib.loads((FOLDER / name).read_text()) for name in ("pick_server.toml", "cell.toml")
    )
    assert asking.pop("controller")["protocol"] == "pick-server"
    assert asking.pop("name") == "tx2_90_pick_server"
    del other["controller"], other["name"]
    assert asking == other


@pytest.mark.extensive
def test_a_demo_places_what_its_program_was_given(tmp_path, capsys):
    cell = str(FOLDER / "pick_server.toml")
    words = ["demo", "--cell", cell, "--sessions", str(tmp_path), "--speed", "50"]
    assert main([*words, "--seed", "1", "--json"]) == 0
    form = json.loads(capsys.readouterr().out)
    assert form["cell"] == "tx2_90_pick_server" and form["ok"]
    (sent,) = (row["result"] for row in form["stages"] if row["stage"] == "send")
    assert "1 of 1 part reported placed" in sent
