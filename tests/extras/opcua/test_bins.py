"""Bins as a PLC reads, chooses and reports them."""

from dataclasses import replace

import pytest
from prepared_bench import results_with_bins

from workbench.extras.opcua.methods import METHODS
from workbench.extras.opcua.values import values_of


@pytest.fixture(scope="module")
def results():
    return results_with_bins()


def test_a_plc_reads_chooses_and_reports_bins_by_name(site):
    bench = site.bench
    methods = {method.name: method.make for method in METHODS}

    def values(state):
        told = values_of(state, bench.live, bench.head)
        return told["Bin"], told["Bins"], told["EmptyBins"]

    assert values(bench.state) == ("right", "right, left", "")
    assert values(replace(bench.state, empty_bins=("left", "right")))[2] == "right, left"
    bench.do(methods["ChooseBin"]("left"), "plc")
    assert values(bench.state)[0] == "left"
    bench.do(methods["NewBin"]("left"), "plc")
    assert str(bench.state.message) == "bin left is new"
