"""Recipes chosen on the page, in Chromium: what is void, what follows, whoever has chosen."""

from dataclasses import replace

import pytest
from playwright.sync_api import expect

from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.recipes.recipe import Recipe

LEFT = Recipe(4, "left trays", strategy="left", threshold=0.05)
SLOW = Recipe(12, "slow", speed=0.1)
LONG = Recipe(7, "right trays of the second shift, with small cylinders of the new supplier only")


@pytest.fixture
def bench(robot, tmp_path):
    cell = read_cell("yumi")
    controller = robot.controller(cell.controller)
    cell = replace(cell, recipes=(LEFT, SLOW, LONG), controller=controller)
    bench = Bench(cell, Journal(tmp_path / "session"))
    yield bench
    bench.close()


def test_a_recipe_is_chosen_by_number_and_name_and_plans_follow_it(screen, bench, wait, reaches):
    recipe = screen.page.get_by_role("combobox", name="Recipe")
    strategy = screen.page.get_by_role("combobox", name="Strategy")
    expect(recipe).to_have_value("no recipe")
    screen.press("Scan")
    scan = reaches("scanned").scan
    screen.press("Find parts")
    reaches("localized")
    recipe.click()
    screen.page.get_by_role("option", name="4 left trays").click()
    wait(lambda: bench.state.cell.recipe == 4, "the recipe that was chosen")
    state = bench.state
    assert (state.phase, state.detections) == (Phase.SCANNED, None)
    assert state.scan is scan
    screen.wait_for("recipe 4 left trays is chosen")
    expect(strategy).to_have_value("left arm only")
    screen.shoot("recipe-1-chosen")
    screen.press("Find parts")
    reaches("localized")
    screen.press("Plan")
    planned = reaches("planned")
    assert (planned.plan.strategy, planned.planned_threshold) == ("left", 0.05)
    assert planned.plan.cell_digest == planned.cell.digest

    screen.tab("Cell")
    expect(screen.button("Save")).to_be_disabled()
    screen.tab("Cycle")
    bench.do(ChooseRecipe(0), "ada")
    expect(recipe).to_have_value("no recipe")
    expect(strategy).to_have_value("auto")
    assert [one for one in screen.errors if "favicon" not in one] == []


def test_a_list_shows_the_whole_of_long_names(screen):
    screen.page.get_by_role("combobox", name="Recipe").click()
    option = screen.page.get_by_role("option", name=f"7 {LONG.name}")
    option.wait_for()
    screen.shoot("recipe-2-long")
    inside, window = option.bounding_box(), screen.page.viewport_size
    assert option.evaluate("one => one.scrollWidth <= one.clientWidth")
    assert inside["x"] >= 0 and inside["x"] + inside["width"] <= window["width"]
