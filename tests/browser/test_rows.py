"""Several picks after one scan, in Chromium, with a controller in a process of its own."""

import functools
import re
from dataclasses import replace

import pytest
from hands import field, typed
from patient import PATIENT
from playwright.sync_api import expect
from test_page import approve, watch

from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.state import Phase
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal

SEED = 6
"""Of a pile of four cylinders that lie apart: two plans take them all."""


@pytest.fixture
def bench(robot, tmp_path):
    """The YuMi whose parts are taken away at once, with 10 mm between those of one heap."""
    cell = read_cell("yumi")
    arms = tuple(replace(arm, passes_parts_on=True) for arm in cell.arms)
    policy = replace(cell.policy, pair_gap=0.01, picks=3)
    controller = robot.controller(cell.controller)
    cell = replace(cell, arms=arms, policy=policy, controller=controller)
    effects = functools.partial(EffectRunner, patience=PATIENT)
    bench = Bench(cell, Journal(tmp_path / "session"), effects=effects)
    yield bench
    bench.close()


# The film waits for each drawing, which the processor makes here.
@pytest.mark.timeout(1200)
def test_a_row_is_watched_approved_and_sent_and_gone_on_with(
    screen, bench, robot, reaches, wait, tmp_path
):
    expect(field(screen, "Picks")).to_have_value("3")
    typed(screen, "Parts", 4)
    typed(screen, "Seed", SEED)
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    screen.press("Plan")
    first = reaches("planned")
    assert len(first.plans) == 2
    screen.wait_for("2 picks in a row; no part is left")
    screen.shoot("r1-planned")
    table = screen.page.locator(".wb-plans:visible").first
    widths = table.evaluate(
        "one => [one, one.closest('.wb-span3').parentElement.parentElement]"
        ".map(box => box.getBoundingClientRect().width)"
    )
    assert widths[0] > 0.85 * widths[1], "it has all columns of its group"

    screen.press("Leave out last")
    screen.wait_for("1 pick in a row, 1 left out")
    assert len(bench.state.plans) == 1
    screen.shoot("r2-shortened")
    screen.press("Bring back")
    screen.wait_for("2 picks in a row; no part is left")
    assert bench.state.plans == first.plans

    watch(screen, bench, wait)
    assert bench.state.watched == ("operator",) and not bench.state.watched_elsewhere
    screen.press("Approve")
    screen.page.get_by_role("dialog").get_by_text("Plan 2", exact=True).wait_for()
    screen.shoot("r3-approval")
    screen.press("Back")
    approve(screen, "Anna")
    approval = reaches("approved").approval
    assert [digest for digest, _ in approval.row] == [first.plans[1].digest]

    screen.press("Send")
    wait(lambda: len(bench.state.sent_before) == 1, "the second plan to follow")
    screen.shoot("r4-second-plan")
    done = reaches("done")
    assert done.parts_placed == 4
    assert sorted(one.detection for one in done.outcomes if one.is_picked) == [0, 1, 2, 3]
    screen.wait_for("4 of 4 parts reported placed")
    for word in ("picked", "failed"):
        said = screen.page.get_by_role("button", name=re.compile(f"^(Left|Right) {word}$"))
        expect(said).to_have_count(4)
    screen.wait_for("part-4 picked")
    screen.shoot("r5-done")

    screen.press("Next cycle")
    again = bench.wait(lambda state: state.phase is Phase.PLANNED and state.job is None, 600)
    assert again.plan is not None and again.plan is not first.plan
    assert again.sent_before == () and again.approval is None
    screen.wait_for("in a row")
    expect(screen.button("Send")).to_be_disabled()
    bench.close()
    sent = [
        entry.command.plan_digest
        for entry, _ in replay(Journal(tmp_path / "session"), bench.cell)
        if isinstance(entry.command, SendPlan)
    ]
    assert sent == [first.plan.digest], "one press for the whole row"
    assert [one for one in screen.errors if not re.search("favicon", one)] == []
