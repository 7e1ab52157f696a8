"""Parts that stay when a planning brings no plan: which, and what is in the way."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.statistics.remaining import Remaining, remaining, remaining_words
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.digest import canonical
from workbench.model.part import Grasp
from workbench.model.scan import Detection

HERE = pin.SE3.Identity()


def pile(count):
    return [
        canonical(Detection("peg", pin.SE3(np.eye(3), np.full(3, float(k))))) for k in range(count)
    ]


def candidates(*verdicts):
    """Candidates by number of the part, reason and the two bodies that meet."""
    return [
        canonical(
            Candidate(
                number,
                Grasp("top", HERE, 0.04, 0.03),
                "right",
                HERE,
                0.5,
                Verdict(reason, Stage.GRASP, pair),
            )
        )
        for number, reason, pair in verdicts
    ]


@pytest.mark.parametrize(
    ("reason", "pair", "hindrance"),
    [
        (Reason.TOOL_COLLISION, ("right palm", "bin_wall_back"), "walls"),
        (Reason.IN_COLLISION, ("right palm", "part-2"), "neighbours"),
        (Reason.TOOL_COLLISION, ("right palm", "bin_floor"), "floor"),
        (Reason.TOOL_COLLISION, ("right palm", "table_top"), "floor"),
        (Reason.TOOL_COLLISION, ("right palm", "camera_post"), "other"),
        (Reason.EXTRACT_BLOCKED, ("part-1", "part-2"), "ways"),
        (Reason.OUT_OF_REACH, None, "reach"),
        (Reason.ROLL_UNKNOWN, None, "other"),
    ],
)
def test_a_remaining_part_says_what_refused_its_candidates(reason, pair, hindrance):
    (left,) = remaining(pile(1), candidates((0, reason, pair)))
    assert (left.part, left.number, left.hindrance) == ("peg", 0, hindrance)


def test_grasps_from_below_do_not_hide_that_a_wall_is_in_the_way():
    floor = (0, Reason.TOOL_COLLISION, ("right palm", "bin_floor"))
    wall = (0, Reason.TOOL_COLLISION, ("right palm", "bin_wall_back"))
    (left,) = remaining(pile(1), candidates(floor, floor, floor, wall))
    assert left.hindrance == "walls"


def test_a_part_that_some_candidate_could_take_does_not_count():
    reach = (0, Reason.OUT_OF_REACH, None)
    assert not remaining(pile(1), candidates(reach, (0, Reason.OK, None)))
    (left,) = remaining(pile(2), candidates((0, Reason.OK, None), (1, *reach[1:])))
    assert left.number == 1 and len(left.pile) == 2


def test_a_part_without_a_grasp_counts_and_one_that_is_not_wanted_does_not():
    outside = (0, Reason.OUTSIDE_REGIONS, None)
    (left,) = remaining(pile(2), candidates(outside))
    assert (left.number, left.hindrance) == (1, "other")


def test_a_pile_that_is_planned_again_and_again_counts_once():
    gathered = Remaining()
    refused = {"plan": None, "candidates": candidates((0, Reason.OUT_OF_REACH, None))}
    gathered.add(pile(1), refused)
    gathered.add(pile(1), refused)
    assert len(gathered.value) == 1
    gathered.add(pile(2), {"plan": {}, "candidates": []})
    gathered.add(pile(1), refused)
    assert [str(said) for said in remaining_words(gathered.value)] == ["2 peg out of reach"]
