"""Grasps for parts that stayed: they come from where these parts lay."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.filling.for_remaining import families_for
from workbench.app.filling.keeping import MOST_GRASPS
from workbench.app.statistics.remaining import RemainingPart
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection

WORK = 12_000.0


@pytest.fixture(scope="module")
def bare():
    """The YuMi cell whose part has no grasps."""
    cell = read_cell("yumi")
    return replace(cell, parts=(replace(cell.parts[0], library=GraspLibrary()),))


@pytest.fixture(scope="module")
def left(bare):
    """Two cylinders: both lie on the floor, the second along a wall."""
    floor = bare.bin.T_world_bin.translation
    edge = bare.bin.size[0] / 2 - 0.022
    pile = tuple(
        Detection("keyed_cylinder", pose_from_rpy(floor + [x, y, 0.0191], (np.pi / 2, 0.0, 0.0)))
        for x, y in ((0.0, -0.05), (edge, 0.05))
    )
    return tuple(RemainingPart(pile, number, "walls") for number in range(2))


@pytest.fixture(scope="module")
def proposal(bare, left):
    return families_for(bare, "keyed_cylinder", left, most=WORK)


def test_new_families_take_the_parts_that_stayed(bare, left, proposal):
    assert (proposal.looked, proposal.known, proposal.added) == (2, 0, 2)
    part = replace(bare.parts[0], library=GraspLibrary(proposal.entries))
    again = families_for(replace(bare, parts=(part,)), part.name, left, most=WORK)
    assert (again.known, again.entries) == (2, ())


def test_a_proposal_stays_small(proposal):
    assert 0 < len(GraspLibrary(proposal.entries).grasps) <= MOST_GRASPS


def test_parts_among_kinds_that_the_cell_has_no_more_are_left_out(bare, left):
    other = Detection("gone", left[0].pile[0].T_world_part)
    among = tuple(replace(one, pile=(*one.pile, other)) for one in left)
    assert families_for(bare, "keyed_cylinder", among, most=WORK).looked == 0


def test_a_proposal_ends_when_it_is_cancelled(bare, left):
    with pytest.raises(JobCancelled):
        families_for(bare, "keyed_cylinder", left, cancelled=lambda: True)
