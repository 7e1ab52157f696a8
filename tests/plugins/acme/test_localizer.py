"""The localizer keeps the promises of its seam."""

from acme_cell.localizer import Twice

import workbench
from workbench.testing import check_localizer


def test_it_keeps_its_promises():
    check_localizer(Twice, workbench.read_cell("yumi"), parts=2)
