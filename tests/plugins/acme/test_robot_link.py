"""The robot link keeps the promises of its seam, on the simulated robot that it brings."""

from acme_cell.robot_link import AcmeLink

import workbench
from workbench.plugins.robot_link import spoken_to_by
from workbench.testing import check_robot_link


def test_it_keeps_its_promises():
    cell = spoken_to_by(workbench.read_cell("yumi"), "acme-json")
    parts = workbench.drop_parts(cell.parts[:1] * 2, cell.bin, seed=1)
    result = workbench.plan(cell, parts, strategy="alternated")
    approval = workbench.approve(cell, result.plan, result.proof, "tester")
    check_robot_link(AcmeLink(), cell, result.plan, approval)
