"""Artefacts of balls, and which ball a tool tip touches."""

import numpy as np
import pytest

from workbench.model.calibration import BallArtefact, BallScan
from workbench.model.errors import InputError


@pytest.mark.parametrize(
    ("lengths", "says"),
    [
        ([0.0], "more than the balls' diameter"),
        ([0.03], "more than the balls' diameter"),
        ([np.nan], "more than the balls' diameter"),
        ([6.0], "up to 5 m"),
        ([0.0, 0.0, 0.0], "longer than their diameter"),
        ([0.08, 0.1, np.nan], "longer than their diameter"),
        ([0.08, 0.1], "one length of a ball bar or three of a plate"),
        ([], "one length of a ball bar or three of a plate"),
    ],
)
def test_lengths_that_no_artefact_has_are_refused(lengths, says):
    with pytest.raises(InputError, match=says):
        BallArtefact(0.015, np.array(lengths))


@pytest.mark.parametrize("radius", [0.0, np.nan, 1.0])
def test_so_are_balls_that_nobody_has(radius):
    with pytest.raises(InputError, match="4 to 400 mm"):
        BallArtefact(radius, np.array([0.5]))


def test_a_bar_has_one_distance_and_a_plate_three():
    bar = BallArtefact(0.015, np.array([0.2]))
    scan = BallScan("scan 1", bar, bar.centres + 1.0, np.ones(2), np.ones(2))
    assert scan.measured == pytest.approx([0.2])
    plate = BallArtefact()
    scan = BallScan("scan 1", plate, plate.centres + 1.0, np.ones(3), np.ones(3))
    assert scan.measured == pytest.approx(plate.lengths)
    with pytest.raises(InputError, match="2 centres of balls"):
        BallScan("scan 1", bar, plate.centres, np.ones(3), np.ones(3))
