"""Candidates at a glance: what is told while something is dragged is what planning says after."""

from dataclasses import replace

import numpy as np
import pytest
import two_parts

from workbench.app.picking.glance import apply_change, glance_at
from workbench.app.picking.judging import judge
from workbench.app.runtime.work import JOBS
from workbench.gui.shared.movable_frames import move_frame, moving, pose_of
from workbench.model.candidate import Reason, Stage
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import PartPlace
from workbench.model.part_edits import grasp_of, with_grasp, with_part
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.world import World
from workbench.plugins.progress import never, silent

cell, detections = two_parts.cell, two_parts.detections


def by_name(found):
    rows = zip(found.detections.tolist(), found.grasps, found.arms, strict=True)
    return dict(zip(rows, zip(found.reasons, found.is_apart.tolist(), strict=True), strict=True))


def check_against_judging(after, detections, found, **about) -> set[Reason]:
    """Candidates are refused as by planning, or let through to what planning looks at later."""
    seen = by_name(found)
    judged = {
        (one.detection, one.grasp.name, one.arm): one.verdict
        for one in judge(after, detections, **about)
    }
    assert seen.keys() == judged.keys()
    for name, (reason, is_apart) in seen.items():
        said = judged[name]
        if not said.is_ok and said.stage is Stage.PROPOSE:
            assert (reason, is_apart) == (said.reason, (said.distance or 0.0) > 0.0), name
        elif said.reason is Reason.OUT_OF_REACH:
            assert reason is Reason.OUT_OF_REACH, name
        elif reason is not Reason.OK:
            assert reason in (Reason.OUT_OF_REACH, Reason.NO_PLACE), name
            assert not said.is_ok, (name, reason, str(said))
    return set(found.reasons)


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
    found = glance_at(World(apply_change(cell, moving(cell, thing, T)), detections))
    check_against_judging(move_frame(cell, thing, T), detections, found)


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
    found = glance_at(World(apply_change(cell, {"libraries": {part.name: library}}), detections))
    check_against_judging(with_part(cell, part.name, library=library), detections, found)


def test_where_nothing_is_moved_something_works_and_far_away_nothing_is_reached(cell, detections):
    said = check_against_judging(cell, detections, glance_at(World(cell, detections)))
    assert Reason.OK in said
    T = cell.T_world_robot * pose_from_rpy((-2.0, 0.0, 0.0))
    found = glance_at(World(apply_change(cell, {"T_world_robot": T}), detections))
    said = check_against_judging(move_frame(cell, "robot", T), detections, found)
    assert Reason.OUT_OF_REACH in said and Reason.OK not in said


def test_what_is_changed_is_the_cell_that_would_be_and_the_rest_the_same_objects(cell):
    T = cell.bin.T_world_bin * pose_from_rpy((0.01, 0.0, 0.0))
    part = cell.parts[0]
    library = replace(part.library, entries=part.library.entries[:0])
    change = moving(cell, "bin", T) | {"libraries": {part.name: library}}
    made, wanted = (
        apply_change(cell, change),
        with_part(move_frame(cell, "bin", T), part.name, library=library),
    )
    unsaid = frozenset({"controller", "approvers", "digest", "parts"})
    assert digest_of(made, without=unsaid) == digest_of(wanted, without=unsaid)
    assert made.parts[0].library is library and made.parts[0].grasps == wanted.parts[0].grasps
    assert made.arms is cell.arms and made.parts[0].mesh is part.mesh
    assert cell.parts[0].library is part.library, "the cell itself stays as it is"


def test_a_part_whose_roll_is_unknown_is_judged_as_planning_does(cell, detections):
    unknown = (replace(detections[0], roll_known=False), *detections[1:])
    said = check_against_judging(cell, unknown, glance_at(World(cell, unknown)))
    assert Reason.OK in said


def test_obstacles_that_the_scan_shows_are_kept_clear_of(cell, detections):
    T = detections[0].T_world_part
    above = Obstacle(pose_from_rpy(T.translation + np.array([0.0, 0.0, 0.06])), np.full(3, 0.03))
    found = glance_at(World(cell, detections, (above,)))
    check_against_judging(cell, detections, found, obstacles=(above,))
    assert found.working.sum() < glance_at(World(cell, detections)).working.sum()
    assert found.obstacles == (above,)


def test_an_arm_without_any_place_or_one_out_of_reach_takes_nothing(cell, detections):
    here = glance_at(World(cell, detections))
    far = pose_from_rpy((5.0, 0.0, 1.0))
    for places in ((), (far,)):
        arms = tuple(replace(arm, Ts_world_place=places, part_places=()) for arm in cell.arms)
        found = glance_at(World(apply_change(cell, {"arms": arms}), detections))
        assert not found.working.any()
        was, now = np.array(here.reasons), np.array(found.reasons)
        assert set(now[was == Reason.OK]) == {Reason.NO_PLACE}


def test_a_place_for_the_part_is_asked_for_with_the_part_in_the_hand(cell, detections):
    assert glance_at(World(cell, detections)).working.any()
    for shift, is_near in (((0.0, 0.0, 0.1), True), ((4.0, 0.0, 0.1), False)):
        T = cell.bin.T_world_bin * pose_from_rpy(shift)
        place = PartPlace(T, cell.parts[0].name, free_rotation=np.pi)
        arms = tuple(replace(arm, Ts_world_place=(), part_places=(place,)) for arm in cell.arms)
        found = glance_at(World(apply_change(cell, {"arms": arms}), detections))
        assert found.working.any() == is_near


def test_a_glance_shows_where_the_hand_would_be_and_how_it_comes(cell, detections):
    found = glance_at(World(cell, detections), avoided={0: "its pick failed"})
    assert not found.working[found.detections == 0].any()
    assert {found.reasons[k] for k in np.flatnonzero(found.detections == 0)} == {Reason.DISABLED}
    grasps = {grasp.name: grasp for grasp in cell.parts[0].grasps}
    for k, number in enumerate(found.detections.tolist()):
        T = detections[number].T_world_part * grasps[found.grasps[k]].T_part_tcp
        np.testing.assert_allclose(found.tips[k], T.translation, atol=1e-12)
        way = T.rotation @ grasps[found.grasps[k]].approach
        np.testing.assert_allclose(found.approaches[k], way, atol=1e-12)


def test_a_cell_without_grasps_has_an_empty_glance(cell, detections):
    part = cell.parts[0]
    bare = apply_change(cell, {"libraries": {part.name: replace(part.library, entries=())}})
    glance = glance_at(World(bare, detections))
    assert glance.reasons == () and glance.tips.shape == (0, 3)


def test_the_worker_finds_what_stands_around_once_and_is_told_it_afterwards(cell, detections):
    box = Detection(cell.parts[0].name, cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.3)))
    asked = {
        "change": {},
        "detections": detections,
        "avoided": (),
        "obstacles": None,
        "around": (None, detections, (box,), "poses"),
    }
    first = JOBS["glance"](cell, asked, silent, never)
    assert len(first.obstacles) == 1, "the part that was put down"
    again = JOBS["glance"](
        cell, asked | {"obstacles": first.obstacles, "around": None}, silent, never
    )
    assert again.obstacles is first.obstacles
    assert again.reasons == first.reasons
