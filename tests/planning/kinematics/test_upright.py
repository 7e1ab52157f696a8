"""Whether a motion keeps a part upright is known for all of it; projections do."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.formats.cells.reading import read_cell
from workbench.model.derived.upright import tilt_from_vertical
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.upright import NOT_HALVED_BELOW, UprightLimit, Uprightness


@pytest.fixture(scope="module")
def chain():
    cell = read_cell("yumi")
    return chain_of(cell, cell.arm("left"))


def tilt(limit: UprightLimit, q) -> float:
    return tilt_from_vertical(limit.chain.pose(q).rotation @ limit.axis)


def limit_at(chain, q, most: float) -> UprightLimit:
    """With an axis in the hand that is vertical at a configuration."""
    return UprightLimit(chain, chain.pose(q).rotation.T @ np.array([0.0, 0.0, 1.0]), most)


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_curves_are_upright_where_all_that_is_between_is(chain, seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(chain.lower, chain.upper)
    corners = q + rng.normal(0, 0.15, (3, len(q)))
    shares = rng.dirichlet(np.ones(3), 400)
    tilts = [tilt(limit_at(chain, q, 1.0), share @ corners) for share in [*np.eye(3), *shares]]
    for most in rng.uniform(0.5, 1.5, 4) * max(tilts):
        keeps = Uprightness([limit_at(chain, q, most)], [len(q)])
        tilted = keeps.find_tilted(corners[None])
        if tilted is None:
            assert max(tilts) <= most + NOT_HALVED_BELOW
        elif most > 1.2 * max(tilts) + NOT_HALVED_BELOW:
            pytest.fail("refused, though nothing is tilted so far")


def test_what_is_no_number_is_not_upright(chain):
    q = (chain.lower + chain.upper) / 2
    keeps = Uprightness([limit_at(chain, q, 0.3)], [len(q)])
    assert keeps.find_tilted(np.array([[q, q, q]])) is None
    assert keeps.find_tilted(np.array([[q, q, np.full(len(q), np.nan)]])) is not None


def test_of_two_arms_each_keeps_its_own_part_upright(chain):
    q = (chain.lower + chain.upper) / 2
    away = q.copy()
    away[3] += 0.4
    first, second = limit_at(chain, q, 0.2), limit_at(chain, q, 0.2)
    both, one = Uprightness([first, second], [7, 7]), Uprightness([None, second], [7, 7])

    def straight(start, end):
        return np.array([[start, (start + end) / 2, end]])

    moved = straight(np.hstack([q, q]), np.hstack([away, q]))
    assert both.find_tilted(moved) is not None and one.find_tilted(moved) is None


@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_a_projection_is_upright_within_the_limits_and_near(chain, seed):
    rng = np.random.default_rng(seed)
    q = rng.uniform(0.8 * chain.lower, 0.8 * chain.upper)
    limit = limit_at(chain, q, np.deg2rad(10.0))
    near = np.clip(q + rng.normal(0, 0.2, len(q)), chain.lower, chain.upper)
    found = limit.project(near)
    assert found is not None and tilt(limit, found) <= limit.most + 1e-12
    assert (found >= chain.lower).all() and (found <= chain.upper).all()
    if tilt(limit, near) <= limit.most:
        np.testing.assert_array_equal(found, near)


def test_an_axis_may_hang_upside_down_and_is_turned_back(chain):
    q = (chain.lower + chain.upper) / 2
    up = chain.pose(q).rotation.T @ pin.exp3(np.array([2.9, 0.0, 0.0])) @ np.array([0.0, 0.0, 1.0])
    limit = UprightLimit(chain, up, 0.3)
    found = limit.project(q)
    assert found is None or tilt(limit, found) <= 0.3
