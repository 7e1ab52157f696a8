"""The noise of a scanner, told by one of its scans."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.perception.scene.sensor import sensor_model
from workbench.perception.simulation.noise_models import FINE_SCANNER, ROUGH
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture(scope="module")
def heap():
    cell, part = read_cell("yumi"), read_part("bracket")
    cell = replace(cell, parts=(part,))
    return cell, drop_parts((part,) * 8, cell.bin, seed=6)


@pytest.mark.parametrize("deviation", [0.0002, 0.0006, 0.0015])
@pytest.mark.parametrize("noise", [FINE_SCANNER, ROUGH], ids=["fine", "rough"])
def test_noise_is_told_under_heaps_shadows_and_mistakes(heap, deviation, noise):
    cell, truth = heap
    cell = replace(cell, scanner=replace(cell.scanner, depth_noise=deviation))
    told = sensor_model(synthesize(cell, truth, seed=6, noise=noise).points).noise
    assert told == pytest.approx(deviation, rel=0.15)


def test_an_order_of_points_makes_no_difference(heap):
    cell, truth = heap
    points = synthesize(cell, truth, seed=6).points
    shuffled = np.random.default_rng(0).permutation(points)
    assert sensor_model(shuffled).noise == pytest.approx(sensor_model(points).noise, rel=0.05)


def plane(step=0.0, count=300):
    """A tilted plane, in patches of 4 by 4 points whose depths are off together."""
    generator = np.random.default_rng(0)
    u, v = np.meshgrid(np.linspace(-0.3, 0.3, count), np.linspace(-0.3, 0.3, count))
    z = 1.0 / (1.0 + 0.03 * u - 0.02 * v)
    patches = generator.standard_normal((count // 4 + 1, count // 4 + 1))
    z = z + step * np.kron(patches, np.ones((4, 4)))[:count, :count] * z**2
    z = z + 0.0001 * generator.standard_normal(z.shape)
    return np.stack([u * z, v * z, z], axis=-1).reshape(-1, 3)


def test_errors_that_neighbours_share_count_too():
    assert sensor_model(plane()).noise == pytest.approx(0.0001, rel=0.15)
    assert sensor_model(plane(step=0.0004)).noise > 0.0003


@pytest.mark.parametrize("count", [0, 1, 150])
def test_a_few_points_tell_nothing(count):
    few = sensor_model(np.random.default_rng(0).uniform(0.5, 1.0, (count, 3)))
    assert few.noise is None
    assert few.deviation(2.0, otherwise=0.001) == pytest.approx(0.004)


def test_points_beside_and_behind_the_scanner_are_left_out():
    points = np.vstack([plane(), [[0.1, 0.1, 0.0], [0.1, 0.1, -1.0]]])
    assert sensor_model(points).noise == pytest.approx(0.0001, rel=0.15)


def test_points_in_one_direction_tell_nothing():
    assert sensor_model(np.tile([0.1, 0.2, 1.0], (1000, 1))).noise is None


def test_a_stray_point_beside_the_scanner_changes_nothing():
    stray = np.array([[0.1, -0.1, 1e-6]])
    alone = sensor_model(plane(step=0.0004)).noise
    assert sensor_model(np.vstack([stray, plane(step=0.0004)])).noise == alone
