"""What the proof computes by itself, beside Pinocchio, Coal and dense sampling."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import nnls

from workbench.model.motion import MotionModel
from workbench.proof.claims.motion import sweep_path
from workbench.proof.claims.scene import scene_bodies
from workbench.proof.claims.stages import steps_of
from workbench.proof.claims.table import PairTable, Situation
from workbench.proof.claims.walk import Walk
from workbench.proof.engine.frames import SetExtents, poses
from workbench.proof.engine.robot import tree_of
from workbench.proof.engine.sieve import PairQuery, select_pairs_in_sight, sieve
from workbench.proof.engine.space import Space

RESOLUTION = 0.0005


@pytest.fixture(scope="module")
def tree(cell):
    return tree_of(cell)


@pytest.fixture(scope="module")
def space(cell, tree, result):
    bodies = scene_bodies(cell, tree, result.plan.scene)
    return Space(tree, bodies, PairTable(cell, tree, bodies))


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


def bounds_of(space, q, spans, pairs):
    """What the sieve says of pairs at one configuration with so much room around it."""
    number = len(pairs.rows)
    first, second = space.table.first[pairs.rows], space.table.second[pairs.rows]
    asked = PairQuery(first, second, pairs.commons, np.full(number, np.inf), np.zeros(number, bool))
    needed = np.ones(len(space.joints), bool)
    world = poses(space.chain, space.arrays, q[None], spans[None], needed)
    room = SetExtents(spans[None], np.stack([spans, -spans])[None], np.array([2]))
    items = np.zeros((number, 3), np.int64)
    items[:, 2] = np.arange(number)
    normals = np.zeros_like(space.normals)
    return sieve(
        items,
        asked,
        np.zeros(1),
        items[:1, 0],
        np.zeros(1),
        normals,
        space.chain,
        space.arrays,
        world,
        room,
    )


def test_quick_bounds_never_exceed_what_coal_measures(tree, space):
    rng = np.random.default_rng(5)
    pairs = space.table.pairs(Situation(np.ones(tree.model.nq, bool)), space.joints)
    pairs = pairs.among(np.arange(len(pairs.rows)) % 7 == 0)
    for q in anywhere(tree, rng, 20):
        lower = bounds_of(space, q, np.zeros_like(q), pairs).lower
        space.look(q)
        measured = np.array([space.distance(int(row)) for row in pairs.rows])
        apart = measured > 0
        assert (lower[apart] <= measured[apart] + 1e-7).all()
        assert (lower[~apart] <= 1e-7).all()
        assert np.corrcoef(lower[apart], measured[apart])[0, 1] > 0.95, "bounds say something"


def test_nothing_comes_nearer_than_the_bound_on_motions_allows(cell, tree, space):
    """Configurations around one, as far as they may be: every pair, measured."""
    rng = np.random.default_rng(6)
    pairs = space.table.pairs(Situation(np.ones(tree.model.nq, bool)), space.joints)
    pairs = pairs.among(np.isin(np.arange(len(pairs.rows)), rng.choice(len(pairs.rows), 150)))
    for q in anywhere(tree, rng, 6):
        spans = rng.uniform(0.0, 0.2, len(q))
        spans[np.concatenate([tree.columns[arm.name][-2:] for arm in cell.arms])] *= 0.05
        nearer = bounds_of(space, q, spans, pairs).moves
        space.look(q)
        before = np.array([space.distance(int(row)) for row in pairs.rows])
        for _ in range(10):
            space.look(q + rng.choice([-1.0, 1.0], len(q)) * spans)
            after = np.array([space.distance(int(row)) for row in pairs.rows])
            both = (before > 0) & (after > 0)
            assert (before[both] - after[both] <= nearer[both] + 1e-7).all()


def test_what_is_not_looked_at_is_out_of_sight(cell, tree, space):
    """Pairs that are left out for a whole motion are farther apart than is ever told."""
    rng = np.random.default_rng(7)
    pairs = space.table.pairs(Situation(np.ones(tree.model.nq, bool)), space.joints)
    first, second = space.table.first[pairs.rows], space.table.second[pairs.rows]
    asked = PairQuery(first, second, pairs.commons, pairs.margins, pairs.shown)
    out = 0
    for start, end in zip(anywhere(tree, rng, 8), anywhere(tree, rng, 8), strict=True):
        path = np.linspace(start, start + 0.1 * (end - start), 6)
        middles, spans = (path[1:] + path[:-1]) / 2, np.abs(np.diff(path, axis=0)) / 2
        sides = np.zeros(len(space.joints), np.int64)
        world = poses(space.chain, space.arrays, middles, spans, sides == 0)
        items = select_pairs_in_sight(asked, 0.1, sides, len(middles), space.arrays, world)
        assert (items[:, 0] == items[:, 1]).all()
        assert len(items) == len(path[1:]) * len(set(items[:, 2]))
        left = np.setdiff1d(np.arange(len(pairs.rows)), items[:, 2])
        out += len(left)
        for q in np.linspace(path[0], path[-1], 23):
            space.look(q)
            for k in left:
                needs = max(pairs.margins[k], 0.1) if pairs.shown[k] else pairs.margins[k]
                assert space.distance(int(pairs.rows[k])) >= needs
    assert out > 100


def test_all_blends_of_a_corner_lie_in_its_triangles():
    """Every point of parabolas of every width is a mean of some triangle's corners."""
    path = np.array([[0.0, 0.0], [1.0, 0.0], [1.5, 1.0]])
    sets = sweep_path(np.arange(2), path, MotionModel("blends", corners="blend"), 0.4)
    corners = sets.corners[sets.sizes == 3]
    for zone in np.linspace(0.02, 0.4, 20):
        start, end = path[1] - zone * (path[1] - path[0]), path[1] + zone * (path[2] - path[1])
        for u in np.linspace(0, 1, 30):
            point = (1 - u) ** 2 * start + 2 * u * (1 - u) * path[1] + u**2 * end
            shares = [
                np.linalg.solve(np.vstack([triangle.T, np.ones(3)]), [*point, 1.0])
                for triangle in corners
            ]
            assert max(share.min() for share in shares) > -1e-9


