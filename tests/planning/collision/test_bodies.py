"""Shapes as Coal takes them."""

import subprocess
import sys

import pytest

ASK = """
import sys
import coal, numpy as np
import workbench.planning.collision.bodies

R = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
level = coal.Transform3s.Identity()

def distance(first, second, x):
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    at = coal.Transform3s(R, np.array([x, 0.02, 0.03]))
    return coal.distance(first, at, second, level, request, result)

shapes = {"box": coal.Box(np.full(3, 0.1)), "capsule": coal.Capsule(0.02, 0.05)}
for name in sys.argv[1:]:
    distance(shapes[name], shapes["box"], 0.01)
one, other = coal.Box(np.array([0.02, 0.03, 0.05])), coal.Box(np.array([0.2, 0.2, 0.01]))
print([distance(one, other, 0.01 * k) for k in range(20)])
"""


@pytest.fixture(scope="module")
def distances():
    def after(*first: str) -> str:
        command = [sys.executable, "-c", ASK, *first]
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout

    return after


@pytest.mark.extensive
def test_what_was_asked_first_does_not_change_the_distances_of_boxes(distances):
    """Coal 3 lets the first query of a process decide how large boxes are, by 1e-10."""
    assert distances("box") == distances("capsule") == distances()
