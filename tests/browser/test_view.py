"""A scanner on an arm is brought to its view by pressing, and scans there, in Chromium."""

import functools
from dataclasses import replace

import pytest
from arm_scanner_cell import on_arm_cell, parked, with_lower_view
from patient import PATIENT, in_threads
from playwright.sync_api import expect
from test_page import approve, seen

from workbench.app.core.cycle.arm_scanner import is_at_view
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.journal.journal import Journal
from workbench.model.derived.by_view import view_name
from workbench.plugins.robot_link import Simulation


@pytest.fixture
def merges():
    return False


@pytest.fixture
def cell(merges):
    return with_lower_view(on_arm_cell(), merges=merges)


@pytest.fixture
def controller(cell):
    with in_threads() as started:
        yield started(SimulatedController(parked(cell), Simulation(speed=5.0), patience=PATIENT))


@pytest.fixture
def bench(cell, controller, tmp_path):
    at = {"port": controller.port, "state_port": controller.state_port}
    there = replace(cell.controller, **at, is_simulated=True)
    effects = functools.partial(EffectRunner, patience=PATIENT)
    bench = Bench(replace(cell, controller=there), Journal(tmp_path / "session"), effects=effects)
    yield bench
    bench.close()


def test_go_to_view_is_planned_approved_sent_a_scan_is_taken_and_the_way_back_planned(
    screen, bench, reaches, wait
):
    wait(lambda: bool(bench.live.joints), "the controller to report")
    screen.wait_for("Take the scanner to its view to begin")
    expect(screen.button("Scan")).to_be_disabled()
    screen.press("Go to view")
    state = reaches("planned")
    assert state.plan.is_view_plan and state.proof.holds
    screen.wait_for("The left arm takes the scanner to view bin, clear of the whole bin")
    # No scan and no parts: their steps are not shown as done.
    done = screen.page.locator(".wb-strip li.wb-done")
    expect(done).to_have_count(1)
    expect(screen.button("Plan")).to_be_disabled()
    seen(bench)
    approve(screen, "Anna")
    reaches("approved")
    screen.press("Send")
    reaches("done")
    screen.wait_for("The left arm stands at view bin")
    wait(lambda: is_at_view(bench.cell, bench.live.joints), "the arm to be reported there")
    expect(screen.button("Go to view")).to_have_count(0)
    screen.press("Scan")
    assert reaches("scanned").scan is not None
    chosen = screen.page.get_by_role("combobox", name="View", exact=True)
    expect(chosen).to_have_value("bin")
    chosen.click()
    screen.page.get_by_role("option", name="low").click()
    screen.wait_for("scans are taken from view low: go there")
    expect(screen.button("Scan")).to_be_disabled()
    screen.press("Go to view")
    assert reaches("planned").scan is None
    screen.wait_for("The left arm takes the scanner to view low")
    seen(bench)
    screen.shoot("view-2-low")
    approve(screen, "Anna")
    reaches("approved")
    screen.press("Send")
    reaches("done")
    screen.wait_for("The left arm stands at view low")
    screen.press("Scan")
    assert reaches("scanned").scan is not None
    screen.press("Go back home")
    state = reaches("planned")
    assert state.plan.is_view_plan and state.proof.holds and state.scan is None
    screen.wait_for("The left arm takes the scanner home, clear of the whole bin")
    screen.shoot("view-3-back")
    assert not screen.errors


@pytest.mark.extensive
@pytest.mark.parametrize("merges", [True])
def test_a_cycle_scans_from_each_view_by_approved_paths_and_plans_for_the_merged_scan(
    screen, bench, reaches, wait
):
    wait(lambda: bool(bench.live.joints), "the controller to report")
    screen.wait_for("Take the scanner to its view to begin")
    screen.press("Go to view")
    reaches("planned")
    for view, following in (("bin", "low"), ("low", "")):
        seen(bench)
        approve(screen, "Anna")
        reaches("approved")
        screen.press("Send")
        reaches("done")
        screen.wait_for(f"The left arm stands at view {view}")
        wait(
            lambda: is_at_view(bench.state.cell, bench.live.joints), "the arm to be reported there"
        )
        screen.press("Next cycle")
        state = reaches("planned")
        assert (view_name(state.cell), state.plan.is_view_plan) == ("low", bool(following))
        assert state.approval is None, "a person approves it"
        screen.shoot(f"merged-{view}")
    assert [view.name for view in state.scan.views] == ["bin", "low"]
    assert not any(view.is_off for view in state.scan.views)
    assert len(state.detections) == 2 and state.proof.holds
    assert not screen.errors
