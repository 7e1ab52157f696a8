"""Trueness and touch test on the page, in a simulated cell whose calibration states its errors."""

from dataclasses import replace

import numpy as np
from hands import field, pause, unfold

from workbench.app.core.cell.changes import ChangeCell
from workbench.model.calibration import CalibrationRecord
from workbench.model.geometry import pose_from_rpy

COVARIANCE = np.diag([3e-4] * 3 + [3e-4] * 3) ** 2


def test_a_scanner_is_checked_by_balls_and_by_touches(screen, served, bench, wait):
    (visitor,) = served._renderer._visitors.values()
    cell = bench.state.cell
    record = CalibrationRecord(1.0, "ada", 8, 3e-4, 3e-4, 3e-4, COVARIANCE)
    mount = replace(cell.scanner, calibration=record)
    bench.do(ChangeCell(replace(cell, scanner=mount), "calibrated"), "anna")
    screen.tab("Calibration")
    unfold(screen, "2 · Poses")
    unfold(screen, "3 · Review and apply")
    unfold(screen, "5 · Trueness")
    screen.wait_for("No scan of the balls yet")
    for count in range(1, 4):
        screen.press("Scan the balls")
        wait(lambda count=count: len(bench.state.ball_scans) == count, f"scan {count}")
    screen.wait_for("Lengths are true")
    pause(screen.page, 1000)
    screen.shoot("trueness")
    field(screen, "Limit [mm]").first.fill("0.01")
    wait(lambda: bench.state.check_limits == (1e-5, 0.0), "the limit")
    screen.wait_for("Lengths are not true")
    screen.shoot("trueness-not")
    unfold(screen, "5 · Trueness")

    unfold(screen, "6 · Touch test")
    for count in range(1, 4):
        before = visitor.own.now.jog
        screen.press("Show a touch")
        # The first one takes its time: the planner's compiled code is loaded.
        wait(lambda before=before: visitor.own.now.jog is not before, "the posture")
        screen.press("Record the touch")
        wait(lambda count=count: len(bench.state.touches) == count, f"touch {count}")
        if count == 1:
            screen.wait_for("A touch test needs 3 touches; there are 1.")
    screen.wait_for("Scanner and robot agree")
    pause(screen.page, 1000)
    screen.shoot("touches")

    moved = pose_from_rpy((0.003, 0.0, 0.0), (0.0, 0.0, 0.0)) * mount.T_world_scanner
    bench.do(
        ChangeCell(replace(cell, scanner=replace(mount, T_world_scanner=moved)), "off"), "anna"
    )
    screen.wait_for("Scanner and robot disagree")
    pause(screen.page, 500)
    screen.shoot("touches-disagree")
    screen.press("Remove last touch")
    wait(lambda: len(bench.state.touches) == 2, "one touch less")
