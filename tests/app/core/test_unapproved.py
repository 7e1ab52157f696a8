"""Vision only: approval may be switched off by an engineer, for poses alone and on record."""

from dataclasses import replace

import pytest

from workbench.app.core.command import Entry
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.unapproved import ReleasePoses, SwitchApproval
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.effects import Send
from workbench.app.core.people import NOBODY, Role
from workbench.app.core.session import opened_again
from workbench.app.core.state import Phase
from workbench.model.errors import CommandRefused, InputError
from workbench.plugins.robot_link import check_approval, controller_by

NOW = 1_000_000.0


def seeing(cell):
    """The cell by a robot link that sends poses alone."""
    motion = replace(cell.controller.motion, sends_poses=True)
    return replace(cell, controller=replace(cell.controller, motion=motion))


def after(state, command, actor="Ada", role=Role.ENGINEER, now=NOW):
    check_allowed(state, command, actor, now, role=role)
    return decide(state, Entry(state.number + 1, now, actor, command, role=role))


def refusal(state, command, actor="Ada", role=Role.ENGINEER, now=NOW):
    with pytest.raises(CommandRefused) as refused:
        after(state, command, actor, role, now)
    return str(refused.value)


@pytest.fixture
def approved(cell, samples):
    return samples.approved(cell)


@pytest.fixture
def planned(approved):
    """A plan that waits, in a cell whose link sends poses alone."""
    return replace(
        approved, cell=seeing(approved.cell), phase=Phase.PLANNED, approval=None, votes=()
    )


def robot(state, command, now=NOW):
    return after(state, command, "robot program", Role.OPERATOR, now)


def test_with_approval_on_nothing_goes_out_without_it(planned):
    assert "somebody has to approve" in refusal(planned, ReleasePoses(planned.plan.digest))
    assert refusal(planned, SendPlan(planned.plan.digest))


def test_only_a_named_engineer_switches_it_off(planned):
    assert "engineers" in refusal(planned, SwitchApproval(True), "robot program", Role.OPERATOR)
    assert "by their own name" in refusal(planned, SwitchApproval(True), NOBODY)
    assert "true or false" in refusal(planned, SwitchApproval("yes"))
    held = replace(planned, control="Bob")
    assert "in control" in refusal(held, SwitchApproval(True))


def test_no_link_that_sends_paths_lets_it_be_off(approved):
    assert "approval stays on" in refusal(approved, SwitchApproval(True))
    # Nor where it was off before the cell got another link.
    off = replace(approved, phase=Phase.PLANNED, approval=None, unapproved_by="Ada")
    assert "approval stays on" in refusal(off, ReleasePoses(off.plan.digest))


def test_what_goes_out_says_that_nobody_has_approved_it(planned):
    off, _ = after(planned, SwitchApproval(True))
    assert off.unapproved_by == "Ada" and "approved" in str(off.message)
    out, effects = robot(off, ReleasePoses(off.plan.digest))
    assert effects == () and out.phase is Phase.APPROVED
    assert out.approval.is_switched_off and out.approval.people == ()
    assert "nothing of the robot's motion is proven" in str(out.message)
    sent, (effect,) = robot(out, SendPlan(out.plan.digest))
    assert isinstance(effect, Send) and effect.approval is out.approval
    assert "poses" in str(sent.message) and "proven" in str(sent.message)
    check_approval(out.plan, out.approval, out.cell, NOW)


def test_such_a_release_lets_no_path_out(planned, approved):
    off, _ = after(planned, SwitchApproval(True))
    out, _ = robot(off, ReleasePoses(off.plan.digest))
    paths = replace(out, cell=approved.cell)
    assert "nobody has approved" in refusal(paths, SendPlan(out.plan.digest))
    with pytest.raises(CommandRefused, match="nobody has approved"):
        check_approval(out.plan, out.approval, approved.cell, NOW)


def test_it_runs_out_and_ends_with_the_switch_and_with_the_session(planned):
    off, _ = after(planned, SwitchApproval(True))
    out, _ = robot(off, ReleasePoses(off.plan.digest))
    assert "approv" in refusal(out, SendPlan(out.plan.digest), now=NOW + 1e6)
    on, _ = after(out, SwitchApproval(False))
    assert on.phase is Phase.PLANNED and on.approval is None and not on.unapproved_by
    assert "somebody has to approve" in refusal(on, ReleasePoses(on.plan.digest))
    assert opened_again(off).unapproved_by == ""


def test_another_plan_and_a_plan_that_is_not_proven_are_not_released(planned):
    off, _ = after(planned, SwitchApproval(True))
    assert refusal(off, ReleasePoses("0" * 64))
    assert refusal(replace(off, proof=None), ReleasePoses(off.plan.digest))
    assert refusal(replace(off, scene_digest="0" * 64), ReleasePoses(off.plan.digest))


def test_people_may_approve_all_the_same(planned):
    off, _ = after(planned, SwitchApproval(True))
    seen = replace(off, watched=("Ada",))
    approved, _ = after(seen, Approve(off.plan.digest))
    assert approved.approval.people == ("Ada",) and not approved.approval.is_switched_off


def test_an_option_makes_a_controller_of_poses_and_others_are_refused():
    assert not controller_by("pick-server").motion.sends_poses
    by_poses = controller_by("pick-server", options={"poses": "kuka"}).motion
    # The robot's own program sets the speed: nobody is offered a slower one.
    assert by_poses.sends_poses and not by_poses.takes_share
    with pytest.raises(InputError, match="poses"):
        controller_by("pick-server", options={"poses": "martian"})
