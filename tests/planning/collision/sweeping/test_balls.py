"""Pairs of balls by their formula: the same distances and the same answers as by Coal."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from motion_stand_in import make_motion_problems

from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.cell import Policy
from workbench.model.geometry import Box, Cylinder, Sphere
from workbench.planning.collision.bodies import coal_shape, extent
from workbench.planning.collision.gjk import cores_of
from workbench.planning.collision.motion import chain_contact, segment
from workbench.planning.collision.sweeping.balls import ball_gap
from workbench.planning.collision.world import World
from workbench.studies.motion_cases import ARM, cases_of

SHAPES = (Sphere(0.12), Box(np.array([0.1, 0.3, 0.2])), Cylinder(0.1, 0.4))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape.kind)
def test_the_distance_of_a_ball_is_that_of_coal(shape):
    rng = np.random.default_rng(3)
    shapes = [Sphere(0.05), shape]
    cores = cores_of(shapes, np.zeros((2, 3)))
    half = np.array([extent(one)[1] for one in shapes])
    apart = 0
    for _ in range(500):
        R = np.array([pin.exp3(rng.uniform(-2, 2, 3)) for _ in shapes])
        c = rng.uniform(-0.15, 0.15, (2, 3))
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        first, second = (coal.Transform3s(R[k], c[k]) for k in (0, 1))
        coal.distance(coal_shape(shapes[0]), first, coal_shape(shape), second, request, result)
        gap = ball_gap(0, 1, R, c, half, cores)
        assert (gap <= 1e-6) == (result.min_distance <= 1e-6)
        if gap > 0:
            apart += 1
            assert gap == pytest.approx(result.min_distance, abs=1e-5)
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
