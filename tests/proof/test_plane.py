"""Bodies never come nearer within a set than the planes between them say."""

import numpy as np
import pytest

from workbench.proof.bodies import bodies_of
from workbench.proof.motion import Sets
from workbench.proof.robot import tree_of
from workbench.proof.search import combined
from workbench.proof.space import Space
from workbench.proof.stages import steps_of
from workbench.proof.table import Situation, Table


@pytest.fixture(scope="module")
def space(cell, result):
    tree = tree_of(cell)
    bodies = bodies_of(cell, tree, result.plan.scene)
    return Space(tree, bodies, Table(cell, tree, bodies))


def within(space, base, blocks, rows, commons):
    """The bound of each pair in one set, the distances in its middle, and plain bounds."""
    (some,) = combined(blocks)
    q, spans = some.middles(base), some.spans(len(base))
    items = np.zeros(len(rows), np.int64)
    needs = np.full(len(rows), np.inf)
    _, moves, world = space.bounds(q, spans, items, rows, commons, needs)
    space.look(q[0])
    middle = np.array([space.distance(int(row)) for row in rows])
    corners = some.corners(base, q)
    bounds = [
        space.within(int(row), int(common), 0, world, spans, corners)
        for row, common in zip(rows, commons, strict=True)
    ]
    return np.array(bounds), middle, middle - moves


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
            blocks.append(Sets(columns, hull, np.zeros(1, np.int64)))
            moves[columns] = True
        pairs = space.table.pairs(Situation(moves), space.joints)
        chosen = draw.choice(len(pairs.rows), 150, replace=False)
        rows, commons = pairs.rows[chosen], pairs.commons[chosen]
        bounds, middle, plain = within(space, step.base, tuple(blocks), rows, commons)
        smallest = middle.copy()
        for _ in range(40):
            q = step.base.copy()
            for block in blocks:
                shares = draw.dirichlet(np.full(corners, draw.choice([0.1, 1.0])))
                q[block.columns] = shares @ block.corners[0]
            space.look(q)
            smallest = np.minimum(smallest, [space.distance(int(row)) for row in rows])
        worst = min(worst, float((smallest - bounds).min()))
        told += int(np.isfinite(bounds).sum())
        better += int((bounds > plain).sum())
    assert told > 1000
    assert worst >= 0.0
    assert better > told / 2
