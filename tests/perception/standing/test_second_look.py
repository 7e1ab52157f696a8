"""A bolt that stands in its nest is found again in a scan; what else stands there is not."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from assembling import assembly_cell, turn

from workbench.model.cell import Fixture
from workbench.model.geometry import Box, Solid, pose_from_rpy
from workbench.model.recipes.seen_base import MOST_SHIFT, SeenBase, SightProblem
from workbench.model.scan import Detection, Scan
from workbench.perception.scene.merging import merged
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.standing.second_look import find_standing

CELL = assembly_cell()
BOLT = CELL.part("bolt")
T_PLACE = CELL.arm("right").part_places[0].T_world_part
BELIEVED = pin.SE3(T_PLACE.rotation, T_PLACE.translation - [0.0, 0.0, 0.006])
"""Where the bolt stands once it has fallen into its nest."""


def bolt(x: float = 0.0, y: float = 0.0, *, tilt: float = 0.0, roll: float = 0.0) -> Detection:
    """A bolt [mm, degrees] off where it is believed."""
    off = pose_from_rpy((x / 1000, y / 1000, 0.0)) * turn("x", tilt) * turn("z", roll)
    return Detection("bolt", BELIEVED * off)


def scan_of(*truth: Detection, seed: int = 1, cell=CELL) -> Scan:
    return synthesize(cell, truth, seed=seed)


def seen_in(scan: Scan, cell=CELL) -> SeenBase:
    return find_standing(scan, cell, BOLT, BELIEVED)


def off(seen: SeenBase, truth: Detection) -> tuple[float, float]:
    """How far [m] its middle is off the truth, and how far [rad] its axis."""
    assert seen.T_world_part is not None, seen.problem
    T = truth.T_world_part.actInv(seen.T_world_part)
    return float(np.linalg.norm(T.translation)), float(np.arccos(min(1.0, T.rotation[2, 2])))


@pytest.mark.parametrize("x, y, tilt", [(0, 0, 0), (3, -2, 0), (-6, 5, 1), (9, 0, 0), (0, 0, 4)])
def test_a_bolt_is_found_where_it_stands(x, y, tilt):
    truth = bolt(x, y, tilt=tilt)
    seen = seen_in(scan_of(truth))
    shift, turned = off(seen, truth)
    assert shift < 0.0003 and turned < np.deg2rad(0.3)
    assert seen.shift == pytest.approx(np.hypot(x, y) / 1000, abs=0.0003)
    assert seen.visible > 0.6


def test_errors_are_as_large_as_the_covariance_states():
    errors, variances = [], []
    for seed in range(12):
        truth = bolt(seed / 2 - 3, 2)
        seen = seen_in(scan_of(truth, seed=seed))
        assert seen.T_world_part is not None and seen.covariance is not None
        errors.append(seen.T_world_part.translation - truth.T_world_part.translation)
        variances.append(np.diag(seen.covariance)[:3])
    ratio = np.mean(np.square(errors) / np.array(variances))
    assert 0.02 < ratio < 2.0


def test_a_turn_that_the_part_does_not_show_stays_as_believed():
    # Any turn of a sixth of a circle is the same bolt.
    seen = seen_in(scan_of(bolt(2, 2, roll=60)))
    assert seen.problem is None and seen.turn < np.deg2rad(3)


def test_the_same_scan_brings_the_same_pose():
    scan = scan_of(bolt(4, -3))
    one, other = seen_in(scan), seen_in(scan)
    assert one.T_world_part is not None and other.T_world_part is not None
    assert np.array_equal(one.T_world_part.homogeneous, other.T_world_part.homogeneous)
    assert np.array_equal(one.covariance, other.covariance) and one.scan == scan.digest


@pytest.mark.parametrize("far", [11, 14, 20])
def test_a_bolt_beyond_the_bound_is_not_taken_for_the_same(far):
    seen = seen_in(scan_of(bolt(far)))
    assert seen.problem is SightProblem.TOO_FAR and seen.T_world_part is None
    assert seen.shift == pytest.approx(far / 1000, abs=0.0005) and seen.shift > MOST_SHIFT
    assert "at most 10.0 mm and 5.0 deg" in str(seen.message("bolt"))


def test_a_bolt_that_leans_too_far_is_not_taken_for_the_same():
    assert seen_in(scan_of(bolt(tilt=8))).problem is SightProblem.TOO_FAR


@pytest.mark.parametrize("rise, problem", [(9, True), (3, True), (-3, True), (1, False)])
def test_a_bolt_that_has_risen_from_its_nest_is_not_taken_for_the_same(rise, problem):
    up = Detection("bolt", pose_from_rpy((0.0, 0.0, rise / 1000)) * BELIEVED)
    seen = seen_in(scan_of(up))
    assert seen.problem is (SightProblem.OFF_HEIGHT if problem else None)
    assert seen.shift == pytest.approx(abs(rise) / 1000, abs=0.0005)
    if problem:
        assert "at most 2.0 mm up or down" in str(seen.message("bolt"))


def test_an_empty_nest_is_no_bolt():
    seen = seen_in(scan_of())
    assert seen.problem is SightProblem.GONE
    assert str(seen.message("bolt")) == "the scan shows nothing where bolt is believed to stand"


def test_a_bolt_that_has_tipped_over_is_none():
    lies = pin.SE3(turn("y", 90).rotation, BELIEVED.translation + [0.0, 0.0, -0.022])
    assert seen_in(scan_of(Detection("bolt", lies))).problem is not None
    upside_down = Detection("bolt", BELIEVED * turn("x", 180))
    assert seen_in(scan_of(upside_down)).problem is SightProblem.OTHER


def spacer(height: float) -> Detection:
    """In the nest's middle, its own middle at a height [m] over the bolt's."""
    return Detection("spacer", BELIEVED * pose_from_rpy((0.0, 0.0, height)))


def test_another_part_in_its_place_is_none():
    assert seen_in(scan_of(spacer(-0.025))).problem is SightProblem.OTHER


def test_a_bolt_that_has_its_spacer_already_is_not_taken_for_a_bare_one():
    assert seen_in(scan_of(bolt(), spacer(-0.015))).problem is SightProblem.OTHER


def test_of_two_bolts_the_one_in_the_place_is_found():
    truth = bolt(1, 1)
    beside = Detection("bolt", BELIEVED * pose_from_rpy((0.0, 0.032, 0.0)))
    shift, _ = off(seen_in(scan_of(truth, beside)), truth)
    assert shift < 0.0003
    # One beside an empty place is not taken for it.
    assert seen_in(scan_of(beside)).problem is not None


def covered(to: float, cell=CELL):
    """The cell with a sheet in the scanner's sight of the bolt, from so far [m] beside it on."""
    sheet = Solid("sheet", Box(np.array([0.1, 0.1, 0.002])), pin.SE3.Identity())
    sight = 0.2 * (CELL.scanner.T_world_scanner.translation - BELIEVED.translation)
    T = pin.SE3(np.eye(3), BELIEVED.translation + sight + [0.05 + to, 0.0, 0.0])
    return replace(cell, fixtures=(*cell.fixtures, Fixture("cover", T, (sheet,))))


