"""How much nearer bodies come along a direction, beside where their corners really go."""

from itertools import product

import numpy as np
import pytest

from workbench.planning.collision.bounds import nearing
from workbench.planning.collision.motion import RESOLUTION
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.sweeping.look import drift_of
from workbench.planning.collision.sweeping.scratch import place_joints, scratch_for

CORNERS = np.array(list(product((-1.0, 1.0), repeat=3)))


@pytest.fixture
def both(world):
    """Both arms on the move, their hands empty."""
    world.enter(LegPhase(frozenset({"left", "right"})))
    return world


def corners(g: int, common: int, scratch, half) -> np.ndarray:
    """Of a body's box (8, 3) [m], seen from the joint `common`."""
    points = scratch.c[g] + (CORNERS * half[g]) @ scratch.R[g].T
    return (points - scratch.p_j[common]) @ scratch.R_j[common]


@pytest.mark.parametrize("size", [0.02, 0.2, 0.8])
@pytest.mark.parametrize("bend", [0.0, 0.3])
def test_no_corner_comes_nearer_than_is_said(both, size, bend):
    columns = np.concatenate([both.kinematics.columns[arm] for arm in ("left", "right")])
    base, rng = both.configuration({}), np.random.default_rng(7)
    edges = both.edges(columns, base, RESOLUTION)
    model, groups, half = edges.model, edges.groups, edges.model.boxes.half
    shares = []
    for _ in range(12):
        middle = base.copy()
        middle[columns] += rng.uniform(-0.7, 0.7, len(columns))
        ahead, bent = rng.normal(0.0, size, (2, len(base))) * np.array([[1.0], [bend]])
        ahead[columns] *= rng.random(len(columns)) < 0.6
        # What moves and what stands are told apart: only the joints of the edges move.
        still = np.setdiff1d(np.arange(len(base)), columns)
        ahead[still] = bent[still] = 0.0
        now = scratch_for(columns, middle, model.tree, model.boxes, model.cores)
        now.ahead[:], now.bent[:], now.d[:] = ahead, np.abs(bent), np.abs(ahead) + np.abs(bent)
        place_joints(model.tree, now)
        # Of a scratch for no joints all bodies are placed.
        none = columns[:0]
        states = [
            (t, scratch_for(none, middle + t * ahead + t * t * bent, *model[:2], model.cores))
            for t in (0.0, -1.0, -0.6, 0.5, 1.0)
        ]
        for k in rng.choice(groups.pairs, 40):
            a, b, common = int(model.first[k]), int(model.second[k]), int(edges.commons[k])
            i, j = int(model.boxes.joint[a]), int(model.boxes.joint[b])
            rest, most = (m[i, common] + m[j, common] for m in (now.rest, now.most))
            start, n = states[0][1], rng.normal(size=3)
            n /= np.linalg.norm(n)
            drift = drift_of(a, b, i, j, common, False, False, rest, most, start.c, now.twist)
            said = nearing(drift, a, b, *n, start.R, half)
            direction = n @ start.R_j[common]
            ones, others = (
                np.array([corners(g, common, at, half) @ direction for _, at in states])
                for g in (a, b)
            )
            one, other = ones - ones[0], others - others[0]
            real = np.abs(one[:, :, None] - other[:, None, :]).max()
            assert real <= said + 1e-9
            if real > 1e-6:
                shares.append(real / said)
    assert len(shares) > 100
    if size == 0.02 and bend == 0.0:
        assert np.median(shares) > 0.5, "of a short way it is mostly known how far things come"
