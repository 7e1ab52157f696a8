"""Candidates at a glance: what is told while something is dragged is what planning says after."""

from dataclasses import replace

import numpy as np
import pytest
import two_parts

from workbench.app.picking.glance import changed, glance_of, glanced
from workbench.app.picking.pipeline import judge
from workbench.app.runtime.work import JOBS
from workbench.gui.shared.things import moved, moving, pose_of
from workbench.model.candidate import Reason, Stage
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import PartPlace
from workbench.model.part_edits import grasp_of, with_grasp, with_part
from workbench.model.scan import Detection
from workbench.planning.collision.world import World
from workbench.plugins.progress import never, silent

cell, detections = two_parts.cell, two_parts.detections


def judged_by_name(candidates):
    return {(one.detection, one.grasp.name, one.arm): one.verdict for one in candidates}


def check_against_judging(after, detections, found) -> set[Reason]:
    """Candidates are refused as by planning, or let through to what planning looks at later."""
    seen, judged = judged_by_name(found), judged_by_name(judge(after, detections))
    assert seen.keys() == judged.keys()
    for name, verdict in seen.items():
        said = judged[name]
        if not said.is_ok and said.stage is Stage.PROPOSE:
            assert str(verdict) == str(said), name
        elif said.reason is Reason.OUT_OF_REACH:
            assert verdict.reason is Reason.OUT_OF_REACH, name
        if not verdict.is_ok:
            assert not said.is_ok, (name, str(verdict), str(said))
            if verdict.stage is Stage.PROPOSE:
                assert str(verdict) == str(said), name
    return {verdict.reason for verdict in seen.values()}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("thing", "most"), [("bin", 0.03), ("robot", 0.5), ("right place 1", 0.6), ("fixture", 0.2)]
)
def test_a_thing_that_is_dragged_is_judged_as_planning_does_once_it_is_there(
    cell, detections, thing, most, seed
):
    thing = cell.fixtures[0].name if thing == "fixture" else thing
    rng = np.random.default_rng(seed)
    shift, turn = rng.uniform(-most, most, 3), rng.uniform(-0.3, 0.3)
    T = pose_of(cell, thing) * pose_from_rpy(shift, (0.0, 0.0, turn))
    found = glanced(World(changed(cell, moving(cell, thing, T)), detections))
    check_against_judging(moved(cell, thing, T), detections, found)


@pytest.mark.parametrize("seed", range(4))
def test_a_grasp_that_is_dragged_is_judged_as_planning_does_once_it_is_there(
    cell, detections, seed
):
    part, rng = cell.parts[0], np.random.default_rng(seed)
    entry = part.library.entries[0]
    grasp = grasp_of(entry)
    drag = pose_from_rpy(rng.uniform(-0.01, 0.01, 3), (0.0, 0.0, rng.uniform(-0.5, 0.5)))
    dragged = with_grasp(entry, replace(grasp, T_part_tcp=grasp.T_part_tcp * drag))
    library = replace(part.library, entries=(dragged, *part.library.entries[1:]))
    found = glanced(World(changed(cell, {"libraries": {part.name: library}}), detections))
    check_against_judging(with_part(cell, part.name, library=library), detections, found)


def test_where_nothing_is_moved_something_works_and_far_away_nothing_is_reached(cell, detections):
    said = check_against_judging(cell, detections, glanced(World(cell, detections)))
    assert Reason.OK in said
    T = cell.T_world_robot * pose_from_rpy((-2.0, 0.0, 0.0))
    found = glanced(World(changed(cell, {"T_world_robot": T}), detections))
    said = check_against_judging(moved(cell, "robot", T), detections, found)
    assert Reason.OUT_OF_REACH in said and Reason.OK not in said


def test_what_is_changed_is_the_cell_that_would_be_and_the_rest_the_same_objects(cell):
    T = cell.bin.T_world_bin * pose_from_rpy((0.01, 0.0, 0.0))
    part = cell.parts[0]
    library = replace(part.library, entries=part.library.entries[:0])
    change = moving(cell, "bin", T) | {"libraries": {part.name: library}}
    made, wanted = (
        changed(cell, change),
        with_part(moved(cell, "bin", T), part.name, library=library),
    )
    unsaid = frozenset({"controller", "approvers", "digest", "parts"})
    assert digest_of(made, without=unsaid) == digest_of(wanted, without=unsaid)
    assert made.parts[0].library is library and made.parts[0].grasps == wanted.parts[0].grasps
    assert made.arms is cell.arms and made.parts[0].mesh is part.mesh
    assert cell.parts[0].library is part.library, "the cell itself stays as it is"


def test_an_arm_without_any_place_or_one_out_of_reach_takes_nothing(cell, detections):
    far = pose_from_rpy((5.0, 0.0, 1.0))
    for places in ((), (far,)):
        arms = tuple(replace(arm, Ts_world_place=places, part_places=()) for arm in cell.arms)
        found = glanced(World(changed(cell, {"arms": arms}), detections))
        reasons = {one.verdict.reason for one in found if one.verdict.stage is not Stage.PROPOSE}
        assert reasons == {Reason.NO_PLACE}
        assert not any(one.verdict.is_ok for one in found)


def test_a_place_for_the_part_is_asked_for_with_the_part_in_the_hand(cell, detections):
    here = glanced(World(cell, detections))
    able = {one.arm for one in here if one.verdict.is_ok}
    assert able
    for shift, is_near in (((0.0, 0.0, 0.1), True), ((4.0, 0.0, 0.1), False)):
        T = cell.bin.T_world_bin * pose_from_rpy(shift)
        place = PartPlace(T, cell.parts[0].name, free_rotation=np.pi)
        arms = tuple(replace(arm, Ts_world_place=(), part_places=(place,)) for arm in cell.arms)
        found = glanced(World(changed(cell, {"arms": arms}), detections))
        assert any(one.verdict.is_ok for one in found) == is_near


def test_a_glance_holds_of_each_candidate_what_is_drawn(cell, detections):
    found = glanced(World(cell, detections), avoided={0: "its pick failed"})
    glance = glance_of(found)
    assert glance.detections.tolist() == [one.detection for one in found]
    assert glance.reasons == tuple(one.verdict.reason for one in found)
    assert glance.working.tolist() == [one.verdict.is_ok for one in found]
    assert not glance.working[glance.detections == 0].any()
    np.testing.assert_allclose(glance.tips, [one.T_world_tcp.translation for one in found])
    np.testing.assert_allclose(np.linalg.norm(glance.approaches, axis=1), 1.0)
    apart = [one.verdict.distance is not None and one.verdict.distance > 0 for one in found]
    assert glance.is_apart.tolist() == apart


def test_a_cell_without_grasps_has_an_empty_glance(cell, detections):
    part = cell.parts[0]
    bare = changed(cell, {"libraries": {part.name: replace(part.library, entries=())}})
    glance = glance_of(glanced(World(bare, detections)))
    assert glance.reasons == () and glance.tips.shape == (0, 3)


def test_the_worker_finds_what_stands_around_once_and_is_told_it_afterwards(cell, detections):
    box = Detection(cell.parts[0].name, cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.3)))
    asked = {
        "change": {},
        "detections": detections,
        "avoided": (),
        "obstacles": None,
        "around": (None, detections, (box,)),
    }
    first = JOBS["glance"](cell, asked, silent, never)
    assert len(first.obstacles) == 1, "the part that was put down"
    again = JOBS["glance"](
        cell, asked | {"obstacles": first.obstacles, "around": None}, silent, never
    )
    assert again.obstacles is first.obstacles
    assert again.reasons == first.reasons
