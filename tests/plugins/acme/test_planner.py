"""The planner keeps the promises of its seam."""

from acme_cell.planner import vias

from workbench.testing import check_planner


def test_it_keeps_its_promises():
    check_planner(vias)
