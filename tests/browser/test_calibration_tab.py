"""A calibration on the page: poses suggested and scanned, a wrong mount found and put right."""

from dataclasses import replace

import numpy as np
import pytest
from hands import field, pause
from playwright.sync_api import expect

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.picking.facts import bin_check_of
from workbench.gui.shared.movable_frames import BIN, move_frame
from workbench.model.geometry import pose_from_rpy
from workbench.perception.simulation.synthesize import synthesize

WRONG = pose_from_rpy((0.012, -0.008, 0.015), np.deg2rad((1.2, -0.8, 1.5)))


def test_a_scanner_that_hangs_elsewhere_is_found_and_put_right(screen, served, bench, wait):
    truth = bench.state.cell.scanner.T_world_scanner
    (visitor,) = served._renderer._visitors.values()
    screen.tab("Calibration")
    for count in range(1, 6):
        before = visitor.own.now.jog
        screen.press("Suggest a pose")
        # The first suggestion takes its time: the planner's compiled code is loaded.
        wait(lambda before=before: visitor.own.now.jog is not before, "the next pose")
        screen.wait_for("as it is jogged on the page")
        if count == 5:  # There is an answer now, and what tells most is looked for.
            screen.wait_for("From pose 4 on, with the plate held as it is:")
        screen.press("Scan the plate")
        wait(lambda count=count: len(bench.state.observations) == count, f"pose {count}")
    screen.press("Suggest a pose")
    screen.wait_for("From pose 5 on, with the plate held as it is:")
    screen.wait_for("Error at the worst corner of the bin:")
    screen.shoot("calibration-next")
    assert {one.arm for one in bench.state.observations} == {"right"}
    assert len({tuple(one.q) for one in bench.state.observations}) == 5

    # Somebody has knocked against the scanner, or typed a wrong pose.
    cell = bench.state.cell
    mount = replace(cell.scanner, T_world_scanner=truth * WRONG)
    bench.do(ChangeCell(replace(cell, scanner=mount), "knocked"), "anna")
    screen.shoot("calibration-solved")
    said = screen.page.get_by_text("from its pose in the cell").first
    wait(lambda: 20 < float(said.inner_text().split(" mm")[0]) < 22, "how far the scanner is off")
    rows = screen.page.locator(".wb-poses tbody tr")
    expect(rows).to_have_count(5)
    rows.nth(1).click()
    screen.wait_for("Points near the robot: median distance")
    screen.page.wait_for_timeout(1500)
    screen.shoot("calibration")
    screen.page.get_by_text("Show with new calibration", exact=True).click()
    screen.page.wait_for_timeout(1500)
    screen.shoot("calibration-before")
    screen.press("Leave out")
    wait(lambda: not bench.state.observations[1].is_used, "the pose to be left out")
    screen.wait_for("left out by a person")

    expect(screen.button("Apply")).to_be_disabled()  # until a name is typed
    field(screen, "Your name").fill("Anna")
    pause(screen.page, 300)
    screen.press("Apply")
    wait(lambda: bench.state.cell.scanner.calibration is not None, "the calibration")
    after = bench.state.cell.scanner
    off = truth.actInv(after.T_world_scanner)
    assert np.linalg.norm(off.translation) < 0.001
    assert after.calibration.by == "Anna" and after.calibration.poses == 4
    screen.wait_for("by Anna: 4 poses")
    assert screen.errors == []


@pytest.fixture
def moved_scan(bench):
    """A scan of the bin 15 mm from where the cell has it."""
    cell = bench.state.cell
    T = cell.bin.T_world_bin * pose_from_rpy((0.015, 0.0, 0.0), (0.0, 0.0, np.deg2rad(3)))
    return synthesize(move_frame(cell, BIN, T), (), seed=0), T


def test_a_moved_bin_is_told_and_the_cell_follows(screen, bench, wait, moved_scan):
    scan, T = moved_scan
    bench.do(UseScan(scan), "anna")
    screen.wait_for("The bin is 15.0 mm and 3.0 deg from its place in the cell")
    screen.shoot("bin-moved")
    screen.press("Move bin")
    wait(lambda: bench.state.before != (), "the bin to be moved")
    off = T.actInv(bench.state.cell.bin.T_world_bin)
    assert np.linalg.norm(off.translation) < 0.0005
    screen.wait_for("Nothing higher than")
    check = bin_check_of(bench.state)
    assert check.is_empty and not check.is_elsewhere
    assert screen.errors == []
