"""The whole line by clicking, in a real browser, with a robot controller spoken to over TCP."""

import math
import re
from functools import partial

import numpy as np
import pytest
from hands import field, pause, settle, slider_of, watch
from playwright.sync_api import expect

from workbench.app.core.cycle.planning import WantThreshold
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import NOBODY
from workbench.gui.cycle import threshold
from workbench.gui.scene.slider_drag import SliderDrag
from workbench.gui.shared.tables import CandidateOrder, order_candidates
from workbench.journal.journal import Journal

MARKED = """() => {
  const row = document.querySelector(".wb-table tbody tr:nth-child(3)");
  return row && getComputedStyle(row).backgroundColor !== "rgba(0, 0, 0, 0)";
}"""


def run_to_plan(screen, reaches):
    """Scan, find parts and plan, by clicking."""
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    screen.press("Plan")
    return reaches("planned")


def seen(bench) -> None:
    """The plan was played to its end, in some other browser."""
    bench.do(WatchPlan(bench.state.plan.digest), NOBODY)


def approve(screen, name: str) -> None:
    """Approve in the dialog, as a person of that name."""
    screen.press("Approve")
    dialog = screen.page.get_by_role("dialog")
    field = dialog.locator("input").first
    field.wait_for()
    field.press_sequentially(name, delay=100)
    screen.press(f"Approve as {name}")


def test_a_cycle_by_clicking_sends_exactly_the_approved_plan(screen, bench, robot, reaches, wait):
    screen.shoot("1-idle")
    state = run_to_plan(screen, reaches)
    assert len(state.detections) == 2
    assert state.proof.holds
    screen.wait_for("plan ready")
    screen.wait_for("The plan has not been played to its end; play it first.")
    expect(screen.button("Approve")).to_be_disabled()
    screen.shoot("2-planned")

    screen.tab("Candidates")
    screen.page.locator(".wb-table tbody tr").first.wait_for()
    screen.page.locator(".wb-table tbody tr").nth(2).click()
    screen.page.wait_for_function(MARKED)
    screen.shoot("3-candidates")

    screen.tab("Plan")
    screen.press("Play")
    screen.button("Pause").wait_for()
    screen.page.locator('.wb-mode[data-mode="preview"]').wait_for()
    screen.shoot("4-playing")
    wait(lambda: bench.state.watched, "the end of the plan")
    screen.page.locator('.wb-mode[data-mode="end"]').wait_for()
    expect(screen.page.locator(".wb-mode").first).to_contain_text("nothing was sent")

    screen.tab("Cycle")
    screen.press("Approve")
    dialog = screen.page.get_by_role("dialog")
    dialog.locator(".wb-facts").first.wait_for()
    shown = dialog.inner_text()
    assert state.plan.digest[:12] in shown
    # Never more than there is.
    assert f"{math.floor(state.proof.clearance * 1e4) / 10:.1f} mm" in shown
    assert all(arm.grasp in shown for arm in state.plan.arms)
    dialog.locator("input").first.press_sequentially("Anna", delay=100)
    screen.button("Approve as Anna").wait_for()
    screen.shoot("5-approval")
    screen.press("Approve as Anna")
    assert reaches("approved").approval.actor == "Anna"
    assert robot.configurations == [], "nothing may arrive before it is sent"

    screen.press("Send")
    screen.page.locator('.wb-mode[data-mode="moving"]').wait_for()
    wait(lambda: len(bench.state.receipts) > 20, "messages on the wire")
    screen.shoot("6-sending")
    done = reaches("done")
    assert done.parts_placed == 2
    screen.wait_for("2 of 2 parts reported placed")
    screen.page.locator('.wb-mode[data-mode="live"]').wait_for()
    for text in ("part-1 picked", "part-2 picked"):
        screen.wait_for(text)
    screen.tab("Robot")
    for text in ("protocol abb-socket/2", "not a safety function"):
        screen.wait_for(text)
    screen.shoot("7-done")
    screen.tab("Cycle")
    field(screen, "Why it failed").press_sequentially("slipped", delay=100)
    screen.press("Left failed")
    wait(lambda: any(not one.is_picked for one in bench.state.outcomes), "the word on a part")
    assert sorted(one.is_picked for one in bench.state.outcomes) == [False, True]
    screen.wait_for("failed: slipped")
    screen.shoot("7b-outcomes")
    screen.tab("Parts")
    screen.wait_for("for 3 more scans")
    screen.shoot("7c-avoided")
    screen.press("Avoid no more")
    wait(lambda: not bench.state.avoided, "nothing avoided")

    expected = [
        (arm, q)
        for step in state.plan.sequence
        for arm, leg in step.runs
        for q in np.asarray(state.plan.arm(arm).leg(leg).q)[1:]
    ]
    arrived = robot.configurations
    assert [line["arm"] for line in arrived] == [arm for arm, _ in expected]
    np.testing.assert_allclose(
        [line["q"] for line in arrived], [q for _, q in expected], atol=np.deg2rad(0.0051)
    )
    assert screen.errors == []


