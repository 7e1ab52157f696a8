"""A cell with two bins on the page, in Chromium: both are seen, and one is chosen."""

from dataclasses import replace

import pytest
from playwright.sync_api import expect

from workbench.app.core.cell.bins import ChooseBin
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal


@pytest.fixture
def bench(robot, tmp_path):
    cell = read_cell(find("robots", "yumi") / "two_bins.toml")
    cell = replace(cell, controller=robot.controller(cell.controller))
    bench = Bench(cell, Journal(tmp_path / "session"))
    yield bench
    bench.close()


@pytest.mark.extensive
def test_a_bin_is_chosen_and_parts_are_taken_from_it(screen, bench, wait, reaches):
    chosen = screen.page.get_by_role("combobox", name="Bin", exact=True)
    expect(chosen).to_have_value("right")
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    chosen.click()
    screen.page.get_by_role("option", name="left").click()
    wait(lambda: bench.state.cell.bin.name == "left", "the bin that was chosen")
    assert (bench.state.phase, bench.state.scan) == (Phase.IDLE, None)
    screen.wait_for("parts are taken from bin left")
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    found = reaches("localized").detections
    T_bin_world = bench.state.cell.bin.T_world_bin.inverse()
    assert found and all(abs(T_bin_world.act(d.T_world_part.translation)[1]) < 0.07 for d in found)
    screen.press("Plan")
    reaches("planned")
    screen.shoot("bins-1-planned")
    bench.do(ChooseBin("right"), "ada")
    expect(chosen).to_have_value("right")
    bench.do(TakeScan(3, 0), "ada")
    reaches("scanned")
    screen.press("Find parts")
    wait(lambda: bench.state.empty_bins == ("right",), "a bin that is empty")
    screen.wait_for("Nothing left to take: right.")
    screen.shoot("bins-2-empty")
    screen.press("Bin right is new")
    wait(lambda: bench.state.empty_bins == (), "a bin that is new")
    screen.wait_for("bin right is new")
    assert [one for one in screen.errors if "favicon" not in one] == []
