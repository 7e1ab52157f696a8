"""Features of point pairs: the bins of their angles."""

import numpy as np

from workbench.perception.parts.point_pairs import ANGLES, _angle


def test_angles_that_are_looked_up_fall_into_the_bins_of_the_arc_cosine():
    cosines = np.append(np.random.default_rng(0).uniform(-1.0, 1.0, 20_000), [-1.0, 0.0, 1.0])
    bins = np.minimum((np.arccos(cosines) / np.pi * ANGLES).astype(int), ANGLES - 1)
    assert [_angle(cosine) for cosine in cosines] == bins.tolist()
    assert _angle(1.0 + 1e-9) == 0 and _angle(-1.0 - 1e-9) == ANGLES - 1
