"""The gripper keeps the promises of its seam."""

from acme_cell.tool import Pincer

from workbench.testing import check_tool


def test_it_keeps_its_promises():
    small, large = (check_tool(Pincer, {"size": size}) for size in ("small", "large"))
    assert small.stroke < large.stroke
