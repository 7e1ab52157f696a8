"""Parts that no grasp brings to their place: put on a station, and taken anew from there."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.core.cycle.standing import left_on_station
from workbench.app.picking.judging import judge
from workbench.app.picking.proving import prove as prove_alone
from workbench.app.picking.row import plan_row, prove_row
from workbench.app.picking.stations import put_down, station_problems
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.certificates import read_certificate, write_certificate
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.candidate import Reason
from workbench.model.derived.row_parts import parts_taken
from workbench.model.digest import digest_of
from workbench.model.errors import JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.proofs import ProofText
from workbench.model.scan import Detection, Scene
from workbench.proof.claims.prove import prove, scene_after


def lying(cell, x, y, yaw):
    place = cell.bin.T_world_bin.translation + np.array([x, y, 0.0191])
    return Detection("keyed_cylinder", pose_from_rpy(place, (np.pi / 2, 0.0, yaw)), 0.9)


@pytest.fixture(scope="module")
def cell():
    return read_cell("robots/yumi/regrasp.toml")


@pytest.fixture(scope="module")
def parts(cell):
    return (lying(cell, 0.03, -0.05, 0.4), lying(cell, -0.05, 0.09, 2.0))


def asked(cell, parts, **about):
    return plan_row(cell, parts, digest_of(parts), **about)


def scene(parts):
    return Scene(digest_of(parts), parts)


@pytest.fixture(scope="module")
def one(parts):
    return parts[:1]


@pytest.fixture(scope="module")
def row(cell, one):
    return asked(cell, one)


def test_no_grasp_brings_the_part_to_its_place_directly(cell, one):
    found = judge(replace(cell, stations=()), one)
    reasons = {candidate.verdict.reason for candidate in found}
    assert Reason.NO_PLACE in reasons and Reason.OK not in reasons
    alone = asked(replace(cell, stations=()), one)
    assert alone.plan is None and alone.verdict.reason is Reason.NO_PLACE


def test_over_the_station_it_comes_to_stand_where_it_shall(cell, row):
    first, second = row.plans
    assert row.proof.holds and all(proven.proof.holds for proven in row.row)
    assert (first.arms[0].station, second.arms[0].station) == ("post", "")
    assert first.notes == (PlanNote.PUT_ON_STATION(station="post"),)
    assert second.notes == (PlanNote.TAKEN_FROM_STATION(station="post"),)
    keeps = replace(cell, arms=tuple(replace(arm, keeps_parts=True) for arm in cell.arms))
    (stands,) = put_down(keeps, second)
    shall = cell.arm(second.arms[0].arm).part_places[0].T_world_part
    off = shall.actInv(stands.T_world_part)
    assert np.linalg.norm(off.translation) < 0.0005
    assert np.linalg.norm(pin.log3(off.rotation)) < np.deg2rad(0.1)


def test_both_plans_take_the_part_that_the_scan_has(row):
    assert [parts_taken(row.plan, plan) for plan in row.plans] == [(0,), (0,)]


def test_one_arm_hands_the_part_to_the_other_over_the_station(row):
    first, second = row.plans
    assert first.arms[0].arm != second.arms[0].arm


@pytest.mark.parametrize("arm", ["right", "left"])
def test_an_arm_alone_takes_the_part_anew_by_another_grasp(cell, arm):
    """On a post beside the bin, on the arm's own side."""
    side = -1.0 if arm == "right" else 1.0
    post = next(fixture for fixture in cell.fixtures if fixture.name == "post")
    aside = replace(post, T_world_fixture=pose_from_rpy((0.46, 0.22 * side, 0.1)))
    fixtures = tuple(aside if one is post else one for one in cell.fixtures)
    cell = replace(cell, fixtures=fixtures)
    row = asked(cell, (lying(cell, -0.02, 0.02 * side, 0.4),), strategy=arm)
    assert [plan.strategy for plan in row.plans] == [arm, arm]
    assert row.proof.holds and row.row[0].proof.holds
    first, second = (plan.arms[0] for plan in row.plans)
    assert not first.T_tcp_part.isApprox(second.T_tcp_part, 1e-3)


def test_the_same_plans_come_out_again(cell, one, row):
    assert [plan.digest for plan in asked(cell, one).plans] == [plan.digest for plan in row.plans]


