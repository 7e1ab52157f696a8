"""Parts in a bin that a hand goes through: what becomes of them."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Box, Solid
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.stirring import stirred

HAND = (Solid("paddle", Box(np.array([0.02, 0.05, 0.1])), pin.SE3.Identity()),)


@pytest.fixture(scope="module")
def heap(cell):
    return drop_parts((read_part("keyed_cylinder"),) * 4, cell.bin, seed=5)


def across(cell, height: float) -> list[pin.SE3]:
    """The hand along the bin's middle, its lower end at a height [m] above the floor."""
    x = float(cell.bin.size[0]) / 2 - 0.07
    ends = [np.array([end, 0.0, height + 0.05]) for end in (-x, x)]
    return [cell.bin.T_world_bin * pin.SE3(np.eye(3), end) for end in ends]


def moved(before, after) -> list[float]:
    return [
        float(np.linalg.norm(a.T_world_part.translation - b.T_world_part.translation))
        for a, b in zip(before, after, strict=True)
    ]


def test_a_hand_pushes_what_is_in_its_way_and_all_lie_still_afterwards(cell, heap):
    frames = stirred(cell, heap, HAND, across(cell, 0.005), np.array([0.0, 2.0]))
    assert len(frames) == 2 and frames[0] == tuple(heap)
    assert max(moved(heap, frames[-1])) > 0.02
    again = stirred(cell, frames[-1], HAND, across(cell, 0.3), np.array([0.0, 0.5]))
    assert max(moved(frames[-1], again[-1])) < 0.002


def test_a_hand_that_goes_over_them_moves_none(cell, heap):
    frames = stirred(cell, heap, HAND, across(cell, 0.3), np.array([0.0, 0.5]))
    assert max(moved(heap, frames[-1])) < 0.002


def test_the_same_way_has_the_same_end(cell, heap):
    ends = [
        stirred(cell, heap, HAND, across(cell, 0.01), np.array([0.0, 1.0]))[-1] for _ in range(2)
    ]
    assert max(moved(*ends)) == 0.0