def test_half_of_a_bolt_is_enough_and_little_of_it_is_not():
    truth, half, nearly = bolt(2, 1), covered(0.004), covered(0.0)
    shift, turned = off(seen_in(scan_of(truth, cell=half), half), truth)
    assert shift < 0.0005 and turned < np.deg2rad(0.5)
    seen = seen_in(scan_of(truth, cell=nearly), nearly)
    assert seen.problem is SightProblem.TOO_LITTLE and seen.visible < 0.3


def test_noise_widens_the_covariance_and_much_of_it_brings_no_pose():
    truth = bolt(3, 2)

    def with_noise(deviation: float) -> SeenBase:
        cell = replace(CELL, scanner=replace(CELL.scanner, depth_noise=deviation))
        return seen_in(scan_of(truth, cell=cell), cell)

    quiet, noisy = with_noise(0.0003), with_noise(0.001)
    assert quiet.covariance is not None and noisy.covariance is not None
    assert off(noisy, truth)[0] < 0.001
    assert np.trace(noisy.covariance[:3, :3]) > 4 * np.trace(quiet.covariance[:3, :3])
    assert with_noise(0.005).problem is not None


def test_what_the_scanner_does_not_view_is_not_found():
    narrow = replace(CELL, scanner=replace(CELL.scanner, field_of_view=np.deg2rad(26)))
    seen = seen_in(scan_of(bolt(), cell=narrow), narrow)
    assert seen.problem is SightProblem.NOT_IN_VIEW
    assert "choose a view" in str(seen.message("bolt"))


def test_points_without_an_image_do_as_well():
    truth = bolt(-2, 4)
    scan = scan_of(truth)
    some = np.random.default_rng(0).permutation(len(scan.points))
    cloud = Scan(scan.points[some], scan.T_world_scanner, "cloud")
    assert off(seen_in(cloud), truth)[0] < 0.0003


def test_of_two_views_one_that_speaks_against_the_bolt_counts():
    aside = pin.SE3(CELL.scanner.T_world_scanner)
    aside.translation += np.array([0.0, 0.03, 0.0])
    other = replace(CELL, scanner=replace(CELL.scanner, T_world_scanner=aside))
    truth = bolt(2, 2)
    first = merged(CELL, None, scan_of(truth), "first")
    both = merged(other, first, scan_of(truth, cell=other, seed=2), "second")
    assert off(seen_in(both), truth)[0] < 0.0004
    gone = merged(other, first, scan_of(cell=other, seed=2), "second")
    assert seen_in(gone).problem is SightProblem.GONE


def both_views(first: Detection, second: Detection, *, seed: int = 1) -> Scan:
    """A merged scan of two views, between which the bolt may move."""
    aside = pin.SE3(CELL.scanner.T_world_scanner)
    aside.translation += np.array([0.0, 0.03, 0.0])
    other = replace(CELL, scanner=replace(CELL.scanner, T_world_scanner=aside))
    before = merged(CELL, None, scan_of(first, seed=seed), "first")
    return merged(other, before, scan_of(second, cell=other, seed=seed + 1), "second")


@pytest.mark.parametrize("far", [2, 3, 6])
def test_a_bolt_that_moves_between_two_views_is_at_no_pose(far):
    seen = seen_in(both_views(bolt(2, 2), bolt(2 + far, 2)))
    assert seen.problem is SightProblem.MOVED and seen.T_world_part is None
    assert "at two places" in str(seen.message("bolt"))


@pytest.mark.parametrize("seed", [1, 5, 9])
def test_two_views_of_a_bolt_that_stands_still_agree(seed):
    truth = bolt(seed - 5, 2, tilt=1)
    assert off(seen_in(both_views(truth, truth, seed=seed)), truth)[0] < 0.0004
