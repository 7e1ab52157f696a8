"""What the tour hears: the steps of a pick that were really done, and whom it is for."""

from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.app.core.people import NOBODY, Person, Role
from workbench.app.core.state import Phase, State
from workbench.formats.cells.reading import read_cell
from workbench.model.release import LinkStatus
from workbench.web.page.bar import bar_words
from workbench.web.page.tour import TOUR_STEPS, tour_of

OTTO, VERA = Person("Otto", Role.OPERATOR), Person("Vera", Role.VIEWER)


@pytest.fixture(scope="module")
def idle():
    return State(read_cell("yumi"))


def done(state):
    return "".join(step[:2] for step in tour_of(state, OTTO))


def test_a_step_is_done_when_the_bench_says_so(idle):
    found = replace(idle, phase=Phase.LOCALIZED, detections=(SimpleNamespace(),))
    holds, fails = SimpleNamespace(holds=True), SimpleNamespace(holds=False)
    planned = replace(found, phase=Phase.PLANNED, proof=holds)
    assert done(idle) == ""
    assert done(replace(idle, phase=Phase.SCANNED)) == "sc"
    assert done(replace(found, detections=())) == "sc"
    assert done(found) == done(replace(planned, proof=fails)) == "scfi"
    assert done(planned) == done(replace(planned, watched=("Vera",))) == "scfipl"
    assert done(replace(planned, watched=("Otto",))) == "scfiplpr"
    assert done(replace(planned, watched=(NOBODY,))) == "scfiplpr"
    for phase in (Phase.APPROVED, Phase.SENDING):
        assert done(replace(planned, phase=phase)) == "scfiplprap"
    assert tour_of(replace(planned, phase=Phase.DONE), OTTO) == TOUR_STEPS
    assert done(replace(planned, phase=Phase.FAULT, fault="the link broke")) == ""


def test_it_is_for_those_who_may_send_in_a_cell_where_nothing_is_real(idle):
    cell = idle.cell
    real_robot = replace(cell, controller=replace(cell.controller, host="192.168.125.1"))
    real_scanner = replace(cell, scanner=replace(cell.scanner, source="folder"))
    for state in (State(real_robot), State(real_scanner)):
        assert tour_of(state, OTTO) is None
    assert tour_of(idle, VERA) is None
    assert bar_words(idle, SimpleNamespace(robot="", link=LinkStatus()), OTTO)["tour"] == ()
