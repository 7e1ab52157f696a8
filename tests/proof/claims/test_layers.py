"""Pallets in layers: no part is put where nothing carries it, where one lies, or beneath one."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove, scene_of
from workbench.app.picking.row import plan_row, prove_row
from workbench.app.picking.stations import put_down
from workbench.app.runtime.work import boxes_around
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.scan import Detection, Scene
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.placing.pallets import open_places
from workbench.proof.claims.places.layers import _falls_over, fall, kept_box, occupation, place_at
from workbench.proof.claims.prove import prove as prove_in
from workbench.proof.claims.prove import scene_after

HEIGHT = 0.014


@pytest.fixture(scope="module")
def cell():
    return read_cell(find("robots", "tx2_90") / "pallet.toml")


def in_the_bin(cell, *places) -> tuple[Detection, ...]:
    return tuple(
        Detection("puck", cell.bin.T_world_bin * pose_from_rpy((x, y, HEIGHT / 2 + 0.0005)))
        for x, y in places or [(0.0, 0.0)]
    )


def put_at_places(cell, *numbers: int) -> tuple[Detection, ...]:
    """Parts that were put at places, counted from 0."""
    places = cell.arms[0].part_places
    return tuple(Detection("puck", places[number].T_world_part) for number in numbers)


def planned(cell, placed):
    return plan_pick(cell, in_the_bin(cell), "scan", obstacles=boxes_around(cell, placed))


def layer_of(cell, plan) -> int:
    ((one,), (arm,)) = put_down(cell, plan), cell.arms
    place = place_at(arm, cell.parts[0], one.T_world_part)
    return place.layer


def with_kept(plan, kept):
    """The plan and the scene, which both say that other parts lie on the pallet."""
    bent = replace(plan, obstacles=tuple(kept))
    return Scene(plan.scan_digest, plan.detections, tuple(kept)), bent


def said(cell, scene, plan) -> str:
    return "; ".join(str(one) for one in prove_in(cell, scene, plan).violations)


@pytest.mark.extensive
def test_a_pallet_is_filled_layer_by_layer_until_it_is_full(cell):
    placed: tuple[Detection, ...] = ()
    layers = []
    for _ in range(8):
        result = planned(cell, placed)
        assert result.plan is not None, str(result.verdict)
        assert result.proof.holds, result.proof.violations
        layers.append(layer_of(cell, result.plan))
        placed += put_down(cell, result.plan)
    assert layers == [1] * 4 + [2] * 4
    boxes = boxes_around(cell, placed)
    # At rest each lies on the pallet or on the one beneath, and no box is in another one.
    bottoms = sorted(box.T_world_box.translation[2] - box.size[2] / 2 for box in boxes)
    np.testing.assert_allclose(bottoms, [0.128] * 4 + [0.142] * 4, atol=2e-4)
    full = planned(cell, placed)
    assert full.plan is None
    assert full.verdict.note == VerdictNote.PALLETS_FULL(arm="right", places=8)


@pytest.fixture(scope="module")
def on_top(cell):
    """A plan that puts a part into layer 2, the first layer being full."""
    return planned(cell, put_at_places(cell, 0, 1, 2, 3)).plan


@pytest.fixture(scope="module")
def at_first(cell):
    return planned(cell, ()).plan


def test_a_layer_that_is_not_full_carries_no_other(cell, on_top):
    assert layer_of(cell, on_top) == 2 and prove(cell, on_top).holds
    for missing in range(4):
        kept = [box for number, box in enumerate(on_top.obstacles) if number != missing]
        words = said(cell, *with_kept(on_top, kept))
        assert "layer 1 of the pallet is not full: 1 of 4 places are empty" in words
    # Nothing beneath it at all.
    words = said(cell, *with_kept(on_top, on_top.obstacles[1:]))
    assert "of 4 places are empty" in words


def test_a_part_that_may_be_there_carries_no_other(cell, on_top):
    *sure, last = put_at_places(cell, 0, 1, 2, 3)
    boxes = boxes_around(cell, (*sure, replace(last, score=0.0)))
    assert [box.part for box in boxes] == ["puck"] * 3 + [""]
    assert "is not full" in said(cell, *with_kept(on_top, boxes))
    refused = planned(cell, (*sure, replace(last, score=0.0)))
    assert refused.plan is None and refused.verdict.reason == "no place"


def test_a_plan_does_not_say_by_itself_what_lies_there(cell, on_top):
    scene = replace(on_top.scene, obstacles=on_top.obstacles[:3])
    words = said(cell, scene, on_top)
    assert "the plan states that seen-4 is a part on a pallet, which is not known" in words
    elsewhere = put_at_places(cell, 0, 1, 2, 5)
    scene = replace(on_top.scene, obstacles=boxes_around(cell, elsewhere))
    assert "which is not known" in said(cell, scene, on_top)


def test_no_part_goes_where_one_lies(cell, at_first):
    kept = boxes_around(cell, put_at_places(cell, 0))
    assert "a part lies at that place of the pallet already" in said(
        cell, *with_kept(at_first, kept)
    )


def test_no_part_goes_beneath_another(cell, at_first):
    for above in (4, 7):
        kept = boxes_around(cell, put_at_places(cell, above))
        words = said(cell, *with_kept(at_first, kept))
        assert "a part lies above it on the pallet, in layer 2" in words
    world = World(cell, in_the_bin(cell), boxes_around(cell, put_at_places(cell, 4)))
    assert all(place.layer == 2 for place in open_places(world, cell.arms[0], 0))


def test_a_part_is_let_go_of_by_little_above_what_it_falls_onto(cell):
    """A pallet that is 10 mm lower than its places say."""
    lower = replace(
        cell,
        fixtures=tuple(
            replace(one, T_world_fixture=pose_from_rpy((0, 0, -0.01)) * one.T_world_fixture)
            if one.name == "pallet"
            else one
            for one in cell.fixtures
        ),
    )
    result = planned(lower, ())
    assert result.plan is not None
    assert "the part is released 21.0 mm above its support, 13.0 mm at most" in str(
        result.proof.violations[0]
    )


@pytest.mark.parametrize("count", [20, 40])
def test_a_stack_may_not_be_too_tall(cell, count):
    arm = cell.arms[0]
    first = arm.part_places[0]
    ups = [pose_from_rpy((0, 0, k * HEIGHT)) * first.T_world_part for k in range(count)]
    places = tuple(replace(first, layer=k + 1, T_world_part=T) for k, T in enumerate(ups))
    tall = replace(cell, arms=(replace(arm, part_places=places),))
    kept = boxes_around(tall, put_at_places(tall, *range(count - 1)))
    top = Detection("puck", places[-1].T_world_part)
    assert occupation(tall, tall.arms[0], places[-1], kept) is None
    problem = _falls_over(tall, Scene("", (), kept), places[-1], top, top.T_world_part)
    assert (problem is not None) == (count == 40)
    assert problem is None or "a stack of 40 falls over when tilted by 7." in str(problem)


def test_where_a_part_falls_to_is_measured(cell):
    (top,) = put_at_places(cell, 4)
    kept = boxes_around(cell, put_at_places(cell, 0))
    assert fall(cell, kept, top, top.T_world_part) == pytest.approx(0.011, abs=1e-4)
    assert fall(cell, (), top, top.T_world_part) == pytest.approx(0.025, abs=1e-4)
    far = pose_from_rpy((0, 0, 0.5)) * top.T_world_part
    assert fall(cell, (), top, far) == 0.05


def test_a_turned_part_needs_no_more_room_on_the_pallet(cell):
    place = cell.arms[0].part_places[0].T_world_part
    for turn in ((0, 0, 0.7), (np.pi, 0, 0.3)):
        put = place * pose_from_rpy((0, 0, 0), turn)
        box = kept_box(cell, (), Detection("puck", put), put)
        assert box.part == "puck" and box.T_world_put.isApprox(put)
        np.testing.assert_allclose(box.size, [0.08, 0.08, 0.014], atol=1e-3)


def test_what_is_put_in_the_same_plan_is_in_the_way_and_carries_nothing(cell):
    arm, detections = cell.arms[0], in_the_bin(cell, (0.0, 0.0), (0.1, 0.1))
    world = World(cell, detections, boxes_around(cell, put_at_places(cell, 0, 1, 2)))
    result = planned(cell, put_at_places(cell, 0, 1, 2)).plan.arms[0]
    q = result.leg("place").q[-1]
    assert open_places(world, arm, 1) == (arm.part_places[3],)
    phase = LegPhase(frozenset({"right"}), placed={"right": (0, result.T_tcp_part, q)})
    assert open_places(world, arm, 1, phase) == ()


@pytest.fixture(scope="module")
def row(cell):
    """Five plans in a row; the last one puts its part onto those of the others."""
    many = replace(cell, policy=replace(cell.policy, pair_gap=0.01))
    spots = in_the_bin(cell, (0, 0), (0.12, 0.12), (-0.12, 0.12), (0.12, -0.12), (-0.12, -0.12))
    return many, plan_row(many, spots, "scan", picks=5)


def test_in_a_row_what_the_plans_before_put_down_carries(row):
    many, result = row
    assert len(result.plans) == 5, result.row_ends
    assert [layer_of(many, plan) for plan in result.plans] == [1, 1, 1, 1, 2]
    assert all(one.proof.holds for one in prove_row(many, result.plans))
    after = scene_after(many, result.plans[-2])
    assert [box.part for box in after.obstacles] == ["puck"] * 4
    # The last one before the others is refused.
    moved = replace(result.plans[-1], obstacles=result.plans[0].obstacles)
    assert "of 4 places are empty" in str(prove(many, moved).violations)


def test_a_file_says_what_lies_on_the_pallet(cell, on_top, tmp_path):
    write_plan(tmp_path / "plan.json", on_top)
    again, _ = read_plan(tmp_path / "plan.json")
    assert again.digest == on_top.digest
    assert scene_of(cell, again).obstacles[0].part == "puck"
    assert prove(cell, again).holds


def test_no_scan_of_the_bin_shows_the_pallet(cell, on_top):
    """With a scan the plan's word is taken for what lies there."""
    scan = synthesize(cell, on_top.detections, seed=1)
    found = replace(on_top, scan_digest=scan.digest)
    assert sum(bool(box.part) for box in scene_of(cell, found, scan=scan).obstacles) == 4
    assert prove(cell, found, scan=scan).holds


def test_boxes_of_other_cells_are_as_they_were():
    """Digests of plans that know no layers stay."""
    tray = read_cell(find("robots", "tx2_90") / "full_bin.toml")
    (box,) = boxes_around(tray, (Detection("puck", pose_from_rpy((0.2, -0.5, 0.2))),))
    assert box.part == "" and box.T_world_put is None
