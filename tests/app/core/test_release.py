"""Nothing goes out before it was watched, by enough people, from where the robot stands."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from line import NOW, Line, planned_line, refused

from workbench.app.core.cell.changes import CellRead, ChangeCell, UndoCell, cell_read
from workbench.app.core.cycle.approval import Approve, approve, staleness
from workbench.app.core.cycle.planning import MakePlan, WantThreshold
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.standing import moved_away, start_of
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.effects import Send
from workbench.app.core.people import is_same_person
from workbench.app.core.state import Phase
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import CommandRefused
from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Sphere, pose_from_rpy
from workbench.model.release import Vote
from workbench.planning.kinematics.robot import Kinematics


@pytest.fixture
def line(samples, cell) -> Line:
    return planned_line(samples, cell)


@pytest.fixture
def watched(line) -> Line:
    line.do(WatchPlan(line.state.plan.digest))
    return line


@pytest.mark.parametrize("name", ["operator", "Operator", " ｏperator "])
def test_nobody_approves_as_who_has_no_login(watched, name):
    said = refused(watched, Approve(watched.state.plan.digest), name)
    assert "a person approves by their own name" in said


@pytest.fixture
def by_two(samples, cell) -> Line:
    """A watched plan in a cell that wants two people; its digest is that of the cell with one."""
    line = planned_line(samples, replace(cell, approvers=2))
    line.do(WatchPlan(line.state.plan.digest), "operator")
    return line


def moved(cell, millimetres):
    away = pose_from_rpy(cell.bin.T_world_bin.translation + [millimetres / 1000, 0, 0])
    return replace(cell, bin=replace(cell.bin, T_world_bin=away))


# -- the preview


def test_a_plan_that_nobody_has_watched_is_not_approved(line):
    digest = line.state.plan.digest
    assert "has not been played to its end" in refused(line, Approve(digest))
    line.do(WatchPlan(digest), "bob")
    assert "has not been played to its end" in refused(line, Approve(digest), "ada")
    assert line.do(Approve(digest), "Bob").phase is Phase.APPROVED


def test_what_played_in_a_browser_without_a_login_was_watched_by_whoever_was_there(line):
    digest = line.state.plan.digest
    line.do(WatchPlan(digest), "operator")
    line.do(WatchPlan(digest), "operator")
    assert line.state.watched == ("operator",)
    assert line.do(Approve(digest), "ada").phase is Phase.APPROVED


def test_what_only_a_program_says_was_watched_is_on_record_as_that(line):
    digest = line.state.plan.digest
    line.do(WatchPlan(digest, is_reported=True), "bob")
    state = line.do(Approve(digest), "bob")
    assert state.approval.is_unwatched
    assert "no page has shown it to bob" in str(state.message)
    assert state.watched_elsewhere == ("bob",)


def test_a_page_that_has_shown_the_plan_makes_up_for_what_a_program_said(line):
    digest = line.state.plan.digest
    line.do(WatchPlan(digest, is_reported=True), "bob")
    line.do(WatchPlan(digest), "bob")
    line.do(WatchPlan(digest, is_reported=True), "bob")
    assert line.state.watched_elsewhere == ()
    assert not line.do(Approve(digest), "bob").approval.is_unwatched


def test_of_two_people_one_who_has_not_seen_it_is_enough_to_say_so(samples, cell):
    line = planned_line(samples, replace(cell, approvers=2))
    digest = line.state.plan.digest
    line.do(WatchPlan(digest), "ada")
    line.do(WatchPlan(digest, is_reported=True), "bob")
    line.do(Approve(digest), "bob")
    state = line.do(Approve(digest), "ada")
    assert state.approval.is_unwatched
    assert str(state.message).endswith("no page has shown it to bob")


def test_another_plan_has_to_be_watched_again(watched, samples):
    watched.do(MakePlan(seed=1))
    other = samples.planned(watched.state.scene_digest, seed=1)
    watched.ended(other)
    assert watched.state.watched == watched.state.watched_elsewhere == ()
    assert "has not been played" in refused(watched, Approve(other.plan.digest))
    assert "the current plan is" in refused(watched, WatchPlan("0" * 64))


# -- two people


@pytest.mark.parametrize("again", ["Ada", "ada", " ADA", "Ａda"])
def test_one_person_is_not_two_whoever_counts(samples, cell, again):
    line = planned_line(samples, replace(cell, approvers=2))
    state = line.state

    def approved(other):
        vote = Vote(state.plan.digest, other, NOW)
        return approve(state.cell, state.plan, state.proof, "Ada", NOW, (vote,))

    with pytest.raises(CommandRefused, match="2 different people"):
        approved(again)
    assert approved("Bob").people == ("Bob", "Ada")


def test_the_number_of_people_changes_no_plan(cell):
    assert replace(cell, approvers=2).digest == cell.digest


def test_the_first_of_two_words_is_kept_and_the_second_approves(by_two):
    digest = by_two.state.plan.digest
    state = by_two.do(Approve(digest), "Ada")
    assert (state.phase, state.approval) == (Phase.PLANNED, None)
    assert str(state.message) == "approved by Ada, 1 of 2 people"
    assert "have the plan approved first" in refused(by_two, SendPlan(digest))
    by_two.now += 60
    state = by_two.do(Approve(digest), "Bob")
    assert state.phase is Phase.APPROVED
    assert state.approval.people == ("Ada", "Bob")
    assert state.approval.until == NOW + 300, "the first word decides the end"
    assert by_two.do(SendPlan(digest)).phase is Phase.SENDING


@pytest.mark.parametrize("name", ["Ada", "ada", " ADA ", "Ａｄａ"])
def test_one_person_does_not_count_twice(by_two, name):
    digest = by_two.state.plan.digest
    by_two.do(Approve(digest), "Ada")
    assert "has approved already; 2 different people have to" in refused(
        by_two, Approve(digest), name
    )
    assert is_same_person("Ada  Lovelace", "ada lovelace")
    assert not is_same_person("Ada", "Adam")


def test_a_first_word_lapses_and_the_second_becomes_the_first(by_two):
    digest = by_two.state.plan.digest
    by_two.do(Approve(digest), "Ada")
    by_two.now += 301
    state = by_two.do(Approve(digest), "Bob")
    assert state.approval is None
    assert [vote.actor for vote in state.votes] == ["Bob"]
    assert by_two.do(Approve(digest), "Ada").approval.people == ("Bob", "Ada")


def test_words_do_not_outlive_the_plan_they_were_given_for(by_two, samples):
    by_two.do(Approve(by_two.state.plan.digest), "Ada")
    by_two.do(MakePlan())
    by_two.ended(samples.planned(by_two.state.scene_digest))
    by_two.do(WatchPlan(by_two.state.plan.digest), "operator")
    state = by_two.do(Approve(by_two.state.plan.digest), "Bob")
    assert (state.approval, len(state.votes)) == (None, 1)


def test_an_approval_by_one_does_not_do_for_two(by_two, cell):
    state = by_two.state
    with pytest.raises(CommandRefused, match="wants 2 different people"):
        approve(state.cell, state.plan, state.proof, "ada", NOW)
    one = approve(cell, state.plan, state.proof, "ada", NOW)
    said = staleness(one, state.plan, state.cell, state.scene_digest, NOW)
    assert "wants 2 different people" in str(said)


def test_a_cell_file_that_wants_more_people_takes_an_approval_back(watched, cell):
    digest = watched.state.plan.digest
    watched.do(Approve(digest))
    state = watched.do(CellRead(replace(cell, approvers=2)), "cell file")
    assert (state.phase, state.approval, state.cell.approvers) == (Phase.PLANNED, None, 2)
    assert state.plan.digest == digest, "nothing else has changed"
    assert str(state.message) == "a plan needs 2 different approvers now"


def test_no_change_on_the_page_and_no_undo_asks_fewer_people(watched, cell):
    watched.do(ChangeCell(moved(cell, 5), "the bin was moved"))
    watched.do(CellRead(replace(watched.state.cell, approvers=2)), "cell file")
    assert watched.do(UndoCell()).cell.approvers == 2
    assert watched.do(ChangeCell(moved(cell, 7), "moved again")).cell.approvers == 2
    state, _ = cell_read(watched.state, CellRead(replace(moved(cell, 9), approvers=3)))
    assert (state.cell.approvers, state.cell.digest) == (3, moved(cell, 9).digest)


# -- where the robot stands


def test_a_plan_starts_where_its_first_leg_does(line):
    assert start_of(line.state.cell, line.state.plan, "right") == pytest.approx([0.0])


@pytest.mark.parametrize(("share", "is_away"), [(0.0, False), (0.95, False), (1.1, True)])
def test_a_robot_elsewhere_makes_the_plan_stale_and_says_by_how_much(watched, share, is_away):
    """The arm is one joint in the middle of a cube of 100 mm: its corners are 86.6 mm away."""
    digest = watched.state.plan.digest
    watched.do(Approve(digest))
    off = share * watched.state.cell.policy.margin / (0.05 * np.sqrt(3))
    watched.joints = {"joint_1": -off}
    if not is_away:
        assert watched.do(SendPlan(digest)).phase is Phase.SENDING
        return
    said = refused(watched, SendPlan(digest))
    assert f"axis 1 of the right arm stands {np.rad2deg(off):.2f} deg" in said
    assert "may be 5.5 mm away; 5.0 mm are allowed (margin_mm)" in said
    assert said in refused(watched, Approve(digest))
    watched.joints = {"joint_1": 0.0}
    assert watched.do(SendPlan(digest)).phase is Phase.SENDING


def corners(shape):
    """Points (n, 3) [m] of a shape that are far from its middle."""
    match shape:
        case Box(size=size):
            return np.array(list(product((-0.5, 0.5), repeat=3))) * size
        case Mesh(points=points):
            return points
        case Sphere(radius=radius):
            return radius * np.vstack([np.eye(3), -np.eye(3)])
        case Cylinder(radius=radius, length=length) | Capsule(radius=radius, length=length):
            ends = list(product((-radius, radius), (0.0,), (-length / 2, length / 2)))
            return np.array(ends + [(y, x, z) for x, y, z in ends])


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_where_a_robot_may_begin_no_point_of_it_is_beyond_the_margin(name, line):
    """Corners of all links and tools, where Pinocchio has them, for the largest way allowed."""
    cell = read_cell(name)
    kinematics, draw = Kinematics(cell), np.random.default_rng(3)
    arm = cell.arms[0]
    start = replace(line.state.plan, sequence=())  # so that all arms begin at home

    def points(q):
        poses = kinematics.link_poses(dict(zip(arm.joints, q, strict=True)))
        solids = [(poses[link.name], one) for link in cell.robot.links for one in link.collision]
        solids += [(poses[arm.flange], one) for one in arm.tool.body]
        far = [T.act(s.T_owner_shape.act(p)) for T, s in solids for p in corners(s.shape)]
        return np.array(far)

    home, most = points(arm.home), 0.0
    for _ in range(40):
        way = draw.normal(size=len(arm.joints)) * draw.choice([0.0, 1.0], len(arm.joints))
        low, high = 0.0, 1.0
        for _ in range(30):
            middle = (low + high) / 2
            joints = dict(zip(arm.joints, arm.home + middle * way, strict=True))
            low, high = (low, middle) if moved_away(cell, start, joints) else (middle, high)
        shift = np.linalg.norm(points(arm.home + low * way) - home, axis=1).max()
        assert shift <= cell.policy.margin
        most = max(most, shift)
    assert most > cell.policy.margin / 3


def test_a_joint_whose_report_is_no_number_does_not_let_a_plan_out(watched):
    digest = watched.state.plan.digest
    watched.do(Approve(digest))
    watched.joints = {"joint_1": float("nan")}
    assert "axis 1 of the right arm" in refused(watched, SendPlan(digest))


def test_joints_that_nobody_reports_are_not_compared(line):
    assert moved_away(line.state.cell, line.state.plan, {"other": 3.0}) is None


# -- the threshold, the scan, the cell


def test_another_threshold_makes_the_plan_stale_until_it_is_the_same_again(watched):
    digest = watched.state.plan.digest
    watched.do(Approve(digest))
    watched.do(WantThreshold(0.15))
    said = refused(watched, SendPlan(digest))
    assert "made with a threshold of 200 mm, now it is 150 mm" in said
    assert said == refused(watched, Approve(digest))
    watched.do(WantThreshold(0.2))
    assert watched.do(SendPlan(digest)).phase is Phase.SENDING


def test_a_plan_with_the_new_threshold_is_fresh(watched, samples):
    watched.do(WantThreshold(0.15))
    watched.do(MakePlan(threshold=0.15))
    state = watched.ended(samples.planned(watched.state.scene_digest))
    watched.do(WatchPlan(state.plan.digest))
    assert watched.do(Approve(state.plan.digest)).phase is Phase.APPROVED


def test_the_state_says_what_has_overtaken_the_plan(watched, cell, samples):
    digest = watched.state.plan.digest[:12]
    before = watched.state
    state = watched.do(ChangeCell(moved(cell, 5), "the bin is moved"))
    assert str(state.stale) == f"plan {digest} is stale: the bin was moved by 5.0 mm"
    watched.state = before
    state = watched.do(UseScan(samples.scan(3)))
    assert str(state.stale) == f"plan {digest} is stale: there is a newer scan"
    assert (state.plan, state.approval, state.watched, state.votes) == (None, None, (), ())
    assert not [effect for effect in watched.effects if isinstance(effect, Send)]


def test_once_parts_are_taken_no_scan_before_is_merged_with_the_next(watched):
    state, plan = watched.state, watched.state.plan.digest
    watched.state = replace(state, earlier=state.scan)
    assert watched.do(Approve(plan)).earlier is state.scan
    assert watched.do(SendPlan(plan)).earlier is None
