"""The inputs for one planning begin with what the cell wants, installed here or not."""

from dataclasses import replace

from workbench.gui.cycle.wishes import WishesInputs


def test_they_begin_as_the_cell_has_it(visitor, cell):
    wishes = WishesInputs(visitor.client.gui, cell.policy).wishes
    assert wishes.on(cell.policy) == cell.policy


def test_a_planner_that_is_not_installed_does_not_break_the_page(visitor, cell):
    policy = replace(cell.policy, planner="foreign")
    assert WishesInputs(visitor.client.gui, policy).wishes.planner == "foreign"
