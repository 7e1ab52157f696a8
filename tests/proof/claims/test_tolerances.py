"""Tolerances are displacements of points: a long part keeps the same millimetres as a short one."""

import importlib
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from bent_cells import cases

from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Obstacle
from workbench.proof.claims.prove import prove, scene_after
from workbench.proof.claims.scene import roll_turns
from workbench.proof.claims.stages import in_hand, put_at
from workbench.proof.claims.tolerances import displacement, largest_turn
from workbench.proof.engine.robot import tree_of

TABLE = Path(__file__).resolve().parents[3] / "docs" / "proof.md"


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    return next(cases("plate_300", range(7, 20), tmp_path_factory.mktemp("plate")))


def stated(case, T):
    (one,) = case.plan.arms
    one = replace(one, T_tcp_part=one.T_tcp_part * T)
    return replace(case, plan=replace(case.plan, arms=(one,)))


def violations(case):
    return [str(one.problem) for one in prove(case.cell, case.scene, case.plan).violations]


def test_the_table_of_the_documents_has_every_tolerance_as_it_is():
    listed = r"^- `(\w+\.[\w.]+)` \(([\d.]+) (mm|degrees)\)"
    rows = re.findall(listed, TABLE.read_text("utf-8"), re.M)
    assert len(rows) == 21
    for name, shown, unit in rows:
        module, _, constant = name.rpartition(".")
        value = getattr(importlib.import_module(f"workbench.proof.claims.{module}"), constant)
        least = min(value) if isinstance(value, tuple) else value
        scaled = least * 1000 if unit == "mm" else np.rad2deg(least)
        assert scaled == pytest.approx(float(shown)), name
    module = importlib.import_module("workbench.proof.claims.tolerances")
    lengths = {name for name in vars(module) if name.isupper()}
    others = {"HAND_TURN", "FEWEST_TURNS"}
    assert {name.removeprefix("tolerances.") for name, _, _ in rows} >= lengths - others


@pytest.mark.parametrize(
    ("shift", "degrees"), [(0.0, 0.9), (0.0, -0.9), (0.0009, 0.0), (0.0001, 0.0), (0.0, 0.03)]
)
def test_a_long_part_stated_a_little_off_in_the_hand_is_refused(plate, shift, degrees):
    off = pose_from_rpy((0.0, shift, 0.0), (0.0, 0.0, np.deg2rad(degrees)))
    assert violations(plate) == []
    assert "the part is not where the hand closes" in violations(stated(plate, off))


def test_a_statement_within_a_twentieth_of_a_millimetre_is_taken(plate):
    points = np.asarray(plate.cell.parts[0].mesh.points)
    off = pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, 0.0003))
    assert 0.00004 < displacement(points, off, pose_from_rpy((0, 0, 0))) < 0.00005
    assert violations(stated(plate, off)) == []


def test_the_part_in_the_hand_is_walked_where_it_is_and_not_where_the_plan_states_it(plate):
    """Something stands 9 mm beside a corner of the plate, and 11.5 mm beside the stated one."""
    turned = stated(plate, pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(-0.95))))
    cell, plan, tree = plate.cell, plate.plan, tree_of(plate.cell)
    (one,) = plan.arms
    T_put = put_at(cell, tree, plan, one)
    corner = T_put.act(np.array([0.15, 0.06, 0.0]))
    side = T_put.rotation @ np.array([0.0, 1.0, 0.0])
    box = Obstacle(pose_from_rpy(corner + side * 0.019), np.array([0.02, 0.02, 0.2]))
    scene = replace(plate.scene, obstacles=(*plate.scene.obstacles, box))
    bent = replace(turned, scene=scene, plan=replace(turned.plan, obstacles=scene.obstacles))
    assert cell.policy.margin == 0.01
    found = prove(cell, scene, bent.plan).violations
    assert any("seen-" in str(one.pair) and "part-" in str(one.pair) for one in found)


def test_what_a_plan_leaves_behind_is_where_the_hand_lets_go_of_it(plate):
    turned = stated(plate, pose_from_rpy((0, 0, 0), (0, 0, 0.0003)))
    (before,), (after,) = (scene_after(plate.cell, one.plan).obstacles for one in (plate, turned))
    assert before.T_world_box.isApprox(after.T_world_box, 1e-12)
    (one,), tree = plate.plan.arms, tree_of(plate.cell)
    assert in_hand(plate.cell, tree, turned.plan, one).isApprox(one.T_tcp_part, 1e-9)


def test_a_hand_with_a_long_part_may_turn_less_on_a_straight_line():
    assert np.rad2deg(largest_turn(0.02)) == pytest.approx(1.5)
    assert largest_turn(0.4) * 0.4 == pytest.approx(0.005)


def test_a_part_of_unknown_roll_is_checked_at_more_turns_the_larger_it_is(plate):
    known = plate.plan.detections[0]
    unknown = replace(known, roll_known=False, roll_axis=np.array([[0, 0, 0], [0, 0, 1.0]]))
    part = plate.cell.parts[0]
    count, radius = roll_turns(part, unknown), float(np.hypot(0.15, 0.06))
    assert roll_turns(part, known) == 1
    assert radius * np.pi / count <= 0.001 < radius * np.pi / (count - 2)


def test_a_leg_that_begins_one_step_of_the_wire_beside_the_last_one_is_refused(plate):
    (one,) = plate.plan.arms
    legs = {leg.name: leg for leg in one.legs}
    q = np.array(legs["return"].q)
    q[0, 0] += np.deg2rad(0.01)
    changed = tuple(replace(leg, q=q) if leg.name == "return" else leg for leg in one.legs)
    plan = replace(plate.plan, arms=(replace(one, legs=changed),))
    assert violations(replace(plate, plan=plan)) == ["does not start where the arm stands"]
