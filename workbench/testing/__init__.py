"""What makers of plug-ins run: each check is one promise of a seam, in plain `assert`s.

    from workbench.testing import check_planner

    def test_my_planner_keeps_its_promises():
        check_planner(my_planner)

Imports the seams, the values and the simulated world.
"""

from workbench.testing.localizers import check_localizer
from workbench.testing.options import check_options
from workbench.testing.planners import check_planner
from workbench.testing.robot_links import check_robot_link
from workbench.testing.scanners import check_scanner
from workbench.testing.tools import check_tool

__all__ = [
    "check_localizer",
    "check_options",
    "check_planner",
    "check_robot_link",
    "check_scanner",
    "check_tool",
]
