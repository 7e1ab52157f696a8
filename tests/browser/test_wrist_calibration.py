"""A scanner on an arm is calibrated on the page by a plate that stands, in Chromium."""

import numpy as np
import pytest
from arm_scanner_cell import on_arm_cell
from hands import field, pause
from playwright.sync_api import expect

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.derived.scanner_poses import with_scanner_at
from workbench.model.geometry import pose_from_rpy

pytestmark = pytest.mark.extensive

WRONG = pose_from_rpy((0.012, -0.008, 0.015), np.deg2rad((1.2, -0.8, 1.5)))


@pytest.fixture
def bench(tmp_path):
    bench = Bench(on_arm_cell(), Journal(tmp_path / "session"))
    yield bench
    bench.close()


def test_a_scanner_that_hangs_elsewhere_on_its_flange_is_found_and_put_right(
    screen, served, bench, wait
):
    truth = bench.state.cell
    (visitor,) = served._renderer._visitors.values()
    screen.tab("Calibration")
    screen.wait_for("The left arm carries the scanner. Fix the plate where the scanner sees it")
    expect(screen.page.get_by_role("combobox", name="Arm", exact=True)).to_have_count(0)
    for count in range(1, 6):
        before = visitor.own.now.jog
        screen.press("Suggest a pose")
        wait(lambda before=before: visitor.own.now.jog is not before, "the next pose")
        if count == 1:  # Nobody knows yet where the plate lies.
            assert np.array_equal(visitor.own.now.jog["left"], truth.scanner.on_arm.view.q)
        if count == 5:
            screen.wait_for("From pose 4 on, move the scanner:")
        screen.wait_for("as it is jogged on the page")
        screen.press("Scan the plate")
        wait(lambda count=count: len(bench.state.observations) == count, f"pose {count}")
        screen.shoot(f"wrist-{count}")
    screen.press("Suggest a pose")
    screen.wait_for("From pose 5 on, move the scanner:")
    screen.wait_for("Error at the worst corner of the bin:")
    screen.shoot("wrist-next")
    assert {one.arm for one in bench.state.observations} == {"left"}

    # Somebody has knocked against the scanner, or typed a wrong pose.
    knocked = with_scanner_at(truth, truth.scanner.T_world_scanner * WRONG)
    bench.do(ChangeCell(knocked, "knocked"), "anna")
    said = screen.page.get_by_text("from its pose in the cell").first
    wait(lambda: 20 < float(said.inner_text().split(" mm")[0]) < 22, "how far the scanner is off")
    rows = screen.page.locator(".wb-poses tbody tr")
    expect(rows).to_have_count(5)
    rows.nth(2).click()
    screen.wait_for("Points near bin, fixtures and robot: median distance")
    screen.page.wait_for_timeout(1500)
    screen.shoot("wrist-overlay")
    screen.page.get_by_text("Show with new calibration", exact=True).click()
    screen.page.wait_for_timeout(1500)
    screen.shoot("wrist-before")
    screen.press("Leave out")
    wait(lambda: not bench.state.observations[2].is_used, "the pose to be left out")
    screen.wait_for("left out by a person")

    field(screen, "Your name").fill("Anna")
    pause(screen.page, 300)
    screen.press("Apply")
    wait(lambda: bench.state.cell.scanner.calibration is not None, "the calibration")
    after = bench.state.cell.scanner
    off = truth.scanner.on_arm.T_flange_scanner.actInv(after.on_arm.T_flange_scanner)
    assert np.linalg.norm(off.translation) < 0.001
    assert after.calibration.by == "Anna" and after.calibration.poses == 4
    screen.wait_for("by Anna: 4 poses")
    screen.shoot("wrist-applied")
    assert screen.errors == []
