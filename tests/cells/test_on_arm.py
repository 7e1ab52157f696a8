"""The cell with its scanner on the left wrist: from the view to a proven plan, and to the robot."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.empty_hand.view_plan import plan_view
from workbench.app.picking.pipeline import plan_pick
from workbench.app.runtime.work import find_parts, scan
from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import Cell
from workbench.model.geometry import Box, Solid
from workbench.model.scan import Scene
from workbench.plugins.progress import never, silent
from workbench.proof.claims.prove import prove

ON_ARM = find("robots", "yumi") / "on_arm.toml"


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell(ON_ARM)


def test_a_plan_begins_and_ends_at_the_view_and_its_housing_is_proven(cell: Cell) -> None:
    joints = cell.joint_values({arm.name: arm.home for arm in cell.arms})
    request = {"seed": 3, "parts": 2, "part": "", "joints": joints}
    taken = scan(cell, request, silent, never)
    assert taken.joints == joints
    found = find_parts(cell, {"scan": taken, "seed": 3}, silent, never).detections
    assert len(found) == 2
    result = plan_pick(cell, found, taken.digest, strategy="left", seed=3)
    plan, carrier = result.plan, cell.scanner.on_arm
    assert plan is not None and carrier is not None
    assert result.proof is not None and result.proof.holds
    legs = plan.arm("left").legs
    for q in (legs[0].q[0], legs[-1].q[-1]):
        assert np.abs(q - carrier.view.q).max() < 1e-5
    # As long as a lamp post, it goes through the bin where the hand goes into it.
    post = Solid(
        "camera", Box(np.array([0.02, 0.02, 0.3])), pin.SE3(np.eye(3), np.array([0.0, -0.1, 0.12]))
    )
    posted = replace(carrier, housing=(post,))
    other = replace(cell, scanner=replace(cell.scanner, on_arm=posted))
    proof = prove(
        other,
        Scene(plan.scan_digest, plan.detections, plan.obstacles),
        replace(plan, cell_digest=other.digest),
    )
    assert any("left camera" in (violation.pair or ()) for violation in proof.violations)


def test_a_deep_bin_is_scanned_from_the_arm_and_a_part_is_taken_out() -> None:
    deep = read_cell(find("robots", "tx2_90") / "on_arm.toml")
    view = plan_view(deep)
    assert view.proof is not None and view.proof.holds
    joints = deep.joint_values({arm.name: arm.home for arm in deep.arms})
    taken = scan(deep, {"seed": 1, "parts": 4, "part": "", "joints": joints}, silent, never)
    found = find_parts(deep, {"scan": taken, "seed": 1}, silent, never).detections
    assert len(found) == 4
    result = plan_pick(deep, found, taken.digest, seed=1)
    assert result.proof is not None and result.proof.holds


@pytest.mark.extensive
def test_the_demonstration_runs_from_the_view_to_placed_parts(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    words = ["demo", "--cell", str(ON_ARM), "--cycles", "2", "--speed", "20", "--json"]
    assert main([*words, "--sessions", str(tmp_path)]) == 0
    said = json.loads(capsys.readouterr().out)
    assert [cycle["parts_placed"] for cycle in said["cycles"]] == [2, 2]
