"""One scan from several views: where the poses put it, moved a little, or with a warning."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view

from workbench.model.cell import Cell
from workbench.model.derived.by_view import by_each_view, scans_by_view
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.robot import ScannedView
from workbench.model.scan import Scan
from workbench.perception.scene.merging import merged
from workbench.perception.scene.unexplained import look_around
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize

FROM_BIN, FROM_LOW = "bin", "low"


@pytest.fixture(scope="module")
def cell() -> Cell:
    return with_lower_view(on_arm_cell())


@pytest.fixture(scope="module")
def scans(cell: Cell) -> tuple[Scan, ...]:
    truth = pile_of(cell, "", 6, seed=5)
    return tuple(synthesize(each, truth, seed=5) for each in by_each_view(cell))


def both(cell: Cell, scans: tuple[Scan, ...], off: Sequence[float] = (0.0,) * 6) -> Scan:
    """The scans merged, the first one with a pose that is off by (6,) [m, rad] in its frame."""
    first, last = scans
    T = first.T_world_scanner * pose_from_rpy(off[:3], off[3:])
    before = merged(cell, None, replace(first, T_world_scanner=T), FROM_BIN)
    return merged(cell, before, last, FROM_LOW)


def at_bin(cell: Cell, T: pin.SE3, true: pin.SE3) -> float:
    """How far [m] a pose of the scanner puts the middle of the bin from where it is."""
    middle = cell.bin.T_world_bin.translation
    return float(np.linalg.norm(T.act(true.actInv(middle)) - middle))


def test_each_view_stays_in_its_own_frame_with_what_it_saw(cell, scans):
    whole = both(cell, scans)
    assert [(view.name, view.count) for view in whole.views] == [
        (FROM_BIN, len(scans[0].points)),
        (FROM_LOW, len(scans[1].points)),
    ]
    assert whole.T_world_scanner.isApprox(scans[1].T_world_scanner)
    assert whole.pixels is None and "bin, low" in whole.source
    for each, scan in zip(scans_by_view(whole), scans, strict=True):
        np.testing.assert_allclose(each.points, scan.points, atol=1e-12)
        assert at_bin(cell, each.T_world_scanner, scan.T_world_scanner) < 0.0005
    assert scans_by_view(scans[0]) == (scans[0],)


@pytest.mark.parametrize("off", [(0.0012, 0, 0.0008, 0, 0, 0), (0, -0.001, 0, 0.002, 0, 0.002)])
def test_a_pose_that_is_a_little_off_is_moved_onto_the_other_views(cell, scans, off):
    view, _ = both(cell, scans, off).views
    true = scans[0].T_world_scanner
    assert not view.is_off
    assert at_bin(cell, view.T_world_scanner, true) < 0.0005
    assert view.shift == pytest.approx(
        at_bin(cell, true * pose_from_rpy(off[:3], off[3:]), true), abs=5e-4
    )


@pytest.mark.parametrize(
    "off",
    [(0.005, 0, 0, 0, 0, 0), (0, 0.012, 0, 0, 0, 0), (0, 0, 0.02, 0, 0, 0), (0, 0, 0, 0.03, 0, 0)],
)
def test_a_pose_that_is_far_off_is_not_moved_and_said(cell, scans, off):
    view, newest = both(cell, scans, off).views
    assert view.is_off and not newest.is_off
    off_by = scans[0].T_world_scanner * pose_from_rpy(off[:3], off[3:])
    assert at_bin(cell, view.T_world_scanner, off_by) < 0.004 or view.through > 0.025


def test_a_newer_scan_of_a_view_takes_the_place_of_the_earlier_one(cell, scans):
    whole = both(cell, scans)
    again = merged(by_each_view(cell)[0], whole, scans[0], FROM_BIN)
    assert [view.name for view in again.views] == [FROM_LOW, FROM_BIN]
    assert len(again.points) == len(whole.points)


def test_views_count_all_points(scans):
    view = ScannedView(FROM_BIN, 3, scans[0].T_world_scanner)
    with pytest.raises(InputError, match="have another number together"):
        replace(scans[0], views=(view,))


def test_what_any_view_shows_is_in_the_way(cell, scans):
    truth = pile_of(cell, "", 6, seed=5)
    whole = both(cell, scans)
    assert look_around(cell, whole, truth).seen == ()
    # Nobody knows of the first part: each view shows it.
    assert len(look_around(cell, whole, truth[1:]).seen) >= 2
