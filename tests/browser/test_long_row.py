"""A row of many plans in the dialog of a low window: the vote stays in view, in Chromium."""

from dataclasses import replace

import numpy as np
import pytest
from playwright.sync_api import expect

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import NOBODY
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.gui.cycle.approval import row_of
from workbench.model.plan import Proven
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize

PLANS = 8


@pytest.fixture
def planned(bench):
    """A row as long as eight plans; each is the first one anew, since nothing is sent here."""
    cell = read_cell("yumi")
    detections = drop_parts(cell.parts[:1] * 2, cell.bin, seed=0)
    scan = synthesize(cell, detections, seed=0)
    result = plan_pick(cell, detections, scan.digest, seed=0)
    plans = [replace(result.plan, seed=number) for number in range(PLANS)]
    row = [
        Proven(plan, replace(result.proof, plan_digest=plan.digest, clearance=bound))
        for plan, bound in zip(plans, np.linspace(0.009, 0.006, PLANS), strict=True)
    ]
    made = replace(result, plan=row[0].plan, proof=row[0].proof, row=tuple(row[1:]))
    bench.do(UseScan(scan), "Ada")
    bench.do(JobEnded(bench.do(FindParts(), "Ada").number, detections), "worker")
    state = bench.do(JobEnded(bench.do(MakePlan(), "Ada").number, made), "worker")
    return bench.do(WatchPlan(state.plan.digest, row=row_of(state)), NOBODY)


def is_scrolled(facts):
    return facts.evaluate("one => one.scrollTop + one.clientHeight >= one.scrollHeight - 1")


def test_all_plans_are_read_by_scrolling_while_the_vote_stays_in_view(screen, bench, planned):
    assert len(planned.plans) == PLANS
    screen.press("Approve")
    dialog = screen.page.get_by_role("dialog")
    word = screen.button("Type your name to approve")
    word.wait_for()
    screen.shoot("long-row-top")
    facts = dialog.locator(".wb-read")
    assert facts.evaluate("one => one.scrollHeight > one.clientHeight + 50")
    assert not is_scrolled(facts)
    first, last = dialog.get_by_text("Plan 1", exact=True), dialog.get_by_text("Certificates")
    expect(first).to_be_in_viewport()
    expect(last).not_to_be_in_viewport()
    for button in (word, screen.button("Back")):
        expect(button).to_be_in_viewport(ratio=1)
    # By keys as well: what scrolls can be reached.
    facts.focus()
    screen.page.keyboard.press("End")
    expect(last).to_be_in_viewport(ratio=1)
    expect(dialog.get_by_text(f"plan {PLANS}: at least 6.0 mm")).to_be_visible()
    for button in (word, screen.button("Back")):
        expect(button).to_be_in_viewport(ratio=1)
    screen.shoot("long-row-end")
    dialog.locator("input").first.press_sequentially("Ada", delay=100)
    screen.press("Approve as Ada")
    state = bench.wait(lambda state: state.approval is not None, 600)
    assert len(state.approval.row) == PLANS - 1
    screen.tab("Plan")
    screen.wait_for(f"{PLANS} plans in a row")
    screen.shoot("long-row-plan-tab")
    assert screen.errors == []