def test_two_arms_at_once_are_not_asked_to_regrasp(cell, one):
    assert asked(cell, one, strategy="alternated").plan is None


def test_the_search_is_ended_by_who_has_asked_for_it(cell, one):
    looks = iter(range(100))
    told: list[float] = []

    def report(done, note):
        told.append(done)

    with pytest.raises(JobCancelled):
        asked(cell, one, report=report, cancelled=lambda: next(looks) > 60)
    assert told and all(0.0 <= done <= 1.0 for done in told)


def test_the_second_plan_alone_is_no_plan(cell, one, row, tmp_path):
    second = row.row[0].plan
    for known in (None, one, ()):
        proof = prove_alone(cell, second, detections=known)
        assert "part-1 of the plan is not where a plan before puts it" in str(proof.violations)
    (alone,) = prove_row(cell, (second,))
    assert not alone.proof.holds
    turned = prove_row(cell, (second, row.plan))
    assert len(turned) == 1 and not turned[0].proof.holds


def test_the_second_plan_after_another_one_is_no_plan(cell, parts, one, row):
    elsewhere = asked(
        cell, (replace(one[0], T_world_part=lying(cell, 0.0, 0.0, 0.9).T_world_part),)
    )
    said = prove_row(cell, (elsewhere.plan, row.row[0].plan))
    assert said[0].proof.holds and not said[1].proof.holds
    assert "not where a plan before puts it" in str(said[1].proof.violations)


def test_a_part_that_is_said_to_stand_elsewhere_is_not_there(cell, row):
    second = row.row[0].plan
    there = second.detections[0]
    moved = replace(there, T_world_part=there.T_world_part * pose_from_rpy((0.0, 0.0, 1e-6)))
    found = replace(there, T_world_found=None)
    other = replace(there, T_world_found=there.T_world_part)
    for said in (moved, found, other):
        bent = replace(second, detections=(said,))
        proofs = prove_row(cell, (row.plan, bent))
        assert not proofs[1].proof.holds


def test_plans_in_files_are_those_that_were_made(cell, row, tmp_path):
    for number, (plan, proof) in enumerate(
        [(row.plan, row.proof), (row.row[0].plan, row.row[0].proof)]
    ):
        path = tmp_path / f"plan-{number}.json"
        write_plan(path, plan, proof)
        again, stated = read_plan(path)
        assert again.digest == stated == plan.digest
    plans = [read_plan(tmp_path / f"plan-{number}.json")[0] for number in (0, 1)]
    assert all(proven.proof.holds for proven in prove_row(cell, plans))
    second = row.row[0]
    write_certificate(tmp_path / "c.json", second.plan, second.plan.scene, second.proof)
    kept = read_certificate(tmp_path / "c.json")
    assert kept.scene.detections[0].T_world_found is not None


def moved_station(cell, T, **changes):
    (station,) = cell.stations
    T = station.T_base_station * T
    return replace(cell, stations=(replace(station, T_base_station=T, **changes),))


@pytest.mark.parametrize(
    ("xyz", "problem"),
    [
        ((0.0, 0.0, 0.01), "is released -4.5 mm above station post"),
        ((0.0, 0.0, -0.003), "is released 8.5 mm above station post"),
        ((0.02, 0.0, 0.0), "stands over the edge of station post"),
        ((0.0, 0.0, -0.0012), "would stand 1.2 mm deep in something on station post"),
    ],
)
def test_a_plan_does_not_outlive_its_station(cell, row, one, xyz, problem):
    moved = moved_station(cell, pose_from_rpy(xyz))
    stale = prove(moved, scene(one), row.plan)
    assert "made for another cell" in str(stale.violations[0])
    claims = replace(row.plan, cell_digest=moved.digest)
    proof = prove(moved, scene(one), claims)
    assert problem in str(proof.violations)


def test_a_station_that_is_gone_carries_nothing(cell, row, one):
    without = replace(cell, stations=())
    proof = prove(without, scene(one), replace(row.plan, cell_digest=without.digest))
    assert "the cell has no station post" in str(proof.violations)
    narrow = moved_station(cell, pin.SE3.Identity(), size=np.array([0.02, 0.02]))
    proof = prove(narrow, scene(one), replace(row.plan, cell_digest=narrow.digest))
    assert "over the edge of station post" in str(proof.violations)


