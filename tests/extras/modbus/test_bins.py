"""Bins as a PLC numbers them."""

from dataclasses import replace

import pytest
from prepared_bench import results_with_bins

from workbench.app.core.cell.bins import NewBin
from workbench.app.runtime.live import Live
from workbench.extras.modbus.jobs import JOBS
from workbench.extras.modbus.registers import Register, values_of

CHOOSE, NEW = 13, 14


@pytest.fixture(scope="module")
def results():
    return results_with_bins()


def bins_of(state):
    values = values_of(state, Live())
    return values[Register.BIN], values[Register.EMPTY_BINS]


def test_bins_go_by_their_numbers_from_1(site):
    bench = site.bench
    assert bins_of(bench.state) == (1, 0)
    assert bins_of(replace(bench.state, empty_bins=("left", "right"))) == (1, 0b11)
    assert bins_of(replace(bench.state, empty_bins=("left",))) == (1, 0b10)
    bench.do(JOBS[CHOOSE].make(bench.state, 0, 0), "modbus")
    assert bins_of(bench.state) == (2, 0)
    bench.do(JOBS[CHOOSE].make(bench.state, 1, 0), "modbus")
    assert bins_of(bench.state) == (1, 0)
    new = JOBS[NEW].make(bench.state, 2, 0)
    assert isinstance(new, NewBin) and new.name == "left"


def test_numbers_that_no_bin_has_are_wrong_arguments(site):
    state = site.bench.state
    assert [JOBS[NEW].make(state, number, 0) for number in (0, 3)] == [None, None]
    assert JOBS[CHOOSE].make(state, 3, 0) is None
    assert JOBS[CHOOSE].make(replace(state, empty_bins=("left",)), 0, 0) is None


def test_a_scanner_that_stands_has_no_view(site):
    state = site.bench.state
    assert values_of(state, Live())[Register.VIEW] == 0
    assert JOBS[15].make(state, 1, 0) is None