@pytest.mark.parametrize("corners, count", [("stop", 0), ("blend", 14), ("streamed", 2)])
def test_a_controller_that_stops_is_walked_along_the_polyline_alone(corners, count):
    motion = MotionModel("any", corners=corners, period=0.004)
    path = np.arange(12.0).reshape(4, 3) ** 1.5
    sets = sweep_path(np.arange(3), path, motion, 0.2)
    segments = sets.corners[sets.sizes == 2]
    assert np.array_equal(segments[:, 0], path[:-1])
    assert np.array_equal(segments[:, 1], path[1:])
    assert sets.at[sets.groups[sets.sizes == 2]].tolist() == [0, 1, 2]
    assert (sets.sizes == 3).sum() == count


@pytest.mark.parametrize("corners", ["stop", "blend", "streamed"])
@pytest.mark.parametrize("waypoints", [1, 2])
def test_where_there_is_no_corner_there_are_segments_alone(corners, waypoints):
    path = np.arange(waypoints * 2.0).reshape(waypoints, 2)
    sets = sweep_path(np.arange(2), path, MotionModel("any", corners=corners, period=0.004), 0.3)
    assert sets.sizes.tolist() == [2] * (waypoints - 1)
    assert len(sets.corners) == len(sets.groups) == len(sets.at) == waypoints - 1


