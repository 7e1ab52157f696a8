"""The quickest order of two arms' legs, of those whose steps are possible."""

from dataclasses import replace
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.model.motion import LEG_NAMES
from workbench.model.plan import Leg, Strategy
from workbench.planning.collision.world import World
from workbench.planning.picking import weave
from workbench.planning.picking.weave import ALL_MOVES, COUNT, Move, Weave, interleave


@pytest.fixture(scope="module")
def in_turn(result):
    """Two arms, one after the other."""
    arms = result.plan.arms
    steps = [step for step in result.plan.sequence if len(step.runs) == 1]
    assert len(steps) < 2 * COUNT, "the second arm sets out as the first goes home"
    return replace(
        result.plan,
        sequence=tuple(
            replace(steps[0], runs=((arm.arm, name),)) for arm in arms for name in LEG_NAMES
        ),
    )


def with_seconds(arm, seconds):
    """An arm whose legs take these times."""
    legs = [
        Leg(leg.name, leg.motion, leg.holding, leg.opening, leg.q[:2], np.array([0.0, s]))
        for leg, s in zip(arm.legs, seconds, strict=True)
    ]
    return replace(arm, legs=tuple(legs))


def quickest_by_trying(times, possible) -> float:
    """The least time of all orders, each of them tried."""

    @lru_cache(None)
    def rest(a: int, b: int) -> float:
        if (a, b) == (COUNT, COUNT):
            return 0.0
        found = [np.inf]
        for move in possible:
            if move.done == (a, b):
                taken = max(times[k][move.done[k]] for k in (0, 1) if move.moves[k])
                found.append(taken + rest(*move.after))
        return min(found)

    return rest(0, 0)


SECONDS = st.lists(st.integers(1, 20), min_size=COUNT, max_size=COUNT)


@settings(max_examples=60, deadline=None)
@given(first=SECONDS, second=SECONDS, seed=st.integers(0, 999), share=st.floats(0.1, 1.0))
def test_of_all_possible_orders_the_quickest_comes_out(in_turn, first, second, seed, share):
    rng = np.random.default_rng(seed)
    possible = {move: bool(rng.random() < share) for move in ALL_MOVES}
    arms = tuple(
        with_seconds(arm, some) for arm, some in zip(in_turn.arms, (first, second), strict=True)
    )
    found = Weave(None, arms, dict(possible)).quickest(ALL_MOVES)
    able = frozenset(move for move, is_possible in possible.items() if is_possible)
    least = quickest_by_trying((first, second), able)
    if found is None:
        assert least == np.inf
        return
    assert all(possible[move] for move in found)
    assert [move.done for move in found[1:]] == [move.after for move in found[:-1]]
    assert found[0].done == (0, 0) and found[-1].after == (COUNT, COUNT)
    times = (first, second)
    taken = sum(max(times[k][m.done[k]] for k in (0, 1) if m.moves[k]) for m in found)
    assert taken == least


def test_only_the_steps_of_ways_that_would_be_quickest_are_looked_at(cell, in_turn, monkeypatch):
    looked: list[str] = []

    def never(world, pair):
        looked.append("both")
        return "they meet"

    monkeypatch.setattr(weave, "find_arm_contact", never)
    monkeypatch.setattr(weave, "passes", lambda world, moving, waiting, done: True)
    world = World(cell, in_turn.detections)
    assert interleave(world, in_turn, freely=False) == (in_turn,)
    assert looked == ["both"], "that of home and reach"
    assert interleave(world, in_turn, freely=True) == (in_turn,)
    assert len(looked) <= 1 + COUNT**2 + 1


def test_a_plan_is_left_out_whose_second_arm_meets_what_the_first_has_placed(
    cell, in_turn, monkeypatch
):
    def passes(world, moving, waiting, done):
        return not (moving.name == "approach" and done == COUNT)

    monkeypatch.setattr(weave, "find_arm_contact", lambda world, pair: "they meet")
    monkeypatch.setattr(weave, "passes", passes)
    world = World(cell, in_turn.detections)
    assert in_turn not in interleave(world, in_turn, freely=True)
    assert interleave(world, in_turn, freely=False) == (in_turn,)


def test_what_may_be_done_in_turns_is_one_arm_after_the_other(in_turn):
    allowed = [move for move in ALL_MOVES if move.is_sequential]
    assert len(allowed) == 2 * COUNT + 1
    assert [move for move in allowed if all(move.moves)] == [Move((COUNT - 1, 0), (True, True))]


@pytest.mark.parametrize("pairs", [(), ("a pair",)])
def test_where_grasps_go_by_pairs_the_second_arm_is_never_ahead(in_turn, monkeypatch, pairs):
    """A pair says which of its grasps goes first.  Here it is quicker when the second arm begins:
    its first legs can run with none of the other's."""
    monkeypatch.setattr(
        weave, "find_arm_contact", lambda world, pair: "they meet" if ahead(pair) else None
    )
    monkeypatch.setattr(weave, "passes", lambda world, moving, waiting, done: True)

    def ahead(pair) -> bool:
        first, second = (LEG_NAMES.index(task.name) for task in pair)
        return second <= first

    library = SimpleNamespace(pairs=pairs)
    world = SimpleNamespace(cell=SimpleNamespace(parts=[SimpleNamespace(library=library)]))
    found = interleave(world, in_turn, freely=True)[0]
    done = {arm.arm: 0 for arm in in_turn.arms}
    first, second = done
    is_ahead = False
    for step in found.sequence:
        for arm, _ in step.runs:
            done[arm] += 1
        is_ahead |= done[second] > done[first]
    assert is_ahead is not bool(pairs)


def test_a_plan_with_legs_at_once_says_that_it_is_coordinated(cell, in_turn, monkeypatch):
    monkeypatch.setattr(weave, "find_arm_contact", lambda world, pair: None)
    quickest, in_turns, last = interleave(World(cell, in_turn.detections), in_turn, freely=True)
    assert quickest.strategy is Strategy.COORDINATED and len(quickest.sequence) == COUNT
    assert in_turns.strategy is Strategy.ALTERNATED
    assert in_turns.cycle_seconds > quickest.cycle_seconds
    assert last is in_turn
