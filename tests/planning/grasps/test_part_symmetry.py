"""Which turns leave a shape as it is."""

import numpy as np
import open3d as o3d
import pytest
import trimesh

from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.part_symmetry import (
    deviation_of,
    proposed_symmetry,
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


def test_an_exact_fold_beats_a_larger_one_within_the_tolerance():
    """The socket of a screw is small: turns by a seventh move its walls by 0.1 mm."""
    angles = np.arange(42) * 2 * np.pi / 42
    outer = 0.0045 * np.c_[np.cos(angles), np.sin(angles)]
    sextant = (angles + np.pi / 6) % (np.pi / 3) - np.pi / 6
    radii = 0.00125 / np.cos(sextant)
    inner = radii[:, None] * np.c_[np.cos(angles), np.sin(angles)]
    rings = [np.c_[ring, np.full(42, z)] for ring, z in
             ((outer, 0), (outer, 0.03), (inner, 0.03), (inner, 0.025))]  # fmt: skip
    faces = []
    for row in range(3):
        for k in range(42):
            n = (k + 1) % 42
            a, b, c, d = (42 * row + k, 42 * row + n, 42 * row + 42 + k, 42 * row + 42 + n)
            faces += [(a, b, d), (a, d, c)]
    faces += [(0, k + 1, k) for k in range(1, 41)]
    faces += [(126, 126 + k, 127 + k) for k in range(1, 41)]
    surface = trimesh.Trimesh(np.vstack(rings), faces)
    assert surface.is_volume
    found = proposed_symmetry(mesh_of(surface))
    assert found is not None
    assert found.symmetry.fold == 6 and found.deviation < 1e-5


@pytest.mark.parametrize("name", ["keyed_cylinder", "bracket", "bolt", "puck"])
def test_shipped_parts_state_every_turn_that_their_surface_has(name):
    part, full = read_part(name), read_part(str(find("parts", name) / "full_bin"))
    found = proposed_symmetry(part.mesh)
    known = "none" if found is None else str(found.symmetry)
    assert str(part.symmetry) == str(full.symmetry) == known
    if found is not None:
        assert abs(found.symmetry.axis @ part.symmetry.axis) == pytest.approx(1.0)
        assert deviation_of(part.mesh, part.symmetry) < 1e-4


def test_an_axis_is_found_however_the_part_lies_in_its_frame():
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    for name in ("hexagon", "square"):
        surface, fold = SHAPES[name]
        found = proposed_symmetry(mesh_of(surface.copy().apply_transform(turn)))
        assert found is not None and found.symmetry.fold == fold
        assert abs(found.symmetry.axis @ turn[:3, 2]) == pytest.approx(1.0, abs=1e-3)


def test_an_axis_beside_the_origin_is_found_where_it_is():
    surface = SHAPES["hexagon"][0].copy()
    surface.apply_translation([0.05, 0.0, 0.0])
    found = proposed_symmetry(mesh_of(surface))
    assert found is not None and str(found.symmetry) == "D6"
    assert found.symmetry.point == pytest.approx((0.05, 0, 0), abs=1e-6)


def tube() -> trimesh.Trimesh:
    return trimesh.creation.annulus(0.008, 0.01, 0.06, sections=64)


def cross() -> trimesh.Trimesh:
    bars = [trimesh.creation.cylinder(0.006, 0.06, sections=40) for _ in range(2)]
    bars[0].apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [1, 0, 0]))
    bars[1].apply_transform(trimesh.transformations.rotation_matrix(np.pi / 2, [0, 1, 0]))
    return trimesh.boolean.union(bars)


def elbow() -> trimesh.Trimesh:
    legs = [
        trimesh.creation.cylinder(0.006, segment=[[0, 0, 0], end], sections=40)
        for end in ([0.04, 0, 0], [0, 0.04, 0])
    ]
    return trimesh.boolean.union([*legs, trimesh.creation.icosphere(3, 0.007)])


def hub() -> trimesh.Trimesh:
    """Three round arms: the half turns across are along no face's normal but those of the ends."""
    arms = [
        trimesh.creation.cylinder(
            0.004, segment=[[0, 0, 0], [0.03 * np.cos(a), 0.03 * np.sin(a), 0]], sections=36
        )
        for a in (0.2, 0.2 + 2 * np.pi / 3, 0.2 + 4 * np.pi / 3)
    ]
    return trimesh.boolean.union([*arms, trimesh.creation.cylinder(0.01, 0.01, sections=90)])


GROUPS = {
    "tube": (tube, "D-inf"),
    "cross": (cross, "D4"),
    "elbow": (elbow, "C2"),
    "sphere": (lambda: trimesh.creation.icosphere(4, 0.02), "sphere"),
    "cube": (lambda: trimesh.creation.box((0.03, 0.03, 0.03)), "24 turns"),
    "hub": (hub, "D3"),
    "cone": (lambda: trimesh.creation.cone(0.01, 0.03, sections=64), "C-inf"),
}


@pytest.mark.parametrize("name", GROUPS)
def test_groups_are_found_wherever_the_part_lies_in_its_frame(name):
    make, group = GROUPS[name]
    surface = make()
    turn = trimesh.transformations.rotation_matrix(0.7, [1, 2, 3])
    turn[:3, 3] = 0.03, -0.02, 0.05
    found = proposed_symmetry(mesh_of(surface.apply_transform(turn)))
    assert found is not None and str(found.symmetry) == group
    found.symmetry.check()
    # Judged by Open3D: corners of the turned surface lie on the surface.
    scene = o3d.t.geometry.RaycastingScene()
    corners = surface.vertices.astype(np.float32)
    scene.add_triangles(corners, surface.faces.astype(np.uint32))
    for M in found.symmetry.motions(5):
        moved = corners @ M[:3, :3].T + M[:3, 3]
        off = scene.compute_distance(o3d.core.Tensor(moved.astype(np.float32))).numpy()
        assert off.max() < 5e-3 * surface.scale


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
