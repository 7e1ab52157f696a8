"""From a scan to poses: found where they are, doubts told, nothing invented."""

import math
from dataclasses import replace

import numpy as np
import pytest

from workbench.model.errors import JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Scan
from workbench.perception.localize import localize
from workbench.perception.piles import drop_parts
from workbench.perception.synthesize import synthesize
from workbench.studies.localization import compare


def compared(part, truth, found) -> tuple[dict[str, int], dict[str, list[float]]]:
    counts = dict.fromkeys(("parts", "missed", "ghosts", "wrong", "roll unknown"), 0)
    errors: dict[str, list[float]] = {"distance": [], "tilt": [], "roll": []}
    compare(part, truth, found, counts, errors)
    return counts, errors


@pytest.mark.parametrize("seed", range(6))
def test_two_parts_are_found_where_they_are(cell, part, seed):
    truth = drop_parts(part, cell.bin, 2, seed=seed)
    found = localize(synthesize(cell, part, truth, seed=seed), part, cell, seed=0)
    counts, errors = compared(part, truth, found)
    assert (counts["missed"], counts["ghosts"], counts["wrong"]) == (0, 0, 0)
    assert max(errors["distance"]) < 0.0005
    assert max(errors["tilt"]) < math.radians(0.5)


def test_a_heap_is_found_too(cell, part):
    truth = drop_parts(part, cell.bin, 8, seed=3)
    found = localize(synthesize(cell, part, truth, seed=3), part, cell, seed=0)
    counts, _ = compared(part, truth, found)
    assert counts["ghosts"] == counts["wrong"] == 0
    assert counts["missed"] <= 1


def test_the_best_come_first_with_scores_that_can_be_trusted(scan, part, cell):
    found = localize(scan, part, cell, seed=0)
    scores = [detection.score for detection in found]
    assert scores == sorted(scores, reverse=True)
    for detection in found:
        assert detection.part == part.name
        assert 0.3 < detection.score <= 1
        assert detection.score <= detection.visible + 1e-9
        assert 0 < detection.residual < 0.001


def test_the_same_scan_and_seed_give_the_same_poses(scan, part, cell):
    first, second = (localize(scan, part, cell, seed=4) for _ in range(2))
    assert [d.T_world_part.homogeneous.tolist() for d in first] == [
        d.T_world_part.homogeneous.tolist() for d in second
    ]


def test_another_seed_finds_the_same_parts(scan, part, cell, pile):
    for seed in (1, 2):
        counts, errors = compared(part, pile, localize(scan, part, cell, seed=seed))
        assert (counts["missed"], counts["ghosts"], counts["wrong"]) == (0, 0, 0)
        assert max(errors["distance"]) < 0.0005


def test_a_cloud_without_order_does_as_well(scan, part, cell, pile):
    shuffled = np.random.default_rng(0).permutation(scan.points)
    counts, errors = compared(
        part, pile, localize(Scan(shuffled, scan.T_world_scanner, "test"), part, cell, seed=0)
    )
    assert (counts["missed"], counts["ghosts"], counts["wrong"]) == (0, 0, 0)
    assert max(errors["distance"]) < 0.0005


def test_nothing_is_found_in_an_empty_bin(part, cell):
    assert localize(synthesize(cell, part, (), seed=0), part, cell, seed=0) == ()


def test_nothing_is_found_where_the_bin_is_not(scan, part, cell):
    elsewhere = replace(cell.bin, T_world_bin=pose_from_rpy((2, 0, 0)))
    assert localize(scan, part, replace(cell, bin=elsewhere), seed=0) == ()


@pytest.mark.parametrize("count", [1, 5, 50])
def test_a_few_points_are_no_part(part, cell, scan, count):
    few = Scan(scan.points[:: len(scan.points) // count][:count], scan.T_world_scanner, "test")
    assert localize(few, part, cell, seed=0) == ()


def test_noise_everywhere_is_no_part(part, cell, scan):
    points = np.random.default_rng(0).uniform([-0.1, -0.15, 0.85], [0.1, 0.15, 0.9], (20_000, 3))
    assert localize(Scan(points, scan.T_world_scanner, "test"), part, cell, seed=0) == ()


def test_roll_is_only_claimed_where_it_shows(cell, part):
    """Lying with the key upwards it shows; lying on the key nothing tells the roll."""
    down = []
    for roll in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        T = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.02), (np.pi / 2, 0, 0))
        T = T * pose_from_rpy((0, 0, 0), (0, 0, roll))
        (found,) = localize(synthesize(cell, part, (T,), seed=1), part, cell, seed=0)
        counts, _ = compared(part, (T,), (found,))
        assert counts["wrong"] == 0
        down.append(found.roll_known)
    assert any(down), "the key is never seen"
    assert not all(down), "the key is claimed to be seen through the part"


def test_progress_rises_to_the_end_and_cancelling_ends_it(scan, part, cell):
    told: list[float] = []
    localize(scan, part, cell, seed=0, report=lambda done, note: told.append(done))
    assert told == sorted(told)
    assert told[0] == 0.0
    assert 0.5 < told[-1] <= 1.0
    with pytest.raises(JobCancelled):
        localize(scan, part, cell, seed=0, cancelled=lambda: len(told) > 0)
