"""The nearest fix on the page: one press changes the grasp as it was tried, one takes it back."""

from dataclasses import replace

import pytest

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.picking.fixing import explain_fix, make_fix_command
from workbench.app.picking.judging import judge
from workbench.gui.scene.fix_inputs import FixInputs
from workbench.gui.shared.look import NO_HELP, Help
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import LIFT_NAMES
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import GraspLibrary, GraspPattern
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.model.plan import PlanResult
from workbench.planning.picking.nearest_fix import Fix, fix_words, nearest_fix


def too_deep(cell):
    """The cell with every grasp taken 9 mm deeper, so that the fingers reach the floor."""
    part = cell.parts[0]
    entries = tuple(
        with_grasp(
            entry,
            replace(
                grasp_of(entry),
                T_part_tcp=grasp_of(entry).T_part_tcp * pose_from_rpy((0, 0, 0.009)),
            ),
        )
        for entry in part.library.entries
    )
    assert any(isinstance(entry, GraspPattern) for entry in entries)
    return replace(cell, parts=(replace(part, library=GraspLibrary(entries)),))


@pytest.fixture(scope="module")
def deep(cell, detections):
    changed = too_deep(cell)
    return changed, judge(changed, detections)


@pytest.fixture
def stuck(bench, deep, scan, detections):
    """A bench with parts that nothing takes."""
    changed, candidates = deep
    bench.do(ChangeCell(changed, "deeper"), "Ada")
    bench.do(UseScan(scan), "Ada")
    number = bench.do(FindParts(), "Ada").number
    bench.do(JobEnded(number, detections), "worker")
    number = bench.do(MakePlan(), "Ada").number
    refused = Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE, ("finger", "bin_floor"), -0.001)
    bench.do(JobEnded(number, PlanResult(candidates, None, None, refused, {})), "worker")
    return bench


@pytest.fixture
def fix(stuck):
    state = stuck.state
    found = nearest_fix(state.cell, state.detections, state.candidates, seed=0)
    assert found is not None and found.grasp is not None
    return found


def press(button):
    for called in button._impl.update_cb:
        called(None)


def test_one_press_applies_what_was_tried_and_one_takes_it_back(stuck, visitor, view_of, fix):
    before = stuck.state.cell
    controls = FixInputs(visitor)
    help_ = Help(fix_words(fix), fix)
    assert not controls._wide.visible, "what follows takes its own columns"
    controls.show(None, view_of(stuck.state), help_)
    assert controls._wide.visible
    assert controls._apply.visible and not controls._undo.visible
    assert fix.candidate.grasp.name.split("-")[0] in controls._scope.content
    assert controls._scope.visible and "for every part of this kind" in controls._scope.content
    controls._press()
    state = stuck.state
    assert visitor.client.told == []
    assert state.candidates is None and state.detections is not None
    wanted = (fix.candidate.detection, fix.candidate.arm, fix.candidate.grasp.name)
    judged = {
        (one.detection, one.arm, one.grasp.name): one.verdict
        for one in judge(state.cell, state.detections)
    }
    assert judged[wanted].is_ok, judged[wanted]
    controls.show(None, view_of(state, visitor.look.now), NO_HELP)
    assert not controls._apply.visible and controls._undo.visible
    assert not controls._scope.visible and "Nearest fix applied to" in controls._applied.content
    press(controls._undo)
    assert stuck.state.cell.digest == before.digest
    controls.show(None, view_of(stuck.state, visitor.look.now), NO_HELP)
    assert not controls._undo.visible


def test_a_fix_of_candidates_that_were_judged_before_is_not_applied(stuck, fix):
    with pytest.raises(InputError, match="planned for again"):
        make_fix_command(replace(stuck.state, candidates=()), fix)


@pytest.mark.parametrize("change", [{"lifts": LIFT_NAMES}, {"near_margin": 0.0}])
def test_a_fix_of_the_policy_changes_that_alone(stuck, change):
    cell = stuck.state.cell
    policy = replace(cell.policy, **change)
    command = make_fix_command(
        stuck.state, Fix(stuck.state.candidates[0], "another policy", policy=policy)
    )
    assert isinstance(command, ChangeCell)
    assert command.cell.digest == replace(cell, policy=policy).digest


def test_before_the_press_a_fix_says_from_what_to_what_and_for_what(stuck, fix):
    state = stuck.state
    said = str(explain_fix(state, fix))
    edit = make_fix_command(state, fix)
    before, after = grasp_of(edit.was[0]), grasp_of(edit.now[0])
    moved = abs(after.T_part_tcp.translation - before.T_part_tcp.translation)
    assert edit.was[0].name in said and edit.part in said
    for name, old, new, step in zip(
        "xyz", before.T_part_tcp.translation, after.T_part_tcp.translation, moved, strict=True
    ):
        is_said = f"{name} from {old * 1000:.1f} mm to {new * 1000:.1f} mm" in said
        assert is_said == (step > 5e-5), said
    policy = replace(state.cell.policy, near_margin=0.0)
    of_cell = str(explain_fix(state, Fix(state.candidates[0], "another policy", policy=policy)))
    assert of_cell == (
        "Changes the whole cell, for all parts and arms: near_margin from 1.0 mm to 0.0 mm"
    )
    assert explain_fix(state, Fix(state.candidates[0], "by hand")) is None
