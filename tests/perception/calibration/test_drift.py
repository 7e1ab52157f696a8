"""What is told of a scanner that has drifted, and what is not: days, things, directions."""

import numpy as np
import pytest
from drifting import PRIOR, put_parts, seen, weeks, yumi
from scipy.optimize import least_squares
from scipy.stats import chi2

from workbench.model.scan import Detection
from workbench.perception.calibration.drift import DAY, courses, estimated, known
from workbench.perception.calibration.refinement import drift_of, estimate_from_parts
from workbench.perception.calibration.things import (
    ThingSighting,
    motion_at,
    motion_of,
    sight_things,
)

MOVED = np.array([1e-3, -5e-4, 4e-4, 1e-3, -2e-3, 1.5e-3])
FLAT = np.diag([0.0, 0.0, 1e8, 1e6, 1e6, 0.0])


def days(count, moved, *, noise=2e-5, seed=0, thing="table", information=FLAT):
    """A thing that stands still, day after day, as the scanner moves by `moved(day)`."""
    rng, kind = np.random.default_rng(seed), "bin" if thing == "bin" else "fixture"
    held = np.diag(information) > 0
    return [
        ThingSighting(
            thing,
            kind,
            (day + 0.5) * DAY,
            (-np.asarray(moved(day)) + rng.normal(0, noise, 6)) * held,
            information,
        )
        for day in range(count)
    ]


def exact(cell, parts, moved):
    """Sightings of parts without noise."""
    middle = cell.bin.T_world_bin.translation
    for part, T_lies in parts:
        T_seen = motion_of(moved, middle).inverse() * T_lies
        off = motion_at(T_seen * part.detection.T_world_part.inverse(), middle)
        yield ThingSighting(
            "peg", "part", 0.5 * DAY, off, np.diag([1e8] * 3 + [1e6] * 3), part.slopes
        )


def test_a_scan_tells_height_and_lean_by_the_table_and_the_rest_by_the_bin():
    cell = yumi()
    bin, table = sight_things(cell, seen(cell, MOVED, ((), ()), 1))[:2]
    assert (bin.kind, table.thing) == ("bin", "table")
    assert list(known(table.information)) == [False, False, True, True, True, False]
    np.testing.assert_allclose(-table.off[2:5], MOVED[2:5], atol=1e-4)
    np.testing.assert_allclose(-bin.off[:3], MOVED[:3], atol=3e-4)


def test_parts_that_are_put_down_and_turned_tell_the_whole_pose():
    cell = yumi(np.deg2rad(46))
    found = estimated(list(exact(cell, put_parts(cell, 3, MOVED, 6), MOVED)))
    assert found.is_known.all()
    np.testing.assert_allclose(found.moved, MOVED, atol=5e-5)


def test_parts_that_are_only_shifted_do_not_tell_where_aside_the_scanner_is():
    cell = yumi(np.deg2rad(46))
    found = estimated(list(exact(cell, put_parts(cell, 3, MOVED, 6, is_turned=False), MOVED)))
    assert list(found.is_known) == [False, False, True, True, True, True]
    np.testing.assert_allclose(found.moved[2:], MOVED[2:], atol=5e-5)
    np.testing.assert_allclose(found.moved[:2], 0, atol=1e-6)


def test_parts_say_the_same_as_least_squares_over_whole_motions():
    """Of the same parts, without slopes: each is carried, laid down, and seen, exactly."""
    cell = yumi(np.deg2rad(46))
    middle = cell.bin.T_world_bin.translation
    parts = put_parts(cell, 5, MOVED, 8, slip=2e-4)
    sightings = list(exact(cell, parts, MOVED))

    def off(x):
        rows = []
        for sighting, again in zip(sightings, put_parts(cell, 5, x, 8), strict=True):
            T_seen = motion_of(x, middle).inverse() * again[1]
            expected = motion_at(T_seen * again[0].detection.T_world_part.inverse(), middle)
            rows.append((sighting.off - expected) * ([1e4] * 3 + [1e3] * 3))
        return np.concatenate(rows)

    foreign = least_squares(off, np.zeros(6)).x
    np.testing.assert_allclose(estimated(sightings).moved, foreign, atol=2e-5)


def test_parts_in_scans_tell_the_pose_to_some_hundredths_of_a_millimetre():
    cell = yumi(np.deg2rad(46))
    parts = put_parts(cell, 8, MOVED, 6)
    sightings = []
    for k in range(0, 6, 2):
        lies = [Detection(one.detection.part, T) for one, T in parts[k : k + 2]]
        scan = seen(cell, MOVED, ((), lies), k)
        found = sight_things(cell, scan, [one for one, _ in parts[k : k + 2]])
        sightings += [one for one in found if one.kind == "part"]
    assert len(sightings) == 6
    found = estimated(sightings)
    np.testing.assert_allclose(found.moved[:3], MOVED[:3], atol=2e-4)
    np.testing.assert_allclose(found.moved[3:], MOVED[3:], atol=1e-3)


