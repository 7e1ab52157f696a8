"""Views of a scanner on an arm as a PLC numbers them."""

from dataclasses import replace

import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view
from prepared_bench import make_results

from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.runtime.live import Live
from workbench.extras.modbus.jobs import JOBS
from workbench.extras.modbus.registers import Register, values_of
from workbench.model.robot import HOME

CHOOSE, THERE, BACK = 15, 16, 17


@pytest.fixture(scope="module")
def results():
    return replace(make_results(), cell=with_lower_view(on_arm_cell()))


def test_views_go_by_their_numbers_from_1(site):
    bench = site.bench
    assert values_of(bench.state, Live())[Register.VIEW] == 1
    bench.do(JOBS[CHOOSE].make(bench.state, 2, 0), "modbus")
    assert values_of(bench.state, Live())[Register.VIEW] == 2
    assert [JOBS[CHOOSE].make(bench.state, number, 0) for number in (0, 3)] == [None, None]
    there, back = (JOBS[number].make(bench.state, 0, 0) for number in (THERE, BACK))
    assert isinstance(there, PlanView) and isinstance(back, PlanView)
    assert (there.view, back.view) == ("", HOME)
