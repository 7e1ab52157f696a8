"""Pairs of balls by their formula: the same distances and the same answers as by Coal."""

from dataclasses import replace
from itertools import product

import coal
import numpy as np
import pinocchio as pin
import pytest
from motion_stand_in import make_motion_problems

from workbench.formats.meshes.reading import convex_hull
from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.cell import Fixture, Policy
from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Shape, Solid, Sphere
from workbench.planning.collision.bodies import coal_shape, extent
from workbench.planning.collision.distances.cores import cores_of
from workbench.planning.collision.motion import RESOLUTION, chain_contact, segment
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.sweeping.balls import ball_gap
from workbench.planning.collision.sweeping.edges import BLOCKED, CLEAR, edge_answer
from workbench.planning.collision.world import World
from workbench.studies.motion.problems import ARM, cases_of

JAW = 1.21
"""[m] Where the ball of the stand-in's jaw is along x when the arm lies straight."""

SHAPES = (Sphere(0.12), Box(np.array([0.1, 0.3, 0.2])), Cylinder(0.1, 0.4))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_the_distance_of_a_ball_is_that_of_coal(shape):
    rng = np.random.default_rng(3)
    shapes = [Sphere(0.05), shape]
    cores = cores_of(shapes, np.zeros((2, 3)))
    half = np.array([extent(one)[1] for one in shapes])
    apart, normal = 0, np.zeros(3)
    for _ in range(500):
        R = np.array([pin.exp3(rng.uniform(-2, 2, 3)) for _ in shapes])
        c = rng.uniform(-0.15, 0.15, (2, 3))
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        first, second = (coal.Transform3s(R[k], c[k]) for k in (0, 1))
        coal.distance(coal_shape(shapes[0]), first, coal_shape(shape), second, request, result)
        sizes = cores.form, cores.swell, cores.radius, cores.length
        gap = ball_gap(0, 1, R, c, half, *sizes, normal)
        assert (gap <= 1e-6) == (result.min_distance <= 1e-6)
        if gap > 0:
            apart += 1
            assert gap == pytest.approx(result.min_distance, abs=1e-5)
            if result.min_distance > 1e-3:
                assert np.abs(np.cross(normal, result.normal)).max() < 1e-2
    assert 50 < apart < 450, "one of the two was hardly looked at"


def test_edges_past_balls_are_judged_as_by_coal(tmp_path):
    make_motion_problems(tmp_path)
    policy = Policy(margin=0.0, near_margin=0.0, self_margin=0.0)
    case = next(
        one
        for one in cases_of(read_motion_problems(tmp_path), policy)
        if one.problem == "past the ball"
    )
    by_coal = World(case.world.cell, (), by_coal=True)
    columns, base = case.world.kinematics.columns[ARM], case.world.configuration({})
    rng = np.random.default_rng(5)
    clear = 0
    for _ in range(150):
        a, b = rng.uniform(-1.5, 1.5, (2, 3))
        answers = [
            chain_contact(world, columns, base, segment(a, b)) is None
            for world in (case.world, by_coal)
        ]
        assert answers[0] == answers[1]
        clear += answers[0]
    assert 10 < clear < 140, "one of the two answers hardly came"


def cube(size: float) -> Shape:
    corners = np.array(list(product((-size / 2, size / 2), repeat=3)))
    hull = convex_hull(Mesh(corners, np.empty((0, 3), np.int32)))
    assert hull is not None
    return hull


@pytest.mark.parametrize("shape", [Capsule(0.06, 0.2), cube(0.12)], ids=lambda one: one.kind)
@pytest.mark.parametrize(("away", "answer"), [(0.08, BLOCKED), (0.11, CLEAR)])
def test_a_ball_beside_what_it_has_no_formula_with_is_as_large_as_it_is(
    shape, away, answer, tmp_path
):
    """The jaw, a ball of 30 mm, beside something that reaches 60 mm towards it."""
    make_motion_problems(tmp_path)
    case = cases_of(read_motion_problems(tmp_path), Policy())[0]
    q = np.zeros(3)
    T_world_post = pin.SE3(np.eye(3), np.array([JAW + away, 0.0, 0.0]))
    post = Solid("post", shape, T_world_post)
    fixture = Fixture("post", pin.SE3.Identity(), (post,))
    policy = Policy(margin=0.005, near_margin=0.005, self_margin=0.0)
    world = World(replace(case.world.cell, fixtures=(fixture,), policy=policy), ())
    world.enter(LegPhase(frozenset({ARM})))
    columns, base = world.kinematics.columns[ARM], world.configuration({})
    there = np.array([1e-4, 0.0, 0.0])
    assert (world.contact(world.configuration({ARM: q})) is None) == (answer == CLEAR)
    assert (chain_contact(world, columns, base, segment(q, there)) is None) == (answer == CLEAR)
    assert edge_answer(q, there, world.edges(columns, base, RESOLUTION)) == answer
