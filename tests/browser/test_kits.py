"""A kit filled on the page, in Chromium: what it has is seen, and a new one is begun."""

from dataclasses import replace

import pytest
from playwright.sync_api import expect
from test_page import approve, run_to_plan, seen

from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.recipes.kit import KitItem
from workbench.model.recipes.recipe import Recipe

PAIR = Recipe(4, "pairs", items=(KitItem("keyed_cylinder", 2),))


@pytest.fixture
def bench(robot, tmp_path):
    cell = read_cell("yumi")
    cell = replace(cell, recipes=(PAIR,), controller=robot.controller(cell.controller))
    bench = Bench(cell, Journal(tmp_path / "session"))
    yield bench
    bench.close()


def test_a_kit_is_filled_and_a_new_one_begun(screen, bench, reaches, wait):
    screen.page.get_by_role("combobox", name="Recipe").click()
    screen.page.get_by_role("option", name="4 pairs").click()
    screen.wait_for("Kit: 0 of 2 keyed_cylinder")
    expect(screen.button("New kit")).to_be_disabled()
    run_to_plan(screen, reaches)
    seen(bench)
    approve(screen, "Ada")
    reaches("approved")
    screen.press("Send")
    reaches("done")
    screen.wait_for("the kit is complete; take it away and begin a new kit")
    screen.shoot("kit-complete")
    screen.press("New kit")
    wait(lambda: bench.state.kit.complete == 1, "the new kit")
    screen.wait_for("Kit: 0 of 2 keyed_cylinder; 1 kit complete, 0 incomplete before it")
    screen.tab("Statistics")
    screen.wait_for("Kits by recipe 4")
    assert [error for error in screen.errors if "favicon" not in error] == []
