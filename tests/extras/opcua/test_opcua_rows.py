"""Several picks after one scan as a PLC of another make reads them, and how it goes on."""

from dataclasses import replace

import pytest
from foreign_opcua import foreign
from prepared_bench import make_row
from waiting import PATIENCE

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import Person, Role
from workbench.app.core.state import Phase
from workbench.extras.opcua.admission import OpcUaOptions
from workbench.extras.opcua.server import OpcUa
from workbench.extras.opcua.values import VARIABLES, values_of
from workbench.gui.cycle.approval import row_of

SEED, PARTS = ["UInt32", 7], ["UInt32", 4]
CYCLE = [SEED, PARTS, ["String", "auto"], ["Double", 0.2]]
ROW = ("Phase", "Plans", "PlansSent", "RowEnds", "MayGoOn")


@pytest.fixture(scope="module")
def results():
    return make_row(picks=4)


@pytest.fixture
def url(site):
    server = OpcUa(site.bench, OpcUaOptions(0, Person("plc", Role.OPERATOR)))
    yield server.url
    server.close()


def call(method, *given):
    return {"what": "call", "method": method, "arguments": given}


def reached(site, phase):
    state = site.bench.wait(lambda one: one.phase is phase and one.job is None, PATIENCE)
    assert state.phase is phase, state.message
    return state


def told(state, site):
    """What a PLC is told in a state of the row, in the order of ROW."""
    values = values_of(state, site.bench.live, site.bench.head)
    return tuple(values[name] for name in ROW)


def planned(site):
    for path, phase in (("/scan", Phase.SCANNED), ("/localize", Phase.LOCALIZED)):
        site.post(path)
        reached(site, phase)
    site.post("/plan", picks=4)
    return reached(site, Phase.PLANNED)


@pytest.mark.extensive
def test_a_row_is_counted_as_it_goes_out(site):
    assert told(site.bench.state, site) == ("idle", 0, 0, "", False)
    state = planned(site)
    plans = len(state.plans)
    assert told(state, site) == ("planned", plans, 0, "no part is left", False)
    row = row_of(state)
    site.bench.do(WatchPlan(state.plan.digest, row=row), "Ada")
    site.bench.do(Approve(state.plan.digest, row=row), "Ada")
    site.post("/send", plan=state.plan.digest)
    done = reached(site, Phase.DONE)
    assert told(done, site) == ("done", plans, plans, "no part is left", True)
    # Who watches sees the newest state alone: what is told meanwhile is asked of such states.
    on_their_way = [replace(one, phase=Phase.SENDING) for one in (state, done)]
    assert [told(one, site)[2] for one in on_their_way] == [1, plans]


@pytest.mark.extensive
def test_a_client_of_another_make_reads_the_row_and_goes_on(site, url):
    state = planned(site)
    before, refused = foreign(url, {"what": "values"}, call("GoOn", *CYCLE))["answers"]
    assert set(before) == set(VARIABLES)
    assert {name: one["type"] for name, one in before.items()} == {
        name: kind.name for name, kind in VARIABLES.items()
    }
    assert before["Plans"]["value"] == len(state.plans) > 1
    assert before["PlansSent"]["value"] == 0
    assert before["RowEnds"]["value"] == "no part is left"
    assert before["MayGoOn"]["value"] is False
    assert refused["status"] == "Good" and refused["said"][0] is False
    row = row_of(state)
    site.bench.do(WatchPlan(state.plan.digest, row=row), "Ada")
    site.bench.do(Approve(state.plan.digest, row=row), "Ada")
    (out,) = foreign(url, call("Send", ["String", state.plan.digest]))["answers"]
    assert out["said"][0] is True
    reached(site, Phase.DONE)
    after, on = foreign(url, {"what": "values"}, call("GoOn", *CYCLE))["answers"]
    assert after["PlansSent"]["value"] == after["Plans"]["value"] == len(state.plans)
    assert after["MayGoOn"]["value"] is True
    assert on["said"][0] is True
    again = reached(site, Phase.PLANNED)
    assert again.approval is None and again.sent_before == ()
    (new,) = foreign(url, {"what": "values"})["answers"]
    assert new["ApprovedBy"]["value"] == "" and new["PlansSent"]["value"] == 0
    (asked,) = [one["command"] for one in site.on_record("GoOn")]
    assert (asked["scan"]["seed"], asked["scan"]["parts"], asked["plan"]["seed"]) == (7, 4, 7)
    assert asked["plan"]["strategy"] == "auto" and asked["plan"]["threshold"] == 0.2
