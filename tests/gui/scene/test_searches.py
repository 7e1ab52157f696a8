"""Searches side by side: which one is looked at is steered by who is in control."""

import pytest

from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.people import Person, Role
from workbench.gui.scene.searches import SearchInputs


@pytest.fixture
def inputs(visitor, bench, scan, detections):
    bench.do(UseScan(scan), "Ada")
    bench.do(JobEnded(bench.do(FindParts(), "Ada").number, detections), "worker")
    return SearchInputs(visitor)


def test_a_search_that_is_clicked_is_looked_at(inputs, visitor, bench):
    inputs._choose(0)
    assert visitor.look.now.search == bench.state.searches[0].number
    assert visitor.look.now.searcher == visitor.number


def test_who_may_not_choose_is_told_why(inputs, visitor, bench):
    bench.do(TakeControl(), "Ada")
    visitor.person = Person("Bob", Role.OPERATOR)
    inputs._choose(0)
    assert visitor.look.now.search is None
    assert visitor.client.told == ["Ada is in control; ask for control first"]
