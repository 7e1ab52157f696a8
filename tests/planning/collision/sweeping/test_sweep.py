"""A chain of curves, looked at by compiled code."""

from itertools import islice

import numpy as np
import pytest

from workbench.planning.collision.motion import RESOLUTION, bound_curves
from workbench.planning.collision.pairing import LegPhase

ARM = "right"


@pytest.fixture
def moving(world):
    """The world with one arm on the move, its hand empty."""
    world.enter(LegPhase(frozenset({ARM})))
    return world


def chain_along(world, q, heading, rng) -> np.ndarray:
    """The curves of a short way from a configuration on, its corners all but straight."""
    moves = heading + rng.normal(0.0, np.abs(heading).max() / 20, (4, len(q)))
    path = np.cumsum([q, *moves], axis=0)
    return bound_curves(path, world.motion, world.policy.zone).points


def edges_of_contact(world, rng):
    """Clear configurations that are less than a milliradian from a contact, and where that is."""
    chain = world.chains[ARM]
    while True:
        a, b = rng.uniform(chain.lower, chain.upper, (2, len(chain.lower)))
        blocked = [world.contact(world.configuration({ARM: q})) is not None for q in (a, b)]
        if blocked[0] or not blocked[1]:
            continue
        while np.abs(b - a).max() > 1e-3:
            middle = (a + b) / 2
            if world.contact(world.configuration({ARM: middle})) is None:
                a = middle
            else:
                b = middle
        yield a, (b - a) / np.linalg.norm(b - a)


@pytest.mark.parametrize("step", [0.003, 0.05])
def test_a_chain_is_clear_as_far_as_its_curves_are_one_by_one(moving, step):
    """Also where many curves are looked at together."""
    columns, base = moving.kinematics.columns[ARM], moving.configuration({})
    rng, ends = np.random.default_rng(3), []
    for q, heading in islice(edges_of_contact(moving, rng), 60):
        way = heading * step + rng.normal(0.0, step / 3, len(q))
        points = chain_along(moving, q - 2 * way, way, rng)
        whole = moving.sweep(points, columns, base, RESOLUTION, None)
        each = (moving.sweep(one[None], columns, base, RESOLUTION, None) for one in points)
        number, first = next(
            ((k, one) for k, one in enumerate(each) if one.clear == 0), (len(points), None)
        )
        assert whole.clear == number
        if first is not None:
            assert whole.met is not None and first.met is not None
            assert np.array_equal(whole.met[1], first.met[1])
            assert whole.met[0].pair == first.met[0].pair
        ends.append(0 if number == 0 else 1 if number < len(points) else 2)
    assert ends.count(1) > 20, "most are met on the way"


def test_where_nothing_is_near_there_are_fewer_looks_than_curves(moving):
    columns, base = moving.kinematics.columns[ARM], moving.configuration({})
    home, rng = np.asarray(moving.arm(ARM).home), np.random.default_rng(0)
    points = chain_along(moving, home, np.full(len(home), 0.02), rng)
    before = moving.checks
    assert moving.sweep(points, columns, base, RESOLUTION, None).clear == len(points)
    assert moving.checks - before < len(points) * 2 / 3
