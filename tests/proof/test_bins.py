"""The other bins of a cell: planning and the proof, each for itself, keep out of them."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.derived.by_bin import with_bin
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.simulation.synthesize import synthesize

CELL = with_bin(read_cell(find("robots", "yumi") / "two_bins.toml"), "left")

PART = Detection(
    CELL.parts[0].name,
    CELL.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.0191), (np.pi / 2, 0, 0.3)),
)


def with_other_at(x: float, y: float, z: float):
    """The cell with its other bin turned upright to a wall there, over the bin's floor."""
    (other,) = CELL.other_bins
    T = CELL.bin.T_world_bin * pose_from_rpy((x, y, z), (0, 0, 0))
    return replace(CELL, other_bins=(replace(other, T_world_bin=T),))


@pytest.fixture(scope="module")
def made():
    result = plan_pick(CELL, (PART,), "test", strategy="left", seed=0)
    assert result.plan is not None and result.proof.holds
    return result.plan


def test_a_plan_through_the_other_bin_fails_its_proof(made):
    # Over the part, where the hand comes down: without the other bin the same plan holds.
    through = with_other_at(0.0, 0.0, 0.06)
    proof = prove(through, replace(made, cell_digest=through.digest))
    assert not proof.holds
    assert any("bin right" in (violation.pair or ()) for violation in proof.violations)
    without = replace(through, other_bins=())
    assert prove(without, replace(made, cell_digest=without.digest)).holds


def test_planning_finds_no_grasp_through_the_other_bin():
    result = plan_pick(with_other_at(0.0, 0.0, 0.06), (PART,), "test", strategy="left", seed=0)
    assert result.plan is None
    assert any("bin right" in (one.verdict.pair or ()) for one in result.candidates)


def test_a_plan_for_one_bin_is_none_for_the_other(made):
    assert not prove(with_bin(CELL, "right"), made).holds


def test_a_scan_shows_all_bins():
    alone = synthesize(replace(CELL, other_bins=()), (PART,), seed=1)
    both = synthesize(CELL, (PART,), seed=1)
    (other,) = CELL.other_bins
    T = other.T_world_bin.inverse() * both.T_world_scanner

    def rim(scan) -> int:
        p = scan.points.reshape(-1, 3) @ T.rotation.T + T.translation
        near = (np.abs(p[:, :2]) < other.size[:2] / 2 + other.wall).all(axis=1)
        return int((near & (p[:, 2] > other.size[2] / 2)).sum())

    assert rim(both) > 100 > 10 > rim(alone)
