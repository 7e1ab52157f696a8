"""Bases found again for the study of mating, on few."""

import numpy as np
import pytest

from workbench.model.recipes.joint import PlacingError
from workbench.studies.mating import Inserts, insert_parts
from workbench.studies.seen_bases import see_again

OFF = PlacingError(np.zeros((6, 6)), np.diag(np.square([0.003, 0.003, 0.0, 0.01, 0.01, 0.0])))


@pytest.mark.parametrize("kind", ["spacer", "keyed_cylinder"])
def test_a_base_that_has_moved_is_known_better_than_it_was(kind):
    found = see_again("yumi", kind, [OFF], count=4, seed=2)
    assert len(found) >= 3
    for seen in found:
        assert seen.error.believed is OFF
        assert np.linalg.norm(seen.off[:3]) < 0.0005
        assert np.linalg.eigvalsh(seen.error.covariance[:3, :3])[-1] < 0.001**2
    again = see_again("yumi", kind, [OFF], count=4, seed=2)
    assert all(np.array_equal(a.off, b.off) for a, b in zip(found, again, strict=True))


def test_bases_that_have_moved_too_far_are_left_out():
    far = PlacingError(np.zeros((6, 6)), np.diag(np.square([1.0, 1.0, 0.0, 0.0, 0.0, 0.0])))
    assert see_again("yumi", "spacer", [far], count=2, seed=2) == []


@pytest.mark.extensive
def test_insertions_onto_bases_seen_again_state_the_share_without():
    asked = Inserts("yumi", "cap on cylinder", 12, 5, looks_again=True)
    found = insert_parts(asked)
    assert found.believed is not None and 0.9 < found.believed <= 1.0
    assert abs(found.predicted - found.measured) < 0.3 and found.unseen == 0
    assert insert_parts(Inserts("yumi", "cap on cylinder", 2, 5)).believed is None