@pytest.mark.parametrize("corners", ["stop", "blend", "streamed"])
def test_what_is_around_a_group_holds_its_sets(corners):
    """Each corner of a set is a mean of the corners of what is around it."""
    path = np.random.default_rng(2).normal(size=(6, 2))
    sets = sweep_path(np.arange(2), path, MotionModel("any", corners=corners, period=0.004), 0.3)
    for group, some, size in zip(sets.groups, sets.corners, sets.sizes, strict=True):
        hull = np.vstack([sets.around[group].T, np.ones(3)])
        for corner in some[:size]:
            shares, _ = nnls(hull, [*corner, 1.0])
            assert hull @ shares == pytest.approx([*corner, 1.0], abs=1e-9)
    chosen = sets.after(np.array([True, False, True, True, False]))
    assert chosen.at.tolist() == [0, 2, 3]
    assert np.unique(chosen.groups).tolist() == [0, 1, 2]
    pieces = list(chosen.runs(2))
    assert [len(piece.at) for piece in pieces] == [2, 1]
    assert sum(len(piece.sizes) for piece in pieces) == len(chosen.sizes)


def test_clearances_are_bounds_of_what_dense_samples_show(cell, tree, result):
    """On every leg, after every waypoint: nothing sampled is nearer than the proof says."""
    plan = result.plan
    walk = Walk(cell, tree, plan, RESOLUTION)
    walked = walk.result()
    assert walked.violations == ()
    said = {(arm, leg): bounds for arm, leg, bounds in walked.clearances}
    sampler = Walk(cell, tree, plan, RESOLUTION)
    smallest = np.inf
    numbers = {arm.name: number for number, arm in enumerate(cell.arms)}
    for step in steps_of(cell, tree, plan):
        for one in step.moving:
            if one.leg.name not in ("reach", "return"):
                continue
            sampler._put(step)
            moves = np.zeros(tree.model.nq, bool)
            moves[tree.columns[one.arm.name]] = True
            held = {number: held.arm for number, held in step.held.items()}
            placed = {number: other.arm for number, other in step.placed.items()}
            pairs = sampler._pairs(Situation(moves, held, placed))
            for other in step.moving:
                if other is not one:  # which moves meanwhile
                    both = numbers[one.arm.name], numbers[other.arm.name]
                    pairs = pairs.among(~pairs.between(*both))
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


@pytest.mark.parametrize("k", [0, 1, 2])
def test_a_body_of_which_nobody_knows_where_it_is_is_always_looked_at(tree, space, k):
    """Whichever of the sets has it: no comparison may take it for far away."""
    pairs = space.table.pairs(Situation(np.ones(tree.model.nq, bool)), space.joints)
    first, second = space.table.first[pairs.rows], space.table.second[pairs.rows]
    asked = PairQuery(first, second, pairs.commons, pairs.margins, pairs.shown)
    q, sides = np.tile(tree.rest, (3, 1)), np.zeros(len(space.joints), np.int64)
    world = poses(space.chain, space.arrays, q, np.zeros_like(q), sides == 0)

    def looked_at(where):
        return set(select_pairs_in_sight(asked, 0.0, sides, 3, space.arrays, where)[:, 2].tolist())

    known = looked_at(world)
    everywhere = set(range(len(pairs.rows)))
    body = int(np.bincount(np.concatenate([first, second])).argmax())
    with_it = set(np.flatnonzero((first == body) | (second == body)).tolist())
    assert with_it - known, "some pairs of it are far apart"
    for axis in range(3):
        lost = poses(space.chain, space.arrays, q, np.zeros_like(q), sides == 0)
        lost.centres[k, body, axis] = np.nan
        assert with_it <= looked_at(lost) < everywhere
    lost = poses(space.chain, space.arrays, q, np.zeros_like(q), sides == 0)
    lost.moves[k, body] = np.nan
    assert with_it <= looked_at(lost)


def test_a_pair_is_measured_alike_whichever_was_measured_first(cell, tree, space):
    """Room for a pair is made when it is first measured: each has its own."""
    rows = range(0, len(space.table.first), 5)
    (q,) = anywhere(tree, np.random.default_rng(8), 1)

    def measured(order):
        fresh = Space(tree, space.bodies, space.table)
        fresh.look(q)
        return {row: (fresh.distance(row), *fresh.way().tolist()) for row in order}

    first, last = measured(rows), measured(reversed(rows))
    assert first == last
    assert len({distance for distance, *_ in first.values()}) > len(rows) // 2