@pytest.mark.extensive
def test_going_on_after_a_cycle_stops_at_the_approval(screen, bench, robot, reaches, wait):
    run_to_plan(screen, reaches)
    expect(screen.button("Next cycle")).to_be_disabled()
    seen(bench)
    approve(screen, "Anna")
    reaches("approved")
    screen.press("Send")
    done = reaches("done")
    told = len(robot.configurations)
    screen.press("Next cycle")
    wait(lambda: bench.state.phase == "planned" and bench.state.job is None, "the next plan")
    screen.wait_for("The plan has not been played to its end; play it first.")
    expect(screen.button("Next cycle")).to_be_disabled()
    expect(screen.button("Approve")).to_be_disabled()
    expect(field(screen, "Seed")).to_have_value("1")
    state = bench.state
    assert state.plan.scan_digest != done.plan.scan_digest
    assert (state.approval, state.watched) == (None, ())
    assert len(robot.configurations) == told, "nothing was sent"
    watch(screen, bench, wait)
    approve(screen, "Anna")
    assert reaches("approved").approval.plan_digest == state.plan.digest
    assert screen.errors == []


@pytest.mark.extensive
def test_a_browser_that_comes_back_sees_the_same_state(screen, bench, reaches):
    screen.press("Scan")
    reaches("scanned")
    screen.page.locator('.wb-strip[data-phase="scanned"]').wait_for()
    points = f"{len(bench.state.scan.points):,} points"
    screen.wait_for(points)

    screen.page.reload()
    screen.page.locator('.wb-strip[data-phase="scanned"]').wait_for()
    screen.wait_for(points)
    expect(screen.button("Find parts")).to_be_enabled()
    expect(screen.button("Plan")).to_be_disabled()


@pytest.mark.extensive
def test_keys_scan_find_plan_and_turn_the_page_dark(screen, reaches):
    keyboard = screen.page.keyboard
    for key, phase in (("n", "scanned"), ("f", "localized"), ("p", "planned")):
        screen.page.mouse.move(200, 400)
        keyboard.press(key)
        state = reaches(phase)
    screen.wait_for("plan ready")
    assert state.approval is None
    keyboard.press("l")
    screen.page.locator(':root[data-mantine-color-scheme="dark"]').wait_for()
    screen.shoot("dark")
    assert screen.errors == []


def test_what_the_rules_would_refuse_cannot_be_pressed(screen, reaches):
    for name in ("Find parts", "Plan", "Approve", "Send", "Stop", "Cancel task"):
        expect(screen.button(name)).to_be_disabled()
    screen.press("Scan")
    reaches("scanned")
    screen.page.locator('.wb-strip[data-phase="scanned"]').wait_for()
    expect(screen.button("Find parts")).to_be_enabled()
    expect(screen.button("Send")).to_be_disabled()


