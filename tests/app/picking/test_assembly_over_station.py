"""Parts of an assembly that no grasp inserts directly: over a station, and then onto their base."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from over_stations import bolt_in_nest, cell_with_post, lying_spacer

from workbench.app.picking.pallets import boxes_around
from workbench.app.picking.row import plan_row
from workbench.app.picking.stations import standing_before, station_problems
from workbench.model.derived.assembling import assembled_pose, insertion_of
from workbench.model.derived.by_recipe import wanted_parts
from workbench.model.digest import digest_of
from workbench.model.scan import Detection, Scene
from workbench.planning.placing.sources import localization_error, moves_by_scanner
from workbench.proof.claims.prove import prove, scene_after
from workbench.proof.claims.stages import put_at
from workbench.proof.engine.robot import tree_of

CELL = cell_with_post()
SPACER = lying_spacer(CELL)
BOLT = bolt_in_nest(CELL)


@pytest.fixture(scope="module")
def row():
    wanted = wanted_parts(CELL, {"bolt": 1})
    return plan_row(CELL, (SPACER,), digest_of((SPACER,)), obstacles=BOLT, wanted=wanted)


def test_no_grasp_inserts_the_spacer_directly():
    cell = replace(CELL, stations=())
    asked = {"obstacles": BOLT, "wanted": wanted_parts(CELL, {"bolt": 1})}
    assert plan_row(cell, (SPACER,), digest_of((SPACER,)), **asked).plan is None


def test_over_the_post_it_comes_onto_the_bolt(row):
    first, second = row.plans
    assert row.proof.holds and row.row[0].proof.holds
    assert (first.stations, second.stations) == (("post",), ())
    after = scene_after(CELL, second)
    T_bolt, T_spacer = (assembled_pose(CELL, after.obstacles, kind) for kind in ("bolt", "spacer"))
    seat = insertion_of(CELL, "spacer").T_base_part
    off = seat.actInv(T_bolt.actInv(T_spacer))
    # It falls by up to 3 mm onto the head.
    assert np.linalg.norm(off.translation[:2]) < 0.0005 and abs(off.translation[2]) < 0.003


def test_its_error_on_the_post_is_that_of_the_hand_that_put_it_there(row):
    (standing,) = row.row[0].plan.detections
    assert standing.placing is not None
    by_scanner = moves_by_scanner(CELL.scanner, standing)
    R = np.kron(np.eye(2), standing.T_world_part.rotation)
    np.testing.assert_allclose(by_scanner, R @ standing.placing.by_scanner)
    known = localization_error(standing)
    np.testing.assert_allclose(known, R @ standing.placing.covariance @ R.T)
    # The fingers have centred it along their travel, which is y of the TCP as it puts it down.
    plan = row.plan
    T_put = put_at(CELL, tree_of(CELL), plan, plan.arms[0])
    travel = T_put.rotation @ plan.arms[0].T_tcp_part.rotation.T[:, 1]
    centre = known[:3, :3]
    assert travel @ centre @ travel < np.linalg.eigvalsh(localization_error(SPACER)[:3, :3])[0]
    assert travel @ centre @ travel < 1.2 * np.linalg.eigvalsh(centre)[0]


def test_on_its_motion_to_the_post_it_may_not_come_as_near_to_a_bolt_as_in_its_seat(row):
    """A bolt that stands 2 mm beside where the spacer is put, as near as only a seat allows."""
    plan = row.plan
    T_put = put_at(CELL, tree_of(CELL), plan, plan.arms[0])
    # Along the pads the spacer is wider than these.
    along_pads = T_put.rotation @ plan.arms[0].T_tcp_part.rotation.T[:, 0]
    spacer, bolt = (np.asarray(CELL.part(kind).mesh.points) for kind in ("spacer", "bolt"))
    reach = float((spacer @ T_put.rotation.T @ along_pads).max() + (bolt @ along_pads).max())
    T = pin.SE3(np.eye(3), T_put.translation + (reach + 0.002) * along_pads)
    (near,) = boxes_around(CELL, [Detection("bolt", T)])
    scene = Scene(plan.scan_digest, plan.detections, (near,))
    proof = prove(CELL, scene, replace(plan, obstacles=(near,)))
    met = {(violation.leg, *sorted(violation.pair or ())) for violation in proof.violations}
    assert ("place", "bolt", "part-1") in met


def test_a_check_of_the_cell_has_the_bolt_in_its_nest():
    assert [box.part for box in standing_before(CELL, "spacer")] == ["bolt"]
    assert standing_before(CELL, "bolt") == ()
    assert list(station_problems(replace(CELL, recipe=0))) == []


def test_a_base_that_has_to_be_seen_again_is_in_view_for_the_check():
    plain = replace(CELL, recipe=0)
    looks_again = tuple(recipe for recipe in plain.recipes if recipe.number == 2)
    assert list(station_problems(replace(plain, recipes=looks_again))) == []
