"""A spacer goes to where the scan shows its bolt, and onto none that the scan does not show."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from assembling import insertion, standing_spacer, turn

from workbench.app.picking.pallets import boxes_around
from workbench.app.picking.proving import prove
from workbench.app.picking.row import plan_row
from workbench.app.runtime.work import JOBS
from workbench.app.runtime.work import plan as plan_job
from workbench.app.standing.seen_again import as_scan_shows, with_sight
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.candidate import Reason
from workbench.model.cell import Cell, Fixture, PlanOverrides
from workbench.model.derived.assembling import assembled_pose, rest_pose
from workbench.model.derived.by_recipe import wanted_parts, with_recipe
from workbench.model.errors import FileError
from workbench.model.geometry import Box, Solid, pose_from_rpy
from workbench.model.messages.cells import SeenBaseText
from workbench.model.messages.proofs import ProofText
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.plan import PlanResult
from workbench.model.recipes.joint import PlacingError
from workbench.model.recipes.seen_base import SeenBase, SightProblem
from workbench.model.scan import Detection, Scan, Scene
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.placing.assembling import base_errors
from workbench.planning.placing.budget import budget_of
from workbench.planning.placing.mating import mating_chance
from workbench.plugins.progress import never, silent
from workbench.proof.claims.places.assembled import sight_violations

CELL = with_recipe(read_cell(find("robots", "yumi") / "assembly.toml"), 2)
T_PUT = CELL.arm("right").part_places[0].T_world_part
BELIEVED = pin.SE3(T_PUT.rotation, T_PUT.translation - [0.0, 0.0, 0.006])
ERROR = PlacingError(np.zeros((6, 6)), np.diag(np.square([0.001] * 3 + [0.01] * 3)))
PLACED = (Detection("bolt", T_PUT, placing=ERROR),)
SPACER = replace(
    standing_spacer(CELL), covariance=np.diag(np.square([1e-4] * 3 + [np.deg2rad(0.1)] * 3))
)
OFF = pose_from_rpy((0.003, -0.002, 0.0)) * turn("x", 1.0)


def scan_with(*bolts: pin.SE3) -> Scan:
    return synthesize(CELL, (SPACER, *(Detection("bolt", T) for T in bolts)), seed=3)


def plan_in(
    scan: Scan | None, *, cell: Cell = CELL, placed=PLACED, scan_digest: str | None = None
) -> PlanResult:
    digest = scan.digest if scan is not None else "poses"
    arguments = {
        "scan": scan,
        "detections": (SPACER,),
        "scan_digest": digest if scan_digest is None else scan_digest,
        "strategy": "auto",
        "threshold": 0.2,
        "overrides": PlanOverrides(),
        "placed": placed,
        "avoided": (),
        "wanted": wanted_parts(cell, {"bolt": 1}),
        "seed": 0,
    }
    return plan_job(cell, arguments, silent, never)


@pytest.fixture(scope="module")
def scan():
    return scan_with(BELIEVED * OFF)


@pytest.fixture(scope="module")
def result(scan):
    return plan_in(scan)


def base_of(result: PlanResult):
    (box,) = (box for box in result.obstacles if box.part == "bolt")
    return box


def test_the_spacer_is_planned_and_proven_for_where_the_bolt_is_seen(result, scan):
    assert result.plan is not None and result.proof is not None and result.proof.holds
    box = base_of(result)
    assert box.seen is not None and box.seen.scan == scan.digest
    T = assembled_pose(CELL, result.plan.obstacles, "bolt")
    assert T is not None and T.isApprox(box.seen.T_world_part, 1e-9)
    away = (BELIEVED * OFF).actInv(T)
    assert np.linalg.norm(away.translation) < 0.0003
    # It is the same part that was put there, by its pose at the release.
    assert box.T_world_put is not None and box.T_world_put.isApprox(T_PUT, 1e-9)


def test_the_proof_in_the_same_scan_agrees(result, scan):
    assert result.plan is not None
    proof = prove(CELL, result.plan, detections=(SPACER,), scan=scan)
    assert proof.holds, proof.violations[0]


def test_nothing_that_the_scan_shows_of_the_bolt_is_an_unknown_thing(result):
    assert [box.part for box in result.obstacles] == ["bolt"]


def problems(plan, scan) -> list:
    found = prove(CELL, plan, detections=(SPACER,), scan=scan).violations
    return [violation.problem.text for violation in found]


def test_the_proof_refuses_a_bolt_that_stands_elsewhere_than_seen(result, scan):
    plan = result.plan
    box = base_of(result)
    believed = BELIEVED * rest_pose(CELL, box).actInv(box.T_world_box)
    moved = replace(plan, obstacles=(replace(box, T_world_box=believed),))
    assert ProofText.INVENTED_PALLET in problems(moved, scan)


def test_the_proof_refuses_a_bolt_that_nobody_has_seen(result, scan):
    plan, box = result.plan, base_of(result)
    unseen = replace(plan, obstacles=(replace(box, seen=None),))
    assert ProofText.INVENTED_PALLET in problems(unseen, scan)
    proof = prove(CELL, unseen)
    assert SeenBaseText.PUT_SINCE in [each.problem.text for each in proof.violations]


def test_the_proof_refuses_a_bolt_that_was_seen_in_another_scan(result):
    plan, box = result.plan, base_of(result)
    older = replace(plan, obstacles=(replace(box, seen=replace(box.seen, scan="0" * 64)),))
    found = [each.problem.text for each in prove(CELL, older).violations]
    assert found == [SeenBaseText.PUT_SINCE]


def covering_scan() -> Scan:
    """A sheet hides most of the bolt."""
    sheet = Solid("sheet", Box(np.array([0.1, 0.1, 0.002])), pin.SE3.Identity())
    sight = 0.2 * (CELL.scanner.T_world_scanner.translation - BELIEVED.translation)
    above = sight + [0.05, 0.0, 0.0]
    cover = Fixture("cover", pin.SE3(np.eye(3), BELIEVED.translation + above), (sheet,))
    cell = replace(CELL, fixtures=(*CELL.fixtures, cover))
    bolt = Detection("bolt", BELIEVED * pose_from_rpy((0.002, 0.001, 0.0)))
    return synthesize(cell, (SPACER, bolt), seed=1)


def partial_scan() -> Scan:
    """A scan without what is measured around the bolt's place."""
    whole = scan_with(BELIEVED)
    is_far = np.linalg.norm(whole.points_world - BELIEVED.translation, axis=1) > 0.1
    return Scan(whole.points[is_far], whole.T_world_scanner, "part")