@pytest.mark.extensive
def test_the_threshold_is_said_while_it_is_dragged_and_asked_for_once(
    bench, monkeypatch, open_screen, reaches, tmp_path, wait
):
    drags = []

    def patient(ask):
        # On a busy machine a hand rests that does not mean to.
        drags.append((SliderDrag(ask, rest=1e4), ask.__self__))
        return drags[-1][0]

    monkeypatch.setattr(threshold, "SliderDrag", patient)
    screen = open_screen()
    run_to_plan(screen, reaches)
    other = open_screen()
    bench.do(WantThreshold(0.123), "Otto")
    for each in (screen, other):
        expect(field(each, "Threshold [mm]")).to_have_value("123")
    decides = screen.page.get_by_text(re.compile("^(Both arms at once|One arm after the other)"))
    expect(decides).to_have_text("Both arms at once, if quicker: 1 of 1 pair far apart")
    slider = slider_of(screen, "Threshold [mm]")
    start, mouse = slider.bounding_box(), screen.page.mouse
    x, y = start["x"] + start["width"] / 2, start["y"] + start["height"] / 2
    mouse.move(x, y)
    mouse.down()
    mouse.move(x + 60, y, steps=20)
    expect(decides).to_have_text("One arm after the other: parts 141 mm apart at most")
    screen.shoot("threshold")
    mouse.up()
    settle(screen.page, 100)
    wanted, (drag, told) = int(field(screen, "Threshold [mm]").input_value()), drags[0]
    wait(lambda: round(told.metres * 1000) == wanted, "the last value, told after the hand let go")
    assert bench.state.wanted_threshold == 0.123 and wanted > 141
    drag.finish()
    assert round(bench.state.wanted_threshold * 1000) == wanted
    for each in (screen, other):
        expect(field(each, "Threshold [mm]")).to_have_value(str(wanted))
    bench.close()
    given = [entry.kind for entry in Journal(tmp_path / "session").entries()]
    assert given.count("WantThreshold") == 2
    assert screen.errors == []


@pytest.mark.extensive
def test_a_refusal_is_told_in_the_browser_that_asked(screen, open_screen, bench, reaches):
    run_to_plan(screen, reaches)
    seen(bench)
    other = open_screen()
    screen.press("Approve")
    dialog = screen.page.get_by_role("dialog")
    dialog.locator("input").first.press_sequentially("worker", delay=100)
    screen.press("Approve as worker")
    refusal = screen.page.get_by_text("'worker' is the name of a machine")
    refusal.wait_for()
    screen.shoot("8-refused")
    assert bench.state.approval is None
    expect(other.page.get_by_text("is the name of a machine")).to_have_count(0)


def test_a_new_scan_closes_an_open_approval(screen, bench, reaches):
    run_to_plan(screen, reaches)
    seen(bench)
    screen.press("Approve")
    screen.page.get_by_role("dialog").wait_for()
    bench.do(TakeScan(), "Otto")
    reaches("scanned")
    screen.wait_for("Approval closed")
    screen.page.get_by_role("dialog").wait_for(state="detached")


@pytest.mark.parametrize("speed", [0.1])
def test_a_stop_ends_the_sending_and_waits_for_a_person(screen, bench, robot, reaches, wait):
    run_to_plan(screen, reaches)
    watch(screen, bench, wait)
    approve(screen, "Bo")
    reaches("approved")
    screen.press("Send")
    wait(lambda: bench.live.link.step > 0, "the robot to move")
    screen.tab("Robot")
    screen.wait_for("s ago")
    screen.shoot("8-moving")
    screen.tab("Cycle")
    screen.press("Stop")
    fault = reaches("fault")
    assert "the controller acknowledged the stop after" in str(fault.fault)
    assert fault.parts_placed == 0
    wait(lambda: str(bench.live.robot) == "fault: stopped by the client", "the robot to stand")
    screen.wait_for("Fault:")
    # A busy machine may report late; until it does the page says so.
    expect(screen.page.locator(".wb-mode")).to_contain_text(
        "Solid: the robot, as its controller reports it"
    )
    screen.tab("Robot")
    screen.wait_for("acknowledged the stop after")
    screen.shoot("9-stopped")
    screen.tab("Cycle")
    expect(screen.button("Scan")).to_be_disabled()
    screen.shoot("9-fault")
    screen.press("Acknowledge")
    reaches("idle")
    screen.page.locator('.wb-strip[data-phase="idle"]').wait_for()


