"""The line from detections to a plan, where there is nothing to choose from."""

from workbench.app.picking.pipeline import plan_pick
from workbench.model.candidate import Reason, Stage
from workbench.model.part import GraspLibrary
from workbench.model.part_edits import with_part


def test_parts_without_grasps_have_no_plan_and_the_verdict_says_why(cell, samples):
    bare = with_part(cell, "peg", library=GraspLibrary())
    result = plan_pick(bare, samples.detections(), "scan")
    assert (result.plan, result.candidates) == (None, ())
    assert (result.verdict.reason, result.verdict.stage) == (Reason.NO_GRASP, Stage.PROPOSE)
    assert "no grasp" in str(result.verdict)
