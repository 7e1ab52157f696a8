"""Balls at known distances: found, measured, and compared with what is stated."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.model.calibration import BallArtefact, BallScan
from workbench.model.errors import InputError
from workbench.model.scan import Scan
from workbench.perception.calibration import ball_scan
from workbench.perception.calibration.ball_scan import sight_balls
from workbench.perception.calibration.trueness import assess_trueness

PLATE, BAR = BallArtefact(), BallArtefact(0.015, np.array([0.15]))
NONE = np.empty(0)


def cloud(artefact, *, scale=1.0, noise=1e-4, seed=0, radius=None) -> Scan:
    """The upper halves of the balls 0.8 m below a scanner, and the floor under them."""
    rng = np.random.default_rng(seed)
    pieces = [np.column_stack([rng.uniform(-0.3, 0.3, (20_000, 2)), np.full(20_000, 0.85)])]
    for centre in artefact.centres:
        out = rng.standard_normal((4_000, 3))
        out /= np.linalg.norm(out, axis=1)[:, None]
        out = out[out[:, 2] < 0]
        size = (radius or artefact.radius) + noise * rng.standard_normal(len(out))
        pieces.append(centre + (0, 0, 0.8) + out * size[:, None])
    return Scan(np.concatenate(pieces) * scale, pin.SE3.Identity(), "test")


def measured(artefact, **how) -> BallScan:
    return sight_balls(cloud(artefact, **how), artefact, "scan 1", NONE, 0)


def placed(scan, place) -> BallScan:
    """The same balls, laid elsewhere."""
    return replace(scan, name=f"scan {place + 1}", balls=scan.balls + (0.05 * place, 0, 0))


@pytest.mark.parametrize("artefact", [PLATE, BAR], ids=["plate", "bar"])
def test_true_lengths_are_measured_within_hundredths_of_a_millimetre(artefact):
    seen = measured(artefact)
    assert np.abs(seen.measured - artefact.lengths).max() < 3e-5
    assert np.abs(seen.diameters - 0.03).max() < 1e-4
    # 95 % of a normal distribution lie in a band of 3.92 deviations.
    assert seen.forms == pytest.approx(np.full(len(seen.forms), 3.92e-4), rel=0.15)


def test_a_wrong_scale_shows_below_the_limit_and_is_named_above_it():
    true, small, large = (
        assess_trueness([placed(measured(PLATE, scale=s, seed=k), k) for k in range(3)], 3e-4)
        for s in (1.0, 1.001, 1.005)
    )
    assert (true.light, small.light, large.light) == ("good", "warning", "bad")
    assert abs(true.scale) < true.scale_error < 5e-4
    assert small.scale == pytest.approx(0.001, abs=2e-4)
    assert large.scale == pytest.approx(0.005, abs=2e-4)
    assert large.largest == pytest.approx(6e-4, abs=5e-5)
    assert "the scanner's scale is wrong" in str(small.says)
    assert "not true: 0." in str(large.says)


def test_one_distance_leaves_the_scale_open_and_few_places_are_said():
    found = assess_trueness([measured(BAR)], 3e-4)
    assert found.scale_error == np.inf and found.light == "warning"
    assert "scan the balls in 3 places or more" in str(found.says)


def test_balls_that_are_missing_or_elsewhere_are_no_artefact():
    with pytest.raises(InputError, match="1 of 30 mm are found, 2 at the stated"):
        one = BallArtefact(0.015, np.array([1.0]))
        scan = cloud(BAR)
        points = scan.points[~(np.linalg.norm(scan.points - (0, 0, 0.8), axis=1) < 0.02)]
        sight_balls(Scan(points, scan.T_world_scanner, "test"), one, "scan 1", NONE, 0)
    with pytest.raises(InputError, match="2 of 30 mm are found, 2 at the stated"):
        other = BallArtefact(0.015, np.array([0.16]))
        sight_balls(cloud(BAR), other, "scan 1", NONE, 0)
    with pytest.raises(InputError, match="0 of 30 mm are found"):
        flat = np.random.default_rng(0).uniform(-0.1, 0.1, (5000, 3)) + (0, 0, 1)
        sight_balls(Scan(flat, pin.SE3.Identity(), "test"), BAR, "scan 1", NONE, 0)


def test_a_ball_whose_top_is_covered_is_not_measured(monkeypatch):
    monkeypatch.setattr(ball_scan, "CAP", 0.9999)
    with pytest.raises(InputError, match="is covered on the scanner's side"):
        measured(BAR)


def test_nothing_to_compare_or_no_limit_is_refused():
    with pytest.raises(InputError, match="no scan of the balls"):
        assess_trueness([], 3e-4)
    for limit in (0.0, -1.0, np.nan):
        with pytest.raises(InputError, match="a limit is a length"):
            assess_trueness([measured(BAR)], limit)


@pytest.mark.parametrize("artefact", [PLATE, BAR], ids=["plate", "bar"])
def test_scans_of_balls_that_nobody_has_moved_are_no_further_places(artefact):
    scans = [measured(artefact, seed=k) for k in range(3)]
    first, second = (replace(scans[k], name=f"scan {k + 1}") for k in range(2))
    turned = replace(scans[2], name="scan 3", balls=scans[2].balls[::-1])
    third = turned if artefact is BAR else replace(scans[2], name="scan 3")
    found = assess_trueness([first, second, third], 3e-4)
    assert found.light == "warning"
    assert "scan 2 does not count: its balls lie where those of scan 1 do" in str(found.says)
    moved = assess_trueness([first, placed(second, 1), placed(scans[2], 2)], 3e-4)
    assert "does not count" not in str(moved.says) and "3 places" not in str(moved.says)
