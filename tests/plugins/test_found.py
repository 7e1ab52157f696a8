"""Names of installed packages: found, told of when broken, never in the way."""

import json

import pytest

from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import FileError, InputError
from workbench.plugins import found
from workbench.plugins.found import GROUPS, load, names, plugins
from workbench.plugins.planner import planner_named
from workbench.plugins.tool import made_tool

PLANNERS = "workbench.planners"
FUNCTION = "def straight(start, goal, *others, **more):\n    return None, 0\n"


def by_name(name):
    return [one for one in plugins() if one.name == name]


def test_all_that_is_built_in_can_be_loaded():
    assert all(not one.problem for one in plugins() if one.package == "workbench")
    assert {one.group for one in plugins()} == set(GROUPS) - {"workbench.tabs"}
    for group in GROUPS:
        for name in names(group):
            load(group, name)


def test_what_is_meant_without_a_name_has_no_name_of_its_own():
    assert all("default" not in names(group) for group in GROUPS)


def test_a_planner_of_an_installed_package_is_found(plugged):
    plugged.install("acme", FUNCTION, {PLANNERS: {"acme-straight": "straight"}})
    assert "acme-straight" in names(PLANNERS)
    assert planner_named("acme-straight")(None, None) == (None, 0)
    (one,) = by_name("acme-straight")
    assert (one.package, one.version, one.problem) == ("acme", "1.2", "")


def test_a_broken_package_is_told_of_and_stops_nothing_else(plugged):
    plugged.install("ruin", "raise OSError('no licence')\n", {PLANNERS: {"ruin": "x"}})
    (one,) = by_name("ruin")
    assert "OSError: no licence" in one.problem
    assert "rrtconnect" in names(PLANNERS) and load(PLANNERS, "rrtconnect")
    with pytest.raises(InputError, match=r"planner 'ruin' of ruin cannot be loaded.*no licence"):
        load(PLANNERS, "ruin")


def test_a_package_that_ends_the_process_is_told_of_and_ends_nothing(plugged):
    plugged.install("ender", "import sys\nsys.exit(7)\n", {PLANNERS: {"ender": "x"}})
    (one,) = by_name("ender")
    assert "SystemExit: 7" in one.problem
    with pytest.raises(InputError, match=r"planner 'ender' of ender cannot be loaded"):
        load(PLANNERS, "ender")


def test_a_package_that_hangs_is_named_in_the_log(plugged, monkeypatch, caplog):
    plugged.install("sleeper", "import time\ntime.sleep(0.5)\nx = 1\n", {PLANNERS: {"s": "x"}})
    monkeypatch.setattr(found, "SLOW", 0.05)
    assert load(PLANNERS, "s") == 1
    assert "s: importing sleeper takes more than" in caplog.text


def test_a_built_in_name_cannot_be_taken(plugged):
    usual = load(PLANNERS, "rrtconnect")
    plugged.install("thief", FUNCTION, {PLANNERS: {"rrtconnect": "straight"}})
    assert load(PLANNERS, "rrtconnect") is usual
    assert "which is used" in by_name("rrtconnect")[1].problem


def test_a_name_of_two_packages_is_nobody_s(plugged):
    for package in ("one", "two"):
        plugged.install(package, FUNCTION, {PLANNERS: {"straight": "straight"}})
    with pytest.raises(InputError, match="declared by one and two; remove one"):
        load(PLANNERS, "straight")
    assert all("several packages" in one.problem for one in by_name("straight"))


def test_an_unknown_name_is_refused_with_the_known_ones(tmp_path):
    with pytest.raises(InputError, match=r"no planner 'rtt'; known: .*rrtconnect"):
        load(PLANNERS, "rtt")
    shipped = read_cell.__globals__["cell_path"]("tx2_90")
    text = shipped.read_text().replace('protocol = "abb-socket"', 'protocol = "kuka"')
    folder = tmp_path / "cell"
    folder.mkdir()
    for other in shipped.parent.iterdir():
        (folder / other.name).symlink_to(other)
    (folder / "cell.toml").unlink()
    (folder / "cell.toml").write_text(text)
    with pytest.raises(FileError, match=r"controller.protocol: 'kuka' is not one of .*abb-socket"):
        read_cell(folder)


BARE = """
from dataclasses import dataclass
import pinocchio as pin
from workbench.model.cell import Tool

@dataclass
class Nothing:
    pass

class Bare:
    Options = Nothing
    def make(self, name, options):
        return Tool(name, pin.SE3.Identity(), ())
"""


def test_a_kind_of_tool_makes_one_with_a_body_or_fingers(plugged):
    plugged.install("bare", BARE, {"workbench.tools": {"bare": "Bare"}})
    with pytest.raises(InputError, match="'bare' has made a tool without body and fingers"):
        made_tool("bare", "nothing", {})


def test_the_command_lists_ours_and_theirs_and_what_is_broken(plugged, capsys):
    plugged.install("ruin", "raise OSError('no licence')\n", {"workbench.tools": {"claw": "x"}})
    assert main(["plugins", "--json"]) == 0
    told = {
        (one["group"], one["name"]): one for one in json.loads(capsys.readouterr().out)["plugins"]
    }
    assert told["workbench.scanners", "folder"]["problem"] == ""
    assert told["workbench.tools", "claw"]["package"] == "ruin"
    assert "no licence" in told["workbench.tools", "claw"]["problem"]
    assert main(["plugins"]) == 0
    assert "ruin" in capsys.readouterr().out
