"""A planned cycle on a page, and hands on the controls of browsers that sit there."""

from contextlib import ExitStack

import numpy as np
import pytest
from raw_browser import sitting
from waiting import wait_until

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.gui.cell.panel import CellPanel
from workbench.gui.page.header import Header
from workbench.gui.page.server import serve


@pytest.fixture
def planned(bench, scan, detections, result):
    bench.do(UseScan(scan), "Anna")
    number = bench.do(FindParts(), "Anna").number
    bench.do(JobEnded(number, detections), "worker")
    number = bench.do(MakePlan(), "Anna").number
    bench.do(JobEnded(number, result), "worker")
    return bench


@pytest.fixture
def page(planned):
    page = serve(planned, port=0, most_points=100)
    yield page
    page.close()


class Hands:
    """On the controls of one browser that sits there."""

    def __init__(self, page, browser, number):
        self.renderer, self.browser, self.number = page._renderer, browser, number

    @property
    def visitor(self):
        return self.renderer._visitors[self.number]

    def panel(self, kind):
        return next(one for one in self.renderer._panels[self.number] if isinstance(one, kind))

    def play(self):
        self.panel(Header).transport._play.press()

    def jog(self):
        self.panel(CellPanel)._jog._turn()

    @property
    def is_jogged(self):
        return self.visitor.own.now.jog is not None

    @property
    def link(self):
        """Where the robot's last link is in this browser alone, None: where all see it."""
        arm = self.renderer._bench.state.cell.arms[0]
        node = self.visitor.client.scene.get_handle_by_name(f"/planned/{arm.flange}")
        return None if node is None else np.array(node.position)


@pytest.fixture
def sit_down(page):
    """Opens browsers that draw, with hands on their controls."""
    with ExitStack() as stack:

        def sit():
            before = set(page._renderer._panels)
            browser = stack.enter_context(sitting(int(page.url.rpartition(":")[2])))
            wait_until(lambda: set(page._renderer._panels) - before, "the controls")
            (number,) = set(page._renderer._panels) - before
            return Hands(page, browser, number)

        yield sit
