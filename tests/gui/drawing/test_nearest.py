"""A click on the place where a plan comes nearest to something shows it, to whoever approves."""

import re
from contextlib import nullcontext
from dataclasses import replace
from types import SimpleNamespace

import pytest

from workbench.app.core.control import TakeControl
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.people import Person, Role
from workbench.app.picking.facts import nearest_place
from workbench.app.runtime.live import Live
from workbench.gui.drawing.nearest import PlanLinks, proof_html
from workbench.gui.shared.look import View
from workbench.gui.shared.playback import timeline
from workbench.model.messages.message import plain
from workbench.model.plan import Proven, Violation


def test_who_is_not_in_control_but_approves_sees_it(visitor, bench, scan, detections, result):
    bench.do(UseScan(scan), "Ada")
    bench.do(JobEnded(bench.do(FindParts(), "Ada").number, detections), "worker")
    bench.do(JobEnded(bench.do(MakePlan(), "Ada").number, result), "worker")
    bench.do(TakeControl(), "Ada")
    visitor.person = Person("Bob", Role.OPERATOR)
    visitor.client.camera = SimpleNamespace()
    visitor.client.atomic = nullcontext
    end = result.plan.cycle_seconds
    visitor.look._look.change(candidate=0, time=end)
    PlanLinks(visitor)._go()
    look = visitor.look.now
    near = result.proof.nearest
    (run,) = [
        one for one in timeline(result.plan) if (one.arm, one.leg.name) == (near.arm, near.leg)
    ]
    spot = nearest_place(bench.state.cell, result.plan, result.proof)
    assert look.time == visitor.own.now.visited.time == run.start + spot.seconds < end
    assert look.candidate is None and not look.follows


@pytest.fixture
def links(visitor, row, monkeypatch):
    """What a row's facts do at a click, with what was saved."""
    monkeypatch.setattr(type(visitor.bench), "state", property(lambda _: row))
    visitor.client.camera = SimpleNamespace()
    visitor.client.atomic = nullcontext
    links = PlanLinks(visitor)
    saved = links.saved = []
    visitor.client.send_file_download = lambda name, content, **_: saved.append(name)
    return links


def test_of_a_row_the_place_is_that_of_the_plan_that_comes_nearest(links, visitor, row):
    links._go()
    second = row.whole_row[1]
    near = second.proof.nearest
    (run,) = [
        one
        for one in timeline(*row.plans)
        if (one.plan, one.arm, one.leg.name) == (1, near.arm, near.leg)
    ]
    spot = nearest_place(row.cell, second.plan, second.proof)
    assert visitor.look.now.time == run.start + spot.seconds > row.plan.cycle_seconds
    assert visitor.own.now.visited.says == "at least 2.1 mm"
    view = View(row, Live(), visitor.look.now, timeline(*row.plans), 0.0, own=visitor.own.now)
    assert view.visited is visitor.own.now.visited, "a mark of the second plan is drawn, too"


def test_each_plan_of_a_row_has_a_certificate_of_its_own(links, row):
    made = proof_html(row, links)
    for number in range(1, 4):
        assert re.search(rf'role="button"[^>]*>plan {number}</span>', made)
    for number in range(4):
        links._save(number)
    assert links.saved == [f"certificate-{plan.digest[:12]}.json" for plan in row.plans]


def test_a_proof_that_does_not_hold_is_told_in_place_of_facts(links, row, states):
    violation = Violation(plain("too close"), "right", "reach")
    bad = Proven(row.plan, replace(row.proof, violations=(violation,)))
    state = replace(row, proof=bad.proof)
    assert "plan 1: The proof does not hold" in proof_html(state, links)
    alone = replace(states.planned, proof=bad.proof)
    assert "The proof does not hold: arm right" in proof_html(alone, links)
