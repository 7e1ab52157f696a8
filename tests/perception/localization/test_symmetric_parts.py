"""Parts that look alike after turns: each is found once, and rightly under its group."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from drawn_shapes import spring as wound_wire
from searching import localize

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, Solid
from workbench.model.scan import ALL_KINDS
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.matching.pose_error import pose_error
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize

X, Y, Z = np.eye(3)


def sphere() -> tuple[list[trimesh.Trimesh], Symmetry]:
    return [trimesh.creation.icosphere(3, 0.02)], Symmetry(fold=0, also=(SymmetryAxis(X, 0),))


def rod() -> tuple[list[trimesh.Trimesh], Symmetry]:
    body = trimesh.creation.cylinder(0.01, 0.06, sections=48)
    body.apply_translation([0, 0, 0.03])
    return [body], Symmetry(fold=0, point=(0, 0, 0.03), also=(SymmetryAxis(X, 2),))


def cross() -> tuple[list[trimesh.Trimesh], Symmetry]:
    bars = [trimesh.creation.box(sides) for sides in ((0.06, 0.014, 0.014), (0.014, 0.06, 0.014))]
    return bars, Symmetry(fold=4, also=(SymmetryAxis(X, 2),))


def elbow() -> tuple[list[trimesh.Trimesh], Symmetry]:
    legs = [trimesh.creation.box(sides) for sides in ((0.06, 0.014, 0.02), (0.014, 0.06, 0.02))]
    for leg, middle in zip(legs, ([0.05, 0.027, 0.01], [0.027, 0.05, 0.01]), strict=True):
        leg.apply_translation(middle)
    return legs, Symmetry(np.array([1.0, 1.0, 0.0]) / np.sqrt(2), 2, (0.02, 0.02, 0.01))


def spring() -> tuple[list[trimesh.Trimesh], Symmetry]:
    """A screw about its axis moves all of it but its ends onto itself."""
    return [wound_wire()], Symmetry(X, 2, (0, 0, 0.02))


@pytest.mark.extensive
@pytest.mark.parametrize(
    "make", [sphere, rod, cross, elbow, spring], ids=lambda make: make.__name__
)
def test_each_is_found_once_and_rightly(make):
    bodies, symmetry = make()
    whole = bodies[0] if len(bodies) == 1 else trimesh.boolean.union(bodies)
    pieces = tuple(
        Solid(f"piece_{k}", Mesh(one.vertices, one.faces), pin.SE3.Identity())
        for k, one in enumerate(bodies)
    )
    kind = replace(
        read_part("bracket"),
        mesh=Mesh(whole.vertices, whole.faces),
        pieces=pieces,
        symmetry=symmetry,
    )
    cell = replace(read_cell("yumi"), parts=(kind,))
    truth = pile_of(cell, ALL_KINDS, 3, seed=5)
    found = localize(synthesize(cell, truth, seed=5), kind, cell, seed=0)
    assert len(found) == len(truth)
    left = list(truth)
    for one in found:
        errors = [pose_error(kind, other.T_world_part, one.T_world_part) for other in left]
        best = min(range(len(left)), key=lambda k: errors[k])
        assert errors[best][0] < 0.002 and errors[best][1] < np.deg2rad(3.0)
        left.pop(best)
