"""Pallets in layers in the state: what carries, what is in doubt, and what a person is told."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.cell.changes import EmptyPallets
from workbench.app.core.command import Entry
from workbench.app.core.cycle.outcomes import ReportPick
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.cycle.standing import other_pallets, stale_because
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.state import Phase, State
from workbench.app.picking.facts import with_facts
from workbench.app.picking.pallets import at_rest, boxes_around, pallet_problems, pallets_of
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.gui.shared.movable_frames import move_frame, pose_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.release import PartReport
from workbench.model.scan import Detection

HEIGHT = 0.014


@pytest.fixture(scope="module")
def cell():
    return read_cell(find("robots", "tx2_90") / "pallet.toml")


def lying(cell, count: int) -> tuple[Detection, ...]:
    return tuple(
        Detection("puck", place.T_world_part) for place in cell.arms[0].part_places[:count]
    )


def planned(cell, placed):
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, HEIGHT / 2 + 0.0005))
    boxes = boxes_around(cell, placed)
    return plan_pick(cell, (Detection("puck", T),), "scan", obstacles=boxes)


@pytest.fixture(scope="module")
def on_top(cell):
    return planned(cell, lying(cell, 4)).plan


def ended(state: State, command: LinkEnded) -> State:
    command = with_facts(state, command)
    check_allowed(state, command, ROBOT_LINK, 1.0)
    return decide(state, Entry(state.number + 1, 1.0, ROBOT_LINK, command))[0]


def words(cell, placed) -> list[str]:
    return [str(sentence) for one in pallets_of(cell, placed) for sentence in one.words]


def test_how_full_a_pallet_is_is_told(cell):
    assert words(cell, ()) == ["right pallet 1: 0 of 8, layer 1"]
    assert words(cell, lying(cell, 3)) == ["right pallet 1: 3 of 8, layer 1"]
    assert words(cell, lying(cell, 4)) == ["right pallet 1: 4 of 8, layer 2"]
    assert words(cell, lying(cell, 8)) == ["right pallet 1: 8 of 8, full"]
    doubted = (*lying(cell, 3), replace(lying(cell, 4)[3], score=0.0))
    assert words(cell, doubted) == [
        "right pallet 1: 3 of 8, layer 1",
        "1 more may be there or not: check, and report when the pallets are empty",
    ]


def test_parts_are_drawn_where_they_have_fallen_to(cell):
    heights = [T.translation[2] for T in at_rest(cell, lying(cell, 5))]
    np.testing.assert_allclose(heights, [0.135] * 4 + [0.149], atol=2e-4)


def test_a_part_that_was_put_on_the_pallet_carries_the_next_ones(cell):
    plan = planned(cell, lying(cell, 3)).plan
    state = State(cell, Phase.SENDING, plan=plan, placed=lying(cell, 3))
    state = ended(state, LinkEnded(parts_placed=1))
    assert words(cell, state.placed) == ["right pallet 1: 4 of 8, layer 2"]
    assert planned(cell, state.placed).proof.holds


@pytest.mark.parametrize(
    "command",
    [
        LinkEnded("the link broke"),
        LinkEnded(parts=(PartReport("right", 0, False, "the cup holds nothing"),)),
    ],
)
def test_after_a_fault_or_a_failed_pick_it_carries_none(cell, command):
    plan = planned(cell, lying(cell, 3)).plan
    state = ended(State(cell, Phase.SENDING, plan=plan, placed=lying(cell, 3)), command)
    assert [one.score > 0 for one in state.placed] == [True, True, True, False]
    refused = planned(cell, state.placed)
    assert refused.plan is None and refused.verdict.reason == "no place"


def test_a_person_may_have_seen_that_it_is_not_there(cell):
    plan = planned(cell, lying(cell, 3)).plan
    state = ended(State(cell, Phase.SENDING, plan=plan, placed=lying(cell, 3)), LinkEnded())
    assert [one.score > 0 for one in state.placed] == [True] * 4
    command = ReportPick(0, False, "it fell")
    after, _ = decide(state, Entry(state.number + 1, 1.0, "ada", command))
    assert [one.score > 0 for one in after.placed] == [True, True, True, False]


def test_a_plan_that_counts_on_a_pallet_is_stale_when_that_was_emptied(cell, on_top):
    state = State(cell, Phase.PLANNED, plan=on_top, placed=lying(cell, 4))
    assert other_pallets(state, on_top) is None
    empty, _ = decide(state, Entry(9, 1.0, "ada", EmptyPallets()))
    assert "does not lie on the pallet any more" in str(stale_because(empty, on_top, {}))
    doubted = replace(state, placed=(*lying(cell, 3), replace(state.placed[3], score=0.0)))
    assert "or nobody knows whether it does" in str(other_pallets(doubted, on_top))


def test_who_moves_one_place_of_a_pallet_moves_it_whole(cell):
    T = pose_from_rpy((0.02, 0.01, 0.0), (0.0, 0.0, 0.1)) * pose_of(cell, "right part-place 3")
    other = move_frame(cell, "right part-place 3", T)
    assert pose_of(other, "right part-place 3").isApprox(T)
    first, third, last = (f"right part-place {number}" for number in (1, 3, 8))
    for name in (first, last):
        one, two = (pose_of(each, third).actInv(pose_of(each, name)) for each in (cell, other))
        assert one.isApprox(two, 1e-9)


def with_places(cell, change):
    arm = cell.arms[0]
    places = tuple(
        replace(one, T_world_part=change(one) * one.T_world_part) for one in arm.part_places
    )
    return replace(cell, arms=(replace(arm, part_places=places),))


def shift(x: float = 0.0, z: float = 0.0):
    return pose_from_rpy((x, 0.0, z))


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda one: shift(), ""),
        (lambda one: shift(z=0.004), "in layer 1 a part is released 15.0 mm above its support"),
        (lambda one: shift(z=-0.002), "released 9.0 mm above its support; 10.0 mm to 13.0 mm are"),
        (lambda one: shift(z=-0.002 * (one.layer - 1)),
         "in layer 2 a part is released 9.0 mm above its support; 10.0 mm to 13.0 mm are "
         "required: layers are 12.0 mm apart, and the part is 14.0 mm high"),
        (lambda one: shift(x=-0.12 * (one.T_world_part.translation[0] - 0.2)),
         "in layer 1 a part comes within 8.0 mm of one that lies there; the margin is 10.0 mm"),
        (lambda one: shift(x=0.5), "in layer 1 nothing is within 50 mm beneath a part"),
    ],
)  # fmt: skip
def test_what_is_wrong_with_a_pallet_is_told_before_it_is_filled(cell, change, says):
    found = list(map(str, pallet_problems(with_places(cell, change))))
    assert len(found) == bool(says)
    assert not says or (says in found[0] and found[0].startswith("right arm: pallet 1 of parts p"))