@pytest.mark.parametrize(
    "made, problem",
    [
        (lambda: scan_with(), SightProblem.GONE),
        (covering_scan, SightProblem.TOO_LITTLE),
        (partial_scan, SightProblem.NOT_IN_VIEW),
    ],
    ids=["gone", "too little", "not in view"],
)
def test_a_plan_cannot_state_that_it_sees_a_bolt_which_the_scan_does_not_show(made, problem):
    scan = made()
    (honest,) = with_sight(CELL, scan, boxes_around(CELL, PLACED))
    assert honest.seen is not None and honest.seen.problem is problem
    covariance = np.diag([1e-8] * 6)
    claimed = SeenBase(scan.digest, rest_pose(CELL, honest), covariance, visible=1.0)
    stated = replace(honest, seen=claimed)
    result = plan_row(CELL, (SPACER,), scan.digest, obstacles=(stated,))
    assert result.plan is not None and result.proof is not None and result.proof.holds
    proof = prove(CELL, result.plan, scan=scan)
    assert ProofText.INVENTED_PALLET in [each.problem.text for each in proof.violations]


def test_the_proof_asks_the_scene_whether_the_bolt_is_seen(result):
    plan, box = result.plan, base_of(result)
    gone = SeenBase(plan.scan_digest, problem=SightProblem.GONE)
    known = Scene(plan.scan_digest, plan.detections, (replace(box, seen=gone),))
    (violation,) = sight_violations(CELL, known, plan, plan.picks[0])
    assert violation.problem.text is SeenBaseText.GONE


