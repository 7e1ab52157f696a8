"""How far the meshes of a robot are split, by how many there are."""

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.meshes.pieces.convex_pieces import OVER, Pieces
from workbench.formats.robots import urdf_package
from workbench.formats.robots.urdf_package import MOST_SPLIT, simplify_robot
from workbench.model.geometry import Mesh, Solid
from workbench.model.robot import Link, Robot

CORNERS = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


def robot_of(count: int) -> Robot:
    """A robot of so many links, each with a mesh of its own."""
    solids = [
        Solid(f"s{number}", Mesh(CORNERS * (1 + number), FACES), pin.SE3.Identity())
        for number in range(count)
    ]
    return Robot("many", tuple(Link(solid.name, (solid,), ()) for solid in solids), ())


@pytest.mark.parametrize("count", [1, 8, 18, 40, 70, 2 * MOST_SPLIT])
def test_the_work_for_a_robot_is_bounded_however_many_meshes_it_has(count, monkeypatch):
    asked: list[tuple[int, float]] = []

    def pieces_of(mesh: Mesh, *, tolerance: float, most: int, over: float) -> Pieces:
        asked.append((most, over))
        return Pieces((mesh,), 0.0)

    monkeypatch.setattr(urdf_package, "pieces_of", pieces_of)
    found, _ = simplify_robot(robot_of(count), tolerance=0.005, most=32)
    assert len(asked) == len(found.links) == count
    assert len(set(asked)) == 1
    most, over = asked[0]
    assert 1 <= most <= 32 and 1 <= over <= OVER
    assert count * most * over <= max(MOST_SPLIT, count)
    assert count > 8 or (most, over) == (32, OVER)