def test_parts_that_slip_in_the_hand_say_how_sure_they_are():
    cell, alone, held = yumi(np.deg2rad(46)), [], []
    for seed in range(60):
        sightings = list(exact(cell, put_parts(cell, seed, MOVED, 8, slip=3e-4), MOVED))
        for told, found in (
            (alone, estimated(sightings)),
            (held, estimate_from_parts(sightings)),
        ):
            off = found.moved - MOVED
            told.append(off @ found.information @ off < chi2.ppf(0.95, 6))
    assert np.mean(alone) < 0.8, "what a sighting says of itself is too sure"
    assert np.mean(held) >= 0.95


def test_a_drift_is_told_and_the_pose_follows():
    drift = np.array([0, 0, 5e-4, 0, 0, 0])
    found = drift_of(days(14, lambda day: drift * (day > 6)), PRIOR, 0.9)
    assert found.drifted == ("table",)
    assert found.open == ("x", "y", "rz")
    np.testing.assert_allclose(found.moved, drift, atol=1e-4)
    # The calibration's own error stays, and what nothing tells is known less.
    deviations = np.sqrt(np.diag(found.covariance) / np.diag(PRIOR))
    assert 1.0 < deviations[2] < 1.1 and deviations[0] > 1.3


def test_noise_alone_is_no_drift():
    told = sum(
        bool(drift_of(days(14, lambda day: np.zeros(6), noise=1e-4, seed=seed), PRIOR, 0.9).drifted)
        for seed in range(200)
    )
    assert told <= 4


def test_a_bin_that_is_off_alone_is_no_drift():
    still = days(14, lambda day: np.zeros(6))
    moved = days(
        14, lambda day: [0.002 * (day > 6), 0, 0, 0, 0, 0], thing="bin", information=np.eye(6) * 1e8
    )
    found = drift_of([*still, *moved], PRIOR, 0.9)
    assert (found.drifted, found.is_bin_off, found.moved) == ((), True, None)


def test_a_bin_that_agrees_with_the_table_is_not_off():
    def raised(day):
        return [0, 0, 5e-4 * (day > 6), 0, 0, 0]

    bins = days(14, raised, thing="bin", information=np.eye(6) * 1e8, seed=1)
    found = drift_of([*days(14, raised), *bins], PRIOR, 0.9)
    assert (found.drifted, found.is_bin_off) == (("table",), False)


def test_of_fixtures_that_disagree_none_is_believed():
    still = days(14, lambda day: np.zeros(6))
    moved = days(14, lambda day: [0, 0, 1e-3 * (day > 6), 0, 0, 0], thing="tray", seed=1)
    assert drift_of([*still, *moved], PRIOR, 0.9).drifted == ()


def test_of_three_fixtures_the_one_that_disagrees_with_both_others_is_left_out():
    def raised(day):
        return [0, 0, 1e-3 * (day > 6), 0, 0, 0]

    sightings = [
        *days(14, raised, thing="table", seed=0),
        *days(14, raised, thing="frame", seed=1),
        *days(14, lambda day: np.zeros(6), thing="tray", seed=2),
    ]
    assert drift_of(sightings, PRIOR, 0.9).drifted == ("frame", "table")


def test_a_fixture_that_shows_nothing_in_a_direction_decides_nothing_there():
    held = np.eye(6) * 1e8
    sightings = [
        *days(14, lambda day: [2e-3 * (day > 6), 0, 0, 0, 0, 0], thing="jig", information=held),
        *days(14, lambda day: np.zeros(6), thing="post", information=held, seed=1),
        *days(14, lambda day: np.zeros(6), seed=2),
    ]
    assert drift_of(sightings, PRIOR, 0.9).drifted == ()


@pytest.mark.parametrize("count", [0, 1, 3])
def test_few_days_say_nothing(count):
    sightings = days(count, lambda day: [0, 0, 1e-3 * day, 0, 0, 0])
    assert drift_of(sightings, PRIOR, 0.9).drifted == ()
    assert all(np.isnan(one.change).all() for one in courses(sightings))


def test_parts_alone_refine_the_calibration():
    cell = yumi(np.deg2rad(46))
    sightings = list(exact(cell, put_parts(cell, 3, MOVED, 8), MOVED))
    found = drift_of(sightings, PRIOR * 16, 0.9)
    np.testing.assert_allclose(found.moved, MOVED, atol=1e-4)
    assert (np.diag(found.covariance) < np.diag(PRIOR * 16)).all()
    assert np.linalg.eigvalsh(found.covariance)[0] > 0
    assert drift_of(sightings[:3], PRIOR, 0.9).moved is None


def test_weeks_of_scans_show_a_drift():
    cell = yumi()
    sightings = weeks(cell, 3, [0, 0, 1e-3, 0, 0, 0], days=9)
    found = drift_of(sightings, PRIOR, 0.9)
    assert found.drifted == ("table",)
    assert abs(found.moved[2] - 1e-3) < 2e-4


def test_motions_are_told_and_made_again():
    point = np.array([0.4, 0.1, -0.2])
    T = motion_of(MOVED, point)
    np.testing.assert_allclose(motion_at(T, point), MOVED, atol=1e-12)
