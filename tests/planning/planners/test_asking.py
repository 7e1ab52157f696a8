"""Compiled planners and whom they ask: the same way, whoever checks the edges."""

import itertools

import numpy as np
import pytest
from motion_stand_in import make_motion_problems

from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.cell import Policy
from workbench.model.geometry import Floats
from workbench.planning.collision.motion import RESOLUTION, chain_contact, segment
from workbench.planning.picking.search import edge_check, joint_weights
from workbench.planning.planners.asking import CompiledCheck, edges_in
from workbench.planning.planners.rrt import rrt_connect
from workbench.planning.planners.shorten import shorten_path
from workbench.planning.planners.trees import (
    EDGES_A_TURN,
    EXHAUSTED,
    OPEN,
    PAUSED,
    grow_trees,
    plant_trees,
)
from workbench.studies.motion.problems import ARM, Case, cases_of


@pytest.fixture(scope="module")
def case(tmp_path_factory) -> Case:
    folder = tmp_path_factory.mktemp("problems")
    make_motion_problems(folder)
    policy = Policy(margin=0.0, near_margin=0.0, self_margin=0.0)
    cases = cases_of(read_motion_problems(folder), policy)
    return next(one for one in cases if one.problem == "past the ball")


def checks(case: Case) -> dict[str, CompiledCheck]:
    """The same check of edges: by compiled code alone, by it and others, and without it."""
    world, columns = case.world, case.world.kinematics.columns[ARM]
    base = world.configuration({})

    def check(curves):
        found = chain_contact(world, columns, base, curves)
        return None if found is None else found[:2]

    edges = world.edges(columns, base, RESOLUTION)
    some = edges._replace(is_all=False)
    kinds = {"compiled": edges, "some": some, "none": None}
    return {name: edge_check(check, edges=one) for name, one in kinds.items()}


def search(case: Case, check: CompiledCheck, seed: int) -> Floats | None:
    chain, weights = case.world.chains[ARM], joint_weights(len(case.goal), case.world.policy)
    rng = np.random.default_rng(seed)
    return rrt_connect(
        case.start, case.goal, chain.lower, chain.upper, weights, check, iterations=2000, rng=rng
    ).path


@pytest.mark.parametrize("seed", range(6))
def test_the_way_is_the_same_whoever_checks_its_edges(case, seed):
    paths = [search(case, check, seed) for check in checks(case).values()]
    assert paths[0] is not None and len(paths[0]) > 2
    assert all(np.array_equal(path, paths[0]) for path in paths[1:])
    world, columns = case.world, case.world.kinematics.columns[ARM]
    for a, b in itertools.pairwise(paths[0]):
        assert chain_contact(world, columns, world.configuration({}), segment(a, b)) is None
    short = [shorten_path(paths[0], check, most=10) for check in checks(case).values()]
    assert all(np.array_equal(path, short[0]) for path in short[1:])


def test_growing_looks_at_the_clock_and_can_be_ended_there(case):
    chain, weights = case.world.chains[ARM], joint_weights(len(case.goal), case.world.policy)
    edges = edges_in(checks(case)["compiled"], len(case.goal))
    # A goal within the ball is searched for until something ends it.
    world, rng = case.world, np.random.default_rng(0)
    draws = (rng.uniform(chain.lower, chain.upper) for _ in range(10_000))
    goal = next(q for q in draws if world.contact(world.configuration({ARM: q})))
    trees, box = plant_trees(case.start, goal), np.array([chain.lower, chain.upper, weights])
    assert grow_trees(trees, box, 10**6, rng, edges, OPEN) == PAUSED
    assert trees.counts.sum() <= EDGES_A_TURN + 2
    assert grow_trees(trees, box, int(trees.at[1]), rng, edges, OPEN) == EXHAUSTED


def test_what_the_clock_raises_ends_a_compiled_search(case):
    def over() -> None:
        raise TimeoutError

    check = checks(case)["compiled"]
    ending = CompiledCheck(lambda a, b: False, over, check.edges)
    with pytest.raises(TimeoutError):
        shorten_path(np.array([case.start, case.goal]), ending, most=5)
