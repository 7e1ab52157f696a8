"""Insertions by physics against the error budgets, on few."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.model.errors import InputError
from workbench.studies.mating import PAIRS, Inserts, insert_parts


def test_a_joint_that_the_study_does_not_have_is_refused():
    with pytest.raises(InputError, match="'nut on bolt' is no joint of the study: peg in ring, "):
        insert_parts(Inserts("yumi", "nut on bolt", 1, 0))


@pytest.mark.parametrize("pair", PAIRS.values(), ids=PAIRS)
def test_the_parts_of_each_joint_meet_at_its_mouth(pair):
    """The leading end of the part is at the joint's depth when it is seated."""
    joint = pair.insertion.joint
    assert joint is not None
    ends = {"keyed_cylinder": (0, 0, -0.04), "bolt": (0, 0, 0.035), "spacer": (0, 0, -0.01)}
    end = pair.insertion.T_base_part.act(np.array(ends[pair.part]))
    mouth = np.array(joint.mouth)
    assert end == pytest.approx(mouth + joint.depth * np.array([0, 0, -1]))


@pytest.mark.extensive
def test_insertions_come_out_as_said_and_the_same_again():
    asked = Inserts("yumi", "cap on cylinder", 30, 5, wider=2.0)
    found = insert_parts(asked)
    assert abs(found.predicted - found.measured) < 0.25 and found.otherwise < 0.15
    assert insert_parts(asked) == found
    exact = insert_parts(replace(asked, wider=0.0, count=3))
    assert (exact.predicted, exact.by_rule, exact.measured) == (1.0, 1.0, 1.0)
