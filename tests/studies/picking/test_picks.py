"""What becomes of each part of a pile, as its candidates tell it."""

import pinocchio as pin

from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.part import Grasp
from workbench.studies.picking.picks import fates_of

GRASP = Grasp("side", pin.SE3.Identity(), 0.04, 0.03)


def judged(part: int, reason: Reason, stage: Stage) -> Candidate:
    return Candidate(part, GRASP, "right", pin.SE3.Identity(), 0.0, Verdict(reason, stage))


def test_one_grasp_that_works_is_enough_and_else_that_counts_which_got_furthest():
    candidates = (
        judged(0, Reason.TOOL_COLLISION, Stage.PROPOSE),
        judged(0, Reason.OK, Stage.PLACE),
        judged(1, Reason.NO_PLACE, Stage.PLACE),
        judged(1, Reason.EXTRACT_BLOCKED, Stage.EXTRACT),
        judged(3, Reason.TOOL_COLLISION, Stage.PROPOSE),
    )
    assert list(fates_of(candidates, 4)) == ["ok", "no place", "tool collision"]
    assert list(fates_of((), 4)) == []
