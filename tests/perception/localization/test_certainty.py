"""What a detection says of itself: chances that rise with what speaks for it, and covariances."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from scipy.ndimage import gaussian_filter
from searching import localize

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.localization.certainty import count_shared, probability_of
from workbench.perception.matching.pose_error import mahalanobis_squared
from workbench.perception.matching.sightings import Sighting
from workbench.perception.simulation.noise_models import NOISE_MODELS
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.studies.localization import DEVIATIONS
from workbench.studies.seeing.absent import AbsentTask, search_absent


def test_chances_rise_with_the_ratio_and_are_never_sure():
    chances = [probability_of(ratio, 0.9) for ratio in np.linspace(0.0, 0.5, 11)]
    assert chances == sorted(chances)
    assert 0.5 < chances[0] < 0.95 < chances[-1] < 1.0


def test_chances_are_less_where_much_else_lies():
    chances = [probability_of(0.1, explained) for explained in (0.0, 0.1, 0.3, 0.6, 0.9)]
    assert chances == sorted(chances)
    assert chances[1] < 0.5 < 0.9 < chances[-1]
    # What is met closely is a part among whatever else.
    assert probability_of(0.45, 0.1) > 0.9


def test_a_piece_of_rubbish_that_is_met_poorly_is_no_part():
    task = AbsentTask("yumi", "rubbish", "", "spacer", "rough", 300064)
    assert search_absent(task).false_alarms == 0


def seen_with(errors):
    """A sighting whose points are all explained, off by errors (h, w) [m]."""
    none = np.arange(0)
    return Sighting(np.arange(errors.size), errors.ravel(), none, none > 0, none, np.zeros(0))


def test_points_whose_errors_are_alike_count_as_fewer():
    noise = np.random.default_rng(0).normal(0.0, 0.001, (60, 80))
    assert 1.0 <= count_shared(seen_with(noise), 80) < 1.3
    assert 6.0 < count_shared(seen_with(gaussian_filter(noise, 1.0)), 80) < 13.0
    assert count_shared(seen_with(np.full((60, 80), 0.001)), 80) > 20.0


def test_where_errors_are_shared_the_roll_of_a_hexagon_is_not_known(cell):
    """Averaged over neighbours, six faces of a bolt's head tell its turn to some degrees."""
    bolt = read_part("bolt")
    known = {}
    for name in ("rough", "time_of_flight"):
        scanner = replace(cell.scanner, depth_noise=DEVIATIONS[name])
        there = replace(cell, parts=(bolt,), scanner=scanner)
        truth = drop_parts((bolt,) * 4, cell.bin, seed=3)
        scan = synthesize(there, truth, seed=3, noise=NOISE_MODELS[name])
        known[name] = [one.roll_known for one in localize(scan, bolt, there, seed=0)]
    assert known["rough"].count(True) >= 3
    assert known["time_of_flight"].count(False) >= 3


@pytest.fixture(scope="module")
def plate(part):
    """A plate of three sides of different length."""
    box = trimesh.creation.box((0.08, 0.05, 0.01))
    return replace(part, name="plate", mesh=Mesh(np.asarray(box.vertices), np.asarray(box.faces)))


def found_at(cell, plate, turn):
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.005), (0.0, 0.0, turn))
    there = replace(cell, parts=(plate,))
    truth = (Detection("plate", T),)
    (found,) = localize(synthesize(there, truth, seed=2), plate, there, seed=0)
    return T, found


def test_a_plate_is_known_best_along_its_normal(cell, plate):
    """Its face says how high it lies and how tilted, its edges alone where and how turned."""
    _, found = found_at(cell, plate, 0.0)
    variances = np.diag(found.covariance)
    assert found.covariance == pytest.approx(found.covariance.T, abs=1e-12)
    assert np.linalg.eigvalsh(found.covariance).min() > 0
    assert variances[2] < variances[:2].min() / 4
    assert variances[3:5].max() < variances[5]
    place, turn = found.deviations
    assert np.sqrt(variances[:3].max()) <= place < 0.001
    assert np.sqrt(variances[3:].max()) <= turn < 0.03


def test_the_covariance_turns_with_the_world(cell, plate):
    """Of a cell that stands elsewhere, turned by a quarter, x and y change places."""
    T, found = found_at(cell, plate, 0.3)
    off = T.translation - found.T_world_part.translation
    assert off @ np.linalg.solve(found.covariance[:3, :3], off) < 11.3
    quarter = pose_from_rpy((0.5, 0.2, 0.0), (0.0, 0.0, np.pi / 2))
    bin = replace(cell.bin, T_world_bin=quarter * cell.bin.T_world_bin)
    mount = replace(cell.scanner, T_world_scanner=quarter * cell.scanner.T_world_scanner)
    elsewhere = replace(cell, bin=bin, scanner=mount, fixtures=())
    _, other = found_at(elsewhere, plate, 0.3)
    R = np.kron(np.eye(2), quarter.rotation)
    assert R @ found.covariance @ R.T == pytest.approx(other.covariance, rel=0.5, abs=3e-8)


def test_errors_are_taken_over_the_covariance_and_under_the_symmetry(plate, part):
    T = pose_from_rpy((0.4, 0.1, 0.0), (0.2, 0.1, 0.5))
    covariance = np.diag([1e-6, 4e-6, 1e-6, 1e-4, 1e-4, 4e-4])
    moved = pose_from_rpy((0.401, 0.102, 0.0), (0.2, 0.1, 0.5))
    assert mahalanobis_squared(plate, T, moved, covariance) == (pytest.approx(2.0), 6)
    turned = T * pose_from_rpy((0, 0, 0), (0, 0, 0.9))
    assert mahalanobis_squared(part, T, turned, covariance)[0] > 100
    unknown = mahalanobis_squared(part, T, turned, covariance, roll_known=False)
    assert unknown == (pytest.approx(0.0, abs=0.02), 5)


ACROSS = SymmetryAxis(np.array([1.0, 0.0, 0.0]), 0)


@pytest.mark.extensive
@pytest.mark.parametrize(
    ("symmetry", "freedom"),
    [
        (Symmetry(), 6),
        (Symmetry(fold=2), 6),
        (Symmetry(fold=0), 5),
        (Symmetry(fold=0, also=(ACROSS,)), 3),
    ],
)
def test_squared_errors_have_as_many_degrees_of_freedom_as_they_are_large(plate, symmetry, freedom):
    """Normal errors as a covariance has them: their mean is the degrees of freedom."""
    draw, count = np.random.default_rng(freedom), 150
    one, T = replace(plate, symmetry=symmetry), pose_from_rpy((0.4, 0.1, 0.0), (0.2, 0.1, 0.5))
    mixed = draw.normal(size=(6, 6)) * np.array([1e-3] * 3 + [2e-2] * 3)[:, None]
    covariance = mixed @ mixed.T
    squares = []
    for error in draw.multivariate_normal(np.zeros(6), covariance, count):
        found = pin.SE3(pin.exp3(error[3:]) @ T.rotation, T.translation + error[:3])
        square, told = mahalanobis_squared(one, T, found, covariance)
        assert told == freedom
        squares.append(square)
    # Three times the deviation of a mean of chi-squared.
    assert np.mean(squares) == pytest.approx(freedom, abs=3 * np.sqrt(2 * freedom / count))
