"""Edges checked by compiled code, beside many states along them that Coal measures one by one."""

import numpy as np
import pytest
from motion_stand_in import make_motion_problems

from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.cell import Policy
from workbench.planning.collision.motion import RESOLUTION
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.sweeping.edges import ASK, BLOCKED, CLEAR, edge_answer, no_edges
from workbench.planning.collision.sweeping.groups import groups_of, move_to_front
from workbench.planning.collision.world import World
from workbench.studies.motion.problems import ARM, cases_of

STATES = 120
"""Looked at along an edge."""


def worlds(cell, kind: str, tmp_path) -> tuple[World, World, str]:
    """A world, the same one by Coal, and the arm that moves in it."""
    if kind == "balls":
        make_motion_problems(tmp_path)
        policy = Policy(margin=0.0, near_margin=0.0, self_margin=0.0)
        cases = cases_of(read_motion_problems(tmp_path), policy)
        case = next(one for one in cases if one.problem == "past the ball")
        return case.world, World(case.world.cell, (), by_coal=True), ARM
    both = World(cell, ()), World(cell, (), by_coal=True)
    name = cell.arms[0].name
    for world in both:
        world.enter(LegPhase(frozenset({name}), {name: 0.01}))
    return *both, name


@pytest.mark.parametrize("kind", ["arms and a bin", "balls"])
def test_an_edge_is_clear_where_all_states_on_it_are(cell, kind, tmp_path):
    world, by_coal, arm = worlds(cell, kind, tmp_path)
    columns, base = world.kinematics.columns[arm], world.configuration({})
    chain, edges = world.chains[arm], world.edges(columns, base, RESOLUTION)
    rng = np.random.default_rng(11)
    answers = {BLOCKED: 0, CLEAR: 0}
    for _ in range(150):
        a = rng.uniform(chain.lower, chain.upper)
        b = np.clip(a + rng.uniform(-0.6, 0.6, len(a)), chain.lower, chain.upper)
        answer = edge_answer(a, b, edges)
        answers[answer] += 1
        shares = np.linspace(0, 1, STATES)
        rooms = [
            by_coal.worst(by_coal.configuration({arm: a + s * (b - a)}), 0.01)[1] for s in shares
        ]
        if answer == CLEAR:
            assert min(rooms) > -RESOLUTION
        else:
            # Between two of these states no body moves far.
            assert min(rooms) < 0.01
    assert min(answers.values()) > 10, "one of the two answers hardly came"


def test_what_was_looked_at_before_changes_no_answer(cell):
    world = World(cell, ())
    arm = cell.arms[0].name
    columns, base = world.kinematics.columns[arm], world.configuration({})
    rng, chain = np.random.default_rng(4), world.chains[arm]
    edges = [rng.uniform(chain.lower, chain.upper, (2, len(columns))) for _ in range(60)]
    used = world.edges(columns, base, RESOLUTION)
    in_turn = [edge_answer(a, b, used) for a, b in edges]
    again = [edge_answer(a, b, used) for a, b in reversed(edges)][::-1]
    alone = [edge_answer(a, b, world.edges(columns, base, RESOLUTION)) for a, b in edges]
    assert in_turn == again == alone


def test_compiled_code_that_knows_nothing_asks():
    q = np.zeros(6)
    assert edge_answer(q, q, no_edges(6)) == ASK


def test_every_pair_is_in_one_group_and_the_last_contact_comes_first():
    rng = np.random.default_rng(2)
    joint = rng.integers(0, 5, 30)
    first, second = np.triu_indices(30, 1)
    among = np.flatnonzero((joint[first] != joint[second]) & (rng.random(len(first)) < 0.7))
    margins = rng.uniform(0, 0.01, len(first))
    groups = groups_of(among, margins, first, second, joint)
    assert sorted(groups.pairs) == sorted(among)

    def members(g: int) -> np.ndarray:
        return groups.pairs[groups.begins[g] : groups.begins[g + 1]]

    def unit(body: int) -> tuple[str, int]:
        return ("body", body) if joint[body] == 0 else ("joint", int(joint[body]))

    seen = set()
    for g in range(len(groups.margins)):
        units = {(unit(first[k]), unit(second[k])) for k in members(g)}
        assert len(units) == 1 and not units & seen
        seen |= units
        assert groups.margins[g] == margins[members(g)].max()
    for pair in rng.choice(among, 20):
        move_to_front(pair, groups)
        assert groups.pairs[groups.begins[groups.order[0]]] == pair
        assert sorted(groups.order) == list(range(len(groups.margins)))
    assert sorted(groups.pairs) == sorted(among)