def test_where_nothing_is_beneath_nothing_stands(cell, row, one):
    """The post taken away, its station left in the air."""
    (station,) = cell.stations
    free = replace(station, fixture="", T_base_station=cell.T_world_station(station))
    fixtures = tuple(one for one in cell.fixtures if one.name != "post")
    bare = replace(cell, fixtures=fixtures, stations=(free,))
    proof = prove(bare, scene(one), replace(row.plan, cell_digest=bare.digest))
    assert "nothing beneath the part on station post carries it" in str(proof.violations)
    (said,) = station_problems(bare)
    assert str(said).endswith("keyed_cylinder: it has nothing beneath it that would carry a part")


def test_a_plan_that_names_no_station_has_no_place_there(cell, row, one):
    arm = replace(row.plan.arms[0], station="")
    proof = prove(cell, scene(one), replace(row.plan, arms=(arm,)))
    assert "from its target pose" in str(proof.violations)


def test_a_part_that_would_fall_over_is_not_put_down(cell, row, one):
    """The same hand, and the part in it turned onto its side: as a scan might have had it."""
    plan, arm = row.plan, row.plan.arms[0]
    on_side = pose_from_rpy((0, 0, 0), (np.pi / 2, 0, 0))
    turned = replace(one[0], T_world_part=one[0].T_world_part * on_side)
    bent = replace(
        plan,
        scan_digest=digest_of((turned,)),
        detections=(turned,),
        arms=(replace(arm, T_tcp_part=arm.T_tcp_part * on_side),),
    )
    proof = prove(cell, scene((turned,)), bent)
    said = str(proof.violations)
    assert "does not stand on station post" in said or "is released" in said


def test_a_part_of_unknown_roll_is_put_on_no_station(cell, row, one):
    unseen = (replace(one[0], roll_known=False),)
    said = replace(row.plan, detections=unseen, scan_digest=digest_of(unseen))
    proof = prove(cell, scene(unseen), said)
    assert "of unknown roll must not be put on a station" in str(proof.violations)
    assert asked(cell, unseen).plan is None


def test_a_row_that_leaves_a_part_on_the_station_is_no_whole_one(row):
    first, second = row.plans
    assert left_on_station(row.plans) is None
    says = "plan 1 puts a part on station post, and no plan"
    assert str(left_on_station((first,))).startswith(says)
    assert left_on_station((first, first)) and left_on_station((second,)) is None


def test_the_rest_of_the_bin_is_where_it_was_where_the_part_lay_alone(cell, parts):
    row = asked(cell, parts)
    assert row.plan.stations == ("post",)
    after = scene_after(cell, row.plan)
    (number,) = parts_taken(row.plan, row.plan)
    stays = after.detections[0]
    assert len(after.detections) == 2 and after.obstacles == ()
    assert stays.T_world_part.isApprox(parts[1 - number].T_world_part, 1e-12)


def test_the_bin_is_full_where_parts_may_have_moved(cell):
    """A neighbour 5 mm away may lie anywhere in the bin by the time that the part is taken anew."""
    one = lying(cell, 0.0, 0.0, 0.4)
    T = one.T_world_part
    beside = pin.SE3(T.rotation, T.translation + 0.043 * T.rotation[:, 0])
    parts = (one, replace(one, T_world_part=beside))
    row = asked(cell, parts, picks=3)
    first, second = row.plans[:2]
    assert first.stations == ("post",) and row.row[0].proof.holds
    after = scene_after(cell, first)
    assert len(after.detections) == 1 and len(after.obstacles) == 1
    (box,) = after.obstacles
    assert box.size[2] > cell.bin.size[2] + 0.08
    assert row.row_ends.mentions(ProofText.MAY_MOVE) and len(row.plans) == 2
    without = replace(second, obstacles=())
    assert "leaves out obstacle seen-1" in str(prove(cell, after, without).violations)


def test_the_row_goes_on_after_a_part_went_over_the_station(cell, parts):
    passes = replace(cell, arms=tuple(replace(arm, passes_parts_on=True) for arm in cell.arms))
    row = asked(passes, parts, picks=2)
    taken = [parts_taken(row.plan, plan) for plan in row.plans]
    assert {number for one in taken for number in one} == {0, 1}
    assert len(row.plans) > 2 and row.row_ends is None
    assert all(proven.proof.holds for proven in row.row)
    assert all(proven.proof.holds for proven in prove_row(passes, row.plans, detections=parts))
