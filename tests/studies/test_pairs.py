"""How many parts of a pair are taken, and the reasons why not more, as the plans have them."""

import json
from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.cli.measuring.studies import _pairs_words
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import plain
from workbench.model.plan import Violation
from workbench.model.scan import Detection
from workbench.studies.pairs import Taken, count_pairs, taken_of


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


def pair(cell, *places, sunk=(0.0, 0.0)):
    """Cylinders lying in the bin at (x, y, yaw), so far [m] below its floor."""
    floor = cell.bin.T_world_bin.translation
    return tuple(
        Detection(
            "keyed_cylinder",
            pose_from_rpy(floor + np.array([x, y, 0.0191 - deep]), (np.pi / 2, 0.0, yaw)),
            0.9,
        )
        for (x, y, yaw), deep in zip(places, sunk, strict=True)
    )


APART = ((-0.01, -0.07, 0.4), (0.01, 0.07, -0.6))


def of(cell, detections, **asked):
    first = plan_pick(cell, detections, "study", threshold=0.0, seed=0, **asked)
    return first, taken_of(cell, detections, first, 0)


def test_a_plan_of_two_arms_takes_a_pair_whole(cell):
    first, taken = of(cell, pair(cell, *APART))
    assert len(first.plan.arms) == 2
    assert taken == Taken(2, "", True, "")


def test_a_part_that_no_arm_can_take_is_left_with_its_reason(cell):
    # The second one is drawn into the floor: no hand comes near it.
    first, taken = of(cell, pair(cell, *APART, sunk=(0.0, 0.06)))
    assert [one.detection for one in first.plan.arms] == [0]
    assert (taken.parts, taken.is_whole) == (1, False)
    assert taken.why.startswith("the other part by no arm: ")
    reasons = {str(one.verdict.reason) for one in first.candidates if one.detection == 1}
    assert taken.why.removeprefix("the other part by no arm: ") in reasons
    assert taken.left.startswith("one: ")


def test_of_two_for_the_same_arm_a_second_plan_takes_the_other(cell):
    first, taken = of(cell, pair(cell, *APART), strategy="right")
    assert [one.arm for one in first.plan.arms] == ["right"]
    assert (taken.parts, taken.is_whole, taken.left) == (1, True, "")


def test_parts_of_one_heap_are_taken_one_after_the_other(cell):
    near = replace(cell, policy=replace(cell.policy, pair_gap=0.15))
    first, taken = of(near, pair(near, *APART))
    assert len(first.plan.arms) == 1
    assert taken == Taken(1, "the parts are of one heap", True, "")


def test_nothing_is_taken_where_nothing_works_or_the_proof_does_not_hold(cell):
    _, taken = of(cell, pair(cell, *APART, sunk=(0.06, 0.06)))
    assert (taken.parts, taken.is_whole) == (0, False)
    assert taken.why == taken.left and taken.why.startswith("neither: ")
    good = pair(cell, *APART)
    first, _ = of(cell, good)
    bad = replace(first, proof=replace(first.proof, violations=(Violation(plain("too close")),)))
    refused = taken_of(cell, good, bad, 0)
    assert refused == Taken(0, "neither: the proof does not hold", False, refused.why)


def test_every_pair_is_counted_once_with_its_reason():
    found = [
        Taken(2, "", True, ""),
        Taken(1, "both parts by the same arm alone", True, ""),
        Taken(1, "the other part by no arm: no place", False, "one: no place"),
        Taken(1, "both parts by the same arm alone", True, ""),
        Taken(0, "neither: out of reach", False, "neither: out of reach"),
    ]
    said = count_pairs(found)
    assert (said["pairs"], said["two_arms"], said["one_arm"], said["none"]) == (5, 1, 3, 1)
    assert said["whole"] == 3
    assert list(said["why_one_arm"].items()) == [
        ("both parts by the same arm alone", 2),
        ("the other part by no arm: no place", 1),
    ]
    assert said["why_none"] == {"neither: out of reach": 1}
    assert said["why_not_whole"] == {"neither: out of reach": 1, "one: no place": 1}
    assert count_pairs(found[::-1]) == said
    json.dumps(said)


def test_the_table_says_what_was_counted():
    found = [Taken(2, "", True, ""), Taken(1, "no plan of two arms", False, "one: no path")]
    assert _pairs_words(count_pairs(found)) == [
        ("both by one plan of two arms", "1", ""),
        ("one by the first plan", "1", "1 no plan of two arms"),
        ("none", "0", ""),
        ("both, a second plan counted", "1", "1 one: no path"),
    ]