@pytest.mark.extensive
def test_a_coordinated_plan_is_played_approved_and_run(screen, bench, robot, reaches):
    screen.page.get_by_label("Seed", exact=True).fill("28")
    screen.press("Scan")
    reaches("scanned")
    screen.press("Find parts")
    reaches("localized")
    screen.page.get_by_role("combobox", name="Strategy").click()
    screen.page.get_by_role("option", name="coordinated").click()
    screen.press("Plan")
    state = reaches("planned")
    assert state.plan.strategy == "coordinated"
    assert state.proof.holds
    screen.tab("Plan")
    screen.press("Play")
    screen.button("Pause").wait_for()
    screen.shoot("10-coordinated")
    screen.tab("Cycle")
    approve(screen, "Cleo")
    reaches("approved")
    screen.press("Send")
    done = reaches("done")
    assert [part.is_picked for part in done.part_reports] == [True, True]


@pytest.mark.extensive
def test_the_table_is_sorted_and_filtered_by_clicking(screen, bench, reaches):
    state = run_to_plan(screen, reaches)
    screen.tab("Candidates")
    rows = screen.page.locator(".wb-table tbody tr")
    rows.first.wait_for()
    counts = {
        text.rsplit(" ", 1)[0]: int(text.rsplit(" ", 1)[1])
        for text in screen.page.locator(".wb-filter").all_inner_texts()
    }
    assert counts["all"] == len(state.candidates)
    assert counts["ok"] == sum(c.verdict.is_ok for c in state.candidates)

    screen.page.locator(".wb-col-grasp").click()
    screen.page.get_by_text(re.compile("Grasp ▴")).wait_for()
    expected = order_candidates(
        state.candidates, CandidateOrder(column="grasp", is_descending=False)
    )
    shown = [row.locator("td").nth(1).inner_text() for row in rows.all()]
    assert shown == [state.candidates[number].grasp.name for number in expected[: len(shown)]]

    pause(screen.page, 80)
    screen.page.locator(".wb-filter", has_text=re.compile("^ok ")).click()
    screen.page.locator('.wb-filter[aria-pressed="true"]', has_text=re.compile("^ok ")).wait_for()
    verdicts = screen.page.locator(".wb-verdict").all_inner_texts()
    assert set(verdicts) == {"ok"}


@pytest.mark.extensive
def test_scrubbing_moves_the_shared_picture_and_the_sliders_of_others(
    screen, open_screen, reaches, wait
):
    state = run_to_plan(screen, reaches)
    other = open_screen()
    for each in (screen, other):
        each.tab("Plan")
        each.page.locator(".wb-now").wait_for()
    slider = screen.page.get_by_role("slider").first
    slider.focus()
    for _ in range(5):
        slider.press("ArrowRight")
        pause(screen.page, 80)
    for each in (screen, other):
        each.page.locator(".wb-now", has_text=re.compile(r"^0\.05 s")).wait_for()
    # A click in a curve goes to its time, also after the colours have changed out of sight.
    screen.tab("Cycle")
    screen.page.mouse.move(200, 400)
    screen.page.keyboard.press("l")
    screen.page.locator(':root[data-mantine-color-scheme="dark"]').wait_for()
    screen.tab("Plan")
    canvas = screen.page.locator(".wb-canvas").first
    canvas.scroll_into_view_if_needed()
    box = canvas.bounding_box()
    assert box["width"] > 200 and canvas.locator("path").first.bounding_box()["width"] > 200
    screen.page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    middle = state.plan.cycle_seconds / 2

    def is_there(each):
        return abs(float(each.page.locator(".wb-now").inner_text().split()[0]) - middle) < 0.1

    for each in (screen, other):
        wait(partial(is_there, each), "the middle of the plan")
    cursor = canvas.locator(".wb-at").bounding_box()["x"] - box["x"]
    assert abs(cursor - box["width"] / 2) < 4
    screen.shoot("plots-dark")
    slider.press("End")
    end = f"{round(state.plan.cycle_seconds, 2):.2f} s"
    for each in (screen, other):
        each.page.locator(".wb-now", has_text=re.compile(f"^{re.escape(end)}")).wait_for()
