"""Which turns leave a shape as it is."""

import numpy as np
import pytest
import trimesh

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh
from workbench.model.part import Symmetry
from workbench.planning.grasps.part_symmetry import (
    deviation_of,
    proposed_symmetry,
    symmetries_of,
    turns_of,
)


def mesh_of(surface: trimesh.Trimesh) -> Mesh:
    return Mesh(surface.vertices, surface.faces)


SHAPES = {
    "cylinder": (trimesh.creation.cylinder(0.01, 0.03, sections=48), 0),
    "hexagon": (trimesh.creation.cylinder(0.01, 0.03, sections=6), 6),
    "box": (trimesh.creation.box((0.02, 0.03, 0.04)), 2),
    "square": (trimesh.creation.box((0.02, 0.02, 0.04)), 4),
}


@pytest.mark.parametrize("name", SHAPES)
def test_prisms_have_the_turns_of_their_outline(name):
    surface, fold = SHAPES[name]
    found = proposed_symmetry(mesh_of(surface))
    assert found is not None
    assert (found.symmetry.fold, found.symmetry.axis.tolist()) == (fold, [0, 0, 1])
    assert found.deviation < 1e-4


def test_the_shipped_parts():
    assert proposed_symmetry(read_part("keyed_cylinder").mesh) is None
    puck = proposed_symmetry(read_part("puck").mesh)
    assert puck is not None and puck.symmetry.fold == 0
    assert abs(puck.symmetry.axis[2]) == pytest.approx(1.0)


def test_an_axis_is_found_however_the_part_lies_in_its_frame():
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    for name in ("hexagon", "square"):
        surface, fold = SHAPES[name]
        found = proposed_symmetry(mesh_of(surface.copy().apply_transform(turn)))
        assert found is not None and found.symmetry.fold == fold
        assert abs(found.symmetry.axis @ turn[:3, 2]) == pytest.approx(1.0, abs=1e-3)


def test_a_line_that_passes_the_origin_is_told_but_not_proposed():
    surface = SHAPES["hexagon"][0].copy()
    surface.apply_translation([0.05, 0.0, 0.0])
    mesh = mesh_of(surface)
    first = symmetries_of(mesh)[0]
    assert first.symmetry.fold == 6
    assert first.off == pytest.approx(0.05)
    assert first.point == pytest.approx([0.05, 0, 0], abs=1e-6)
    through = proposed_symmetry(mesh)
    assert through is not None and abs(through.symmetry.axis[0]) == pytest.approx(1.0)


def test_a_small_pin_breaks_the_symmetry():
    pinned = trimesh.boolean.union(
        [
            SHAPES["cylinder"][0],
            trimesh.creation.box(
                (0.002, 0.002, 0.002),
                trimesh.transformations.translation_matrix([0.006, 0, 0.0155]),
            ),
        ]
    )
    assert proposed_symmetry(mesh_of(pinned)) is None


def test_what_an_author_states_is_measured():
    cylinder = read_part("keyed_cylinder").mesh
    assert deviation_of(cylinder, Symmetry(fold=1)) == 0.0
    assert deviation_of(cylinder, Symmetry(fold=2)) == pytest.approx(0.004, abs=5e-4), "the key"
    assert deviation_of(mesh_of(SHAPES["hexagon"][0]), Symmetry(fold=6)) < 1e-9


def test_turns_are_rotations_that_close():
    turns = turns_of(Symmetry(fold=5))
    assert len(turns) == 5
    assert np.allclose(turns[1] @ turns[4], np.eye(3))
    assert len(turns_of(Symmetry(fold=1))) == 1
