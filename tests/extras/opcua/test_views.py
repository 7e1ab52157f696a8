"""Views of a scanner on an arm as a PLC reads and chooses them; whose act an acknowledgement is."""

from dataclasses import replace

import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view
from prepared_bench import make_results

from workbench.app.core.cycle.empty_hand import PlanView
from workbench.app.core.people import Role
from workbench.extras.opcua.methods import METHODS
from workbench.extras.opcua.values import values_of
from workbench.model.errors import CommandRefused, NotAllowed


@pytest.fixture(scope="module")
def results():
    return replace(make_results(), cell=with_lower_view(on_arm_cell()))


def test_a_plc_reads_and_chooses_views_by_name(site):
    bench = site.bench
    methods = {method.name: method.make for method in METHODS}

    def values():
        told = values_of(bench.state, bench.live, bench.head)
        return told["View"], told["Views"]

    assert values() == ("bin", "bin, low")
    bench.do(methods["ChooseView"]("low"), "plc")
    assert values() == ("low", "bin, low")
    with pytest.raises(CommandRefused, match="bin, low"):
        bench.do(methods["ChooseView"]("high"), "plc")
    assert methods["PlanView"]("home").view == "home"
    assert isinstance(methods["PlanView"](""), PlanView)


def test_the_role_of_the_login_decides_who_acknowledges_a_fault(site):
    (acknowledge,) = (method.make() for method in METHODS if method.name == "Acknowledge")
    with pytest.raises(NotAllowed):
        site.bench.do(acknowledge, "vic", Role.VIEWER)
    with pytest.raises(CommandRefused, match="no fault"):
        site.bench.do(acknowledge, "plc", Role.OPERATOR)
