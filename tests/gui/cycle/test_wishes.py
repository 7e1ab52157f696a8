"""The inputs for one planning begin with what the cell wants, installed here or not."""

from dataclasses import replace

from workbench.gui.cycle.overrides import OverridesInputs


def test_they_begin_as_the_cell_has_it(visitor, cell):
    overrides = OverridesInputs(visitor.client.gui, cell.policy).overrides
    assert overrides.on(cell.policy) == cell.policy


def test_a_planner_that_is_not_installed_does_not_break_the_page(visitor, cell):
    policy = replace(cell.policy, planner="foreign")
    assert OverridesInputs(visitor.client.gui, policy).overrides.planner == "foreign"
