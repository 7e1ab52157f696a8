"""What the proof computes by itself, beside Pinocchio, Coal and dense sampling."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.model.motion import MotionModel
from workbench.proof.bodies import bodies_of
from workbench.proof.motion import moved
from workbench.proof.robot import tree_of
from workbench.proof.space import Space
from workbench.proof.stages import steps_of
from workbench.proof.table import Situation, Table
from workbench.proof.walk import Walk

RESOLUTION = 0.0005


@pytest.fixture(scope="module")
def tree(cell):
    return tree_of(cell)


@pytest.fixture(scope="module")
def space(cell, tree, result):
    bodies = bodies_of(cell, tree, result.plan.scene)
    return Space(tree, bodies, Table(cell, tree, bodies))


def anywhere(tree, rng, count):
    low, high = tree.model.lowerPositionLimit, tree.model.upperPositionLimit
    return rng.uniform(low, high, (count, tree.model.nq))


def test_hands_are_where_pinocchio_and_the_cell_have_them(cell, tree, result):
    """The legs of a plan end where its places are; fingers are joints that open both ways."""
    for one in result.plan.arms:
        arm = cell.arm(one.arm)
        q = tree.rest.copy()
        q[tree.columns[arm.name][: len(arm.joints)]] = one.leg("place").q[-1]
        q[tree.columns[arm.name][len(arm.joints) :]] = 0.01
        data = tree.model.createData()
        pin.forwardKinematics(tree.model, data, q)
        joint, T_joint_flange = tree.flange(arm)
        T_world_tcp = data.oMi[joint] * T_joint_flange * arm.tool.T_flange_tcp
        off = min(
            float(np.linalg.norm(T_world_tcp.actInv(T).translation)) for T in arm.Ts_world_place
        )
        assert off < 1e-3
        first, second = (data.oMi[finger].translation for finger in tree.fingers[arm.name])
        assert np.linalg.norm(first - second) == pytest.approx(0.02, abs=1e-9)


def test_quick_bounds_never_exceed_what_coal_measures(tree, space):
    rng = np.random.default_rng(5)
    rows = np.arange(0, len(space.table.first), 7)
    for q in anywhere(tree, rng, 20):
        items, needs = np.zeros(len(rows), int), np.full(len(rows), 10.0)
        lower, _, _ = space.bounds(q[None], np.zeros((1, len(q))), items, rows, items, needs)
        space.look(q)
        measured = np.array([space.distance(int(row)) for row in rows])
        apart = measured > 0
        assert (lower[apart] <= measured[apart] + 1e-7).all()
        assert (lower[~apart] <= 1e-7).all()
        assert np.corrcoef(lower[apart], measured[apart])[0, 1] > 0.95, "bounds say something"


def test_nothing_comes_nearer_than_the_bound_on_motions_allows(cell, tree, space):
    """Configurations around one, as far as they may be: every pair, measured."""
    rng = np.random.default_rng(6)
    moves = np.ones(tree.model.nq, bool)
    pairs = space.table.pairs(Situation(moves), space.joints)
    some = rng.choice(len(pairs.rows), 150, replace=False)
    rows, commons, items = pairs.rows[some], pairs.commons[some], np.zeros(150, int)
    for q in anywhere(tree, rng, 6):
        spans = rng.uniform(0.0, 0.2, len(q))
        spans[np.concatenate([tree.columns[arm.name][-2:] for arm in cell.arms])] *= 0.05
        _, nearer, _ = space.bounds(q[None], spans[None], items, rows, commons, np.full(150, 10.0))
        space.look(q)
        before = np.array([space.distance(int(row)) for row in rows])
        for _ in range(10):
            space.look(q + rng.choice([-1.0, 1.0], len(q)) * spans)
            after = np.array([space.distance(int(row)) for row in rows])
            both = (before > 0) & (after > 0)
            assert (before[both] - after[both] <= nearer[both] + 1e-7).all()


def test_all_blends_of_a_corner_lie_in_its_triangles():
    """Every point of parabolas of every width is a mean of some triangle's corners."""
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.5, 1.0]])
    _, corners = moved(np.arange(2), path, MotionModel("blends", corners="blend"), 0.4)
    for zone in np.linspace(0.02, 0.4, 20):
        start, end = path[1] - zone * (path[1] - path[0]), path[1] + zone * (path[2] - path[1])
        for u in np.linspace(0, 1, 30):
            point = (1 - u) ** 2 * start + 2 * u * (1 - u) * path[1] + u**2 * end
            shares = [
                np.linalg.solve(np.vstack([triangle.T, np.ones(3)]), [*point, 1.0])
                for triangle in corners.corners
            ]
            assert max(share.min() for share in shares) > -1e-9


@pytest.mark.parametrize("corners, count", [("stop", 1), ("blend", 2), ("streamed", 2)])
def test_a_controller_that_stops_is_walked_along_the_polyline_alone(corners, count):
    motion = MotionModel("any", corners=corners, period=0.004)
    sets = moved(np.arange(3), np.arange(12.0).reshape(4, 3) ** 1.5, motion, 0.2)
    assert len(sets) == count
    assert sets[0].corners.shape == (3, 2, 3)


def test_clearances_are_bounds_of_what_dense_samples_show(cell, tree, result):
    """On every leg, after every waypoint: nothing sampled is nearer than the proof says."""
    plan = result.plan
    walk = Walk(cell, tree, plan, RESOLUTION)
    walked = walk.result()
    assert walked.findings == ()
    said = {(arm, leg): bounds for arm, leg, bounds in walked.clearances}
    sampler = Walk(cell, tree, plan, RESOLUTION)
    smallest = np.inf
    for step in steps_of(cell, tree, plan):
        (one,) = step.moving
        if one.leg.name not in ("reach", "return"):
            continue
        sampler._put(step)
        moves = np.zeros(tree.model.nq, bool)
        moves[tree.columns[one.arm.name]] = True
        held = {number: held.arm for number, held in step.held.items()}
        placed = {number: other.arm for number, other in step.placed.items()}
        pairs = sampler._pairs(Situation(moves, held, placed))
        rows = pairs.rows[pairs.shown]
        for k in range(len(one.path) - 1):
            for share in np.linspace(0, 1, 6):
                values = (1 - share) * one.path[k] + share * one.path[k + 1]
                sampler._space.look(sampler._with(step, one, values))
                nearest = min(sampler._space.distance(int(row)) for row in rows)
                assert nearest >= said[one.arm.name, one.leg.name][k] - 1e-9
                smallest = min(smallest, nearest)
    assert walked.clearance <= smallest + 1e-9
    assert walked.nearest is not None
    assert walked.nearest.distance - 0.0005 <= walked.clearance <= walked.nearest.distance
