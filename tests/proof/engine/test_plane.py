"""Bodies never come nearer within a set than the planes between them say."""

import coal
import numpy as np
import pytest

from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Sphere
from workbench.proof.claims.scene import scene_bodies
from workbench.proof.claims.stages import steps_of
from workbench.proof.claims.table import PairTable, Situation
from workbench.proof.engine.batch import firsts, spread
from workbench.proof.engine.frames import poses
from workbench.proof.engine.robot import tree_of
from workbench.proof.engine.sets import Sets
from workbench.proof.engine.shapes import coal_shape, hull
from workbench.proof.engine.sieve import PairQuery, planes, sieve
from workbench.proof.engine.space import Space


@pytest.fixture(scope="module")
def space(cell, result):
    tree = tree_of(cell)
    bodies = scene_bodies(cell, tree, result.plan.scene)
    return Space(tree, bodies, PairTable(cell, tree, bodies))


def within(space, base, blocks, rows, commons):
    """The bounds of each pair in one set of each arm: along its direction, along any, plain ones.

    Where two arms move, the first of a pair is on the one and the second on the other.
    """
    batch = firsts(base, blocks)
    q, spreads = spread(batch.corners, batch.sizes, True)
    needed = np.ones(len(space.joints), bool)
    world = poses(space.chain, space.arrays, q, spreads.spans, needed)
    number, none = len(rows), np.zeros(len(rows), bool)
    first, second = space.table.first[rows], space.table.second[rows]
    asked = PairQuery(first, second, commons, np.full(number, np.inf), none)
    items = np.zeros((number, 3), np.int64)
    items[:, 2] = np.arange(number)
    if len(blocks) > 1:
        other = space.tree.ancestors[space.joints][:, blocks[1].columns].any(axis=1)
        items[:, 0], items[:, 1] = other[first], other[second]
    middles = base.copy()
    for number, block in enumerate(blocks):
        middles[block.columns] = q[number, block.columns]
    space.look(middles)
    measured = [(space.distance(int(row)), space.way()) for row in rows]
    middle, ways = map(np.array, zip(*measured, strict=True))
    compiled = space.chain, space.arrays, world, spreads
    space.normals[:] = 0.0
    along = planes(items, ways, asked, space.normals, *compiled)
    close = sieve(items, asked, np.zeros(1), batch.at, np.zeros(1), space.normals, *compiled)
    assert np.array_equal(close.items, items), "nothing is ever far enough"
    return along, close, middle


def test_a_body_reaches_as_far_as_its_points(cell, result, space):
    """Boxes, cylinders, capsules, spheres and meshes: what Coal says of them along a direction."""
    draw = np.random.default_rng(3)
    shapes = [
        Box(np.array([0.1, 0.2, 0.3])),
        Sphere(0.1),
        Cylinder(0.05, 0.3),
        Capsule(0.05, 0.3),
        next(body.shape for body in space.bodies if isinstance(body.shape, Mesh)),
    ]
    for shape in shapes:
        one = hull(shape)
        for _ in range(100):
            n = draw.normal(size=3)
            n /= np.linalg.norm(n)
            far = coal.Halfspace(-n, -2.0)
            distance = coal.distance(
                coal_shape(shape),
                coal.Transform3s(),
                far,
                coal.Transform3s(),
                coal.DistanceRequest(),
                coal.DistanceResult(),
            )
            reach = (one.points @ n).max() + np.abs(one.box * n).sum() + one.centre @ n
            reach += one.disc * np.hypot(n[0], n[1]) + one.ball
            assert reach == pytest.approx(2.0 - distance, abs=1e-6)


@pytest.mark.parametrize("corners", [2, 3])
@pytest.mark.parametrize("arms", [("right",), ("right", "left")])
def test_nothing_in_a_set_is_nearer_than_is_said(cell, result, space, corners, arms):
    """Ten thousand pairs in random sets, each measured at many of its configurations."""
    draw = np.random.default_rng(len(arms) * 10 + corners)
    tree, steps = space.tree, list(steps_of(cell, space.tree, result.plan))
    worst, better, told = np.inf, 0, 0
    for _ in range(12):
        step = steps[draw.integers(len(steps))]
        size = 10.0 ** draw.uniform(-2.5, -0.3)
        moves, blocks = np.zeros(tree.model.nq, bool), []
        for arm in arms:
            columns = tree.columns[arm]
            hull = step.base[columns] + draw.uniform(-size, size, (1, corners, len(columns)))
            hull[:, :, 7:] = draw.uniform(0.0, 0.02, (1, corners, len(columns) - 7))
            whole = np.concatenate([hull, hull[:, :1]], axis=1)[:, :3]
            zero = np.zeros(1, np.int64)
            blocks.append(Sets(columns, whole, zero + corners, zero, whole, zero))
            moves[columns] = True
        pairs = space.table.pairs(Situation(moves), space.joints)
        some = np.arange(len(pairs.rows))
        if len(arms) > 1:
            # Two arms that move at any speeds are asked about each other alone.
            some = np.flatnonzero(pairs.between(0, 1))
        chosen = draw.choice(some, 150, replace=False)
        rows, commons = pairs.rows[chosen], pairs.commons[chosen]
        along, close, middle = within(space, step.base, tuple(blocks), rows, commons)
        smallest = middle.copy()
        for _ in range(40):
            q = step.base.copy()
            for block in blocks:
                shares = draw.dirichlet(np.full(corners, draw.choice([0.1, 1.0])))
                q[block.columns] = shares @ block.corners[0, :corners]
            space.look(q)
            smallest = np.minimum(smallest, [space.distance(int(row)) for row in rows])
        for bounds in (along, close.whole_bounds, close.lower - close.moves):
            worst = min(worst, float((smallest - bounds)[smallest > 0].min()))
        assert (np.maximum(along, close.whole_bounds)[smallest <= 0] <= 0).all()
        is_apart = middle > 0
        told += int(is_apart.sum())
        better += int((along > middle - close.moves)[is_apart].sum())
    assert told > 1000
    assert worst >= 0.0
    assert better > told / 2