def test_the_live_verdict_asks_no_scan_where_parts_come_from_outside(scan):
    asked = {"change": {}, "detections": (SPACER,), "avoided": (), "obstacles": None}

    def boxes(digest: str):
        around = scan, (SPACER,), PLACED, digest
        found = JOBS["glance"](CELL, asked | {"around": around}, silent, never)
        return [box.seen for box in found.obstacles if box.part]

    (seen,), (unseen,) = boxes(scan.digest), boxes("poses from outside")
    assert seen.problem is None and unseen.problem is SightProblem.NO_SCAN


LIES = pin.SE3(turn("y", 90).rotation, BELIEVED.translation + [0.0, 0.0, -0.022])


@pytest.mark.parametrize(
    "bolts, why",
    [
        ((), SeenBaseText.GONE),
        ((LIES,), None),
        ((BELIEVED * pose_from_rpy((0.014, 0.0, 0.0)),), SeenBaseText.TOO_FAR),
        ((BELIEVED * turn("x", 180),), SeenBaseText.OTHER),
    ],
    ids=["missing", "tipped over", "too far", "upside down"],
)
def test_nothing_comes_onto_a_bolt_that_the_scan_does_not_show(bolts, why):
    result = plan_in(scan_with(*bolts))
    assert result.plan is None and result.verdict.reason is Reason.NO_PLACE
    note = result.verdict.note
    assert note.text.name in SightProblem.__members__ and why in (None, note.text)
    assert len(str(note).split()) <= 25 and "bolt" in str(note)


def test_nothing_comes_onto_a_bolt_without_a_scan(scan):
    for asked in ({"scan": None}, {"scan": scan, "scan_digest": "poses from outside"}):
        found = plan_in(**asked)
        assert found.verdict.note == SeenBaseText.NO_SCAN(base="bolt")


def test_a_plan_for_poses_keeps_a_bolt_that_no_scan_was_asked_for(scan):
    box = base_of(plan_in(None))
    assert box.seen is not None and box.seen.problem is SightProblem.NO_SCAN
    assert as_scan_shows(CELL, scan, (box,)) == (box,)
    (moved,) = as_scan_shows(CELL, scan, (replace(box, seen=None),))
    assert moved.seen is not None and moved.seen.problem is None


def test_a_bolt_that_has_its_spacer_is_not_searched_again(scan):
    spacer = Detection("spacer", BELIEVED * insertion(CELL).T_base_part)
    boxes = boxes_around(CELL, (*PLACED, spacer))
    assert [box.part for box in boxes] == ["bolt", "spacer"]
    assert [box.seen for box in with_sight(CELL, scan, boxes)] == [None, None]
    assert with_sight(CELL, scan, boxes[:1])[0].seen is not None


def test_a_bolt_that_was_seen_stays_there_and_counts_as_off_from_where_it_was_put(scan):
    was_seen = (replace(PLACED[0], T_world_seen=BELIEVED * OFF),)
    spacer = Detection("spacer", BELIEVED * OFF * insertion(CELL).T_base_part)
    bolt, _ = with_sight(CELL, scan, boxes_around(CELL, (*was_seen, spacer)))
    assert bolt.seen is None and rest_pose(CELL, bolt).isApprox(BELIEVED * OFF, 1e-9)
    (again,) = with_sight(CELL, scan, boxes_around(CELL, was_seen))
    (first,) = with_sight(CELL, scan, boxes_around(CELL, PLACED))
    assert again.seen.shift == first.seen.shift > 0.003
    assert again.T_world_box.isApprox(first.T_world_box, 1e-12)


