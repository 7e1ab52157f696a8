"""What is built in keeps the promises that others are asked to keep."""

import pytest
from waiting import lasting

import workbench
from workbench.plugins.found import load, names
from workbench.plugins.planner import planner_named, planner_names
from workbench.plugins.robot_link import link_named, spoken_to_by
from workbench.testing import (
    check_localizer,
    check_planner,
    check_robot_link,
    check_scanner,
    check_tool,
)


@pytest.mark.parametrize("name", planner_names())
def test_planners(name):
    check_planner(planner_named(name))


@pytest.mark.parametrize("name", names("workbench.tools"))
def test_tools(name):
    check_tool(load("workbench.tools", name))


def test_the_simulated_scanner():
    check_scanner(load("workbench.scanners", "simulated"), workbench.read_cell("yumi"))


@pytest.mark.parametrize("name", names("workbench.localizers"))
def test_localizers(name):
    check_localizer(load("workbench.localizers", name), workbench.read_cell("yumi"))


OF_OTHERS = {"abb-egm", "ur-rtde", "ur-rtde-blend", "ur-rtde-servo"}
"""They need libraries, and robots or options of their own: their tests in tests/devices do this."""


OF_ONE_ARM = {"pick-server": "tx2_90"}
"""A link that moves one arm alone, and a cell that has one."""


@pytest.mark.timeout(1800)
@pytest.mark.parametrize("name", sorted({*names("workbench.robot_links")} - OF_OTHERS))
def test_robot_links(name):
    cell = spoken_to_by(workbench.read_cell(OF_ONE_ARM.get(name, "yumi")), name)
    parts = workbench.drop_parts(cell.parts[:1] * 2, cell.bin, seed=1)
    result = workbench.plan(cell, parts, strategy="auto" if len(cell.arms) == 1 else "alternated")
    approval = lasting(workbench.approve(cell, result.plan, result.proof, "tester"))
    check_robot_link(link_named(name), cell, result.plan, approval)


def test_a_planner_that_goes_through_the_wall_is_caught():
    def reckless(start, goal, *others, iterations, rng):
        return [start, goal], 0

    from workbench.plugins.planner import Search

    with pytest.raises(AssertionError, match="through the wall"):
        check_planner(lambda *given, **more: Search(*reckless(*given, **more)))


def test_a_planner_that_swallows_the_deadline_is_caught():
    usual = planner_named("rrtconnect")

    def deaf(start, goal, lower, upper, weights, is_clear, *, iterations, rng):
        def careful(a, b):
            try:
                return is_clear(a, b)
            except Exception:
                return False

        return usual(
            start, goal, lower, upper, weights, careful, iterations=min(iterations, 3000), rng=rng
        )

    with pytest.raises(AssertionError, match="was swallowed"):
        check_planner(deaf)
