"""A refusal that may only come of bodies that are too large says so."""

from dataclasses import replace

import pinocchio as pin
import pytest

from workbench.app.picking.exactness import with_exactness
from workbench.app.picking.part_import import excess_of
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.messages.message import Message, all_of, plain
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.scan import Detection


@pytest.fixture(scope="module")
def cell():
    return replace(read_cell("yumi"), parts=(read_part("bracket"),))


CLOSED = plain("closed")


def noted(cell, distance: float, pair=("left finger_a", "part-1")) -> Message:
    part = cell.parts[0]
    verdict = Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, pair, distance, note=CLOSED)
    grasp = part.library.grasps[0]
    one = Candidate(0, grasp, "left", grasp.T_part_tcp, 0.0, verdict)
    found = (Detection(part.name, pin.SE3.Identity()),)
    return with_exactness(cell, found, (one,))[0].verdict.note


def test_a_refusal_within_what_the_bodies_are_too_large_says_so(cell):
    excess = excess_of(cell.parts[0])
    assert excess > 0.001, "its holes count as full"
    within = noted(cell, cell.policy.near_margin - excess / 2)
    assert within == all_of((CLOSED, VerdictNote.INEXACT(excess=excess)))


def test_a_refusal_that_is_deeper_says_nothing_more(cell):
    assert noted(cell, cell.policy.near_margin - 1.5 * excess_of(cell.parts[0])) == CLOSED


def test_a_refusal_in_which_no_part_is_named_says_nothing_more(cell):
    assert noted(cell, 0.0, ("left finger_a", "bin")) == CLOSED