def test_a_bolt_that_this_scan_does_not_show_stays_where_another_has_shown_it():
    was_seen = (replace(PLACED[0], T_world_seen=BELIEVED * OFF),)
    empty = scan_with()
    (box,) = with_sight(CELL, empty, boxes_around(CELL, was_seen))
    assert box.seen is not None and box.seen.problem is SightProblem.GONE
    assert rest_pose(CELL, box).isApprox(BELIEVED * OFF, 1e-9)
    assert as_scan_shows(CELL, empty, (box,)) == (box,)
    far = pose_from_rpy((0.02, 0.0, 0.0)) * box.T_world_box
    (put,) = as_scan_shows(CELL, empty, (replace(box, T_world_box=far),))
    assert rest_pose(CELL, put).isApprox(BELIEVED, 1e-4)


def test_a_bolt_that_may_be_missing_is_no_base_whatever_the_scan_shows(scan):
    doubtful = (replace(PLACED[0], score=0.0),)
    assert plan_in(scan, placed=doubtful).verdict.note == VerdictNote.NO_BASE(base="bolt")


def test_what_came_after_the_scan_has_to_be_in_the_next(scan):
    # The second plan of a row has its bolt from the first.
    result = plan_row(CELL, (SPACER,), scan.digest, obstacles=boxes_around(CELL, PLACED))
    assert result.verdict.note == SeenBaseText.PUT_SINCE(base="bolt")


def test_without_the_key_the_spacer_goes_to_where_the_bolt_is_believed(scan):
    cell = with_recipe(read_cell(find("robots", "yumi") / "assembly.toml"), 1)
    assert not insertion(cell).look_again
    box = base_of(plan_in(scan, cell=cell))
    assert box.seen is None and rest_pose(cell, box).isApprox(BELIEVED, 1e-4)


def test_a_plan_file_states_where_the_bolt_was_seen(result, tmp_path):
    path = tmp_path / "plan.json"
    write_plan(path, result.plan, result.proof)
    read, stated = read_plan(path)
    assert read.digest == stated == result.plan.digest
    text = path.read_text(encoding="utf-8")
    for good, broken in (
        ('"shift"', '"shifted"'),
        ('"problem": null', '"problem": "asleep"'),
        ('"problem": null', '"problem": "gone"'),
        ('"part": "bolt",', ""),
    ):
        assert good in text
        path.write_text(text.replace(good, broken), encoding="utf-8")
        with pytest.raises(FileError):
            read_plan(path)


def test_a_plan_without_the_bolt_states_why(tmp_path):
    """A plan for something else keeps the reason in its file."""
    box = base_of(plan_in(scan_with()))
    assert box.seen is not None and box.seen.problem is SightProblem.GONE
    found = plan_in(scan_with(BELIEVED * OFF))
    plan = replace(found.plan, obstacles=(box,))
    write_plan(tmp_path / "plan.json", plan)
    read, stated = read_plan(tmp_path / "plan.json")
    assert read.digest == stated == plan.digest


def test_the_budget_states_what_looking_has_gained(result):
    bases = base_errors(CELL, PLACED, result.obstacles)
    assert bases["bolt"].believed is ERROR
    good = next(each for each in result.candidates if each.verdict.is_ok)
    budget = budget_of(CELL, SPACER, good, bases)
    before = budget_of(CELL, SPACER, good, base_errors(CELL, PLACED))
    assert budget.believed_chance == before.chance and before.believed_chance is None
    assert budget.chance is not None and budget.chance > before.chance + 0.1
    assert f"(before bolt was seen: {before.chance:.0%})" in str(budget.words)


def test_the_calibration_cancels_where_it_moves_both_alike():
    joint_to = insertion(CELL)
    shared = np.zeros((6, 6))
    shared[:3, :3] = np.eye(3)
    nothing, scanner = np.zeros((6, 6)), np.diag([0.002**2] * 3 + [0.0] * 3)
    alike = PlacingError(shared, nothing)
    assert mating_chance(joint_to, alike, alike, scanner) == 1.0
    assert mating_chance(joint_to, alike, PlacingError(nothing, nothing), scanner) < 0.9
