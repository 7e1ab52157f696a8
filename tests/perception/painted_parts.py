"""Parts with paint, drawn for tests: rods of two halves, and cubes with one marked face."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import trimesh

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, Solid
from workbench.model.part import GraspLibrary, Part
from workbench.model.symmetry import Symmetry, SymmetryAxis

X = np.array([1.0, 0.0, 0.0])
GREY, RED, BLUE, GREEN = (150, 150, 155), (190, 40, 40), (40, 60, 180), (40, 150, 60)
WHITE, BLACK = (225, 225, 225), (30, 30, 30)


def _kind(name: str, mesh: trimesh.Trimesh, colours, symmetry: Symmetry) -> Part:
    surface = Mesh(mesh.vertices, mesh.faces)
    return replace(
        read_part("bracket"),
        name=name,
        mesh=surface,
        pieces=(Solid("piece", Mesh(mesh.vertices, mesh.faces), pin.SE3.Identity()),),
        symmetry=symmetry,
        library=GraspLibrary(),
        colours=colours,
    )


def rod(upper, lower, name: str = "rod") -> Part:
    """A cylinder, of one colour from its middle upwards, and of another one below."""
    halves = []
    for side in (1, -1):
        half = trimesh.creation.cylinder(0.015, 0.025, sections=48)
        half.apply_translation([0, 0, side * 0.0125])
        # Without the discs in the middle, which are inside.
        half.update_faces(np.abs(half.triangles_center[:, 2]) > 1e-6)
        halves.append(half)
    mesh = trimesh.util.concatenate(halves)
    colours = np.where(mesh.triangles_center[:, 2:] > 0, upper, lower)
    return _kind(name, mesh, colours, Symmetry(fold=0, also=(SymmetryAxis(X, 2),)))


def cube(mark, *, is_stated: bool = True) -> Part:
    """A cube whose face towards z has another colour, and the group of turns of its shape."""
    mesh = trimesh.creation.box((0.035,) * 3)
    colours = np.where(mesh.face_normals[:, 2:] > 0.9, mark, GREY)
    turns = Symmetry(fold=4, also=(SymmetryAxis(X, 4),)) if is_stated else Symmetry()
    return _kind("cube", mesh, colours, turns)
