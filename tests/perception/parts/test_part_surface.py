"""What the localizer prepares of a part: few references where it is symmetric, few triangles."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import open3d as o3d
import pinocchio as pin
import pytest
import trimesh
from drawn_shapes import cross, cup, hex_nut, rod
from searching import localize

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, Solid, pose_from_rpy
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.matching.poses import distinct
from workbench.perception.parts import part_surface
from workbench.perception.parts.part_surface import (
    DRAWN_OFF,
    ROUGH_OFF,
    VOTING,
    prepare,
    resize_surface,
)
from workbench.perception.parts.point_pairs import make_table, vote
from workbench.perception.parts.sizing import grown, sized
from workbench.perception.simulation.synthesize import synthesize

X, Y, Z = np.eye(3)
ROUND = {
    "rod": (rod(), Symmetry(fold=0, also=(SymmetryAxis(X, 2),))),
    "nut": (hex_nut(), Symmetry(fold=6, also=(SymmetryAxis(X, 2),))),
    "cross": (cross(), Symmetry(fold=4, also=(SymmetryAxis(X, 2),))),
}


def kind(mesh: trimesh.Trimesh, symmetry: Symmetry):
    shape = Mesh(mesh.vertices, mesh.faces)
    pieces = (Solid("piece", shape, pin.SE3.Identity()),)
    return replace(read_part("bracket"), mesh=shape, pieces=pieces, symmetry=symmetry)


@pytest.mark.parametrize("name", ROUND)
def test_every_point_of_the_model_is_a_reference_after_a_turn_that_changes_nothing(name):
    mesh, symmetry = ROUND[name]
    surface = prepare(kind(mesh, symmetry))
    model, references = surface.table.model, surface.table.references
    assert len(references) < len(model) / 4
    turns = symmetry.motions(360)
    for p, n in zip(model.points, model.normals, strict=True):
        images, normals = turns[:, :3, :3] @ p + turns[:, :3, 3], turns[:, :3, :3] @ n
        far = np.linalg.norm(images[:, None] - references.points, axis=2)
        far[normals @ references.normals.T < 0.9] = np.inf
        assert far.min() < VOTING * surface.diameter


@pytest.mark.parametrize("name", ROUND)
def test_points_that_are_left_out_vote_for_no_other_poses(name):
    """Whatever all pairs vote for is voted for by the few, as good as the part can tell."""
    surface = prepare(kind(*ROUND[name]))
    table, T = surface.table, pose_from_rpy((0.1, -0.2, 0.7), (0.3, -0.8, 1.9)).homogeneous
    scene = replace(
        table.model,
        points=table.model.points @ T[:3, :3].T + T[:3, 3],
        normals=table.model.normals @ T[:3, :3].T,
    )
    every = make_table(table.model, table.model, table.diameter)
    asked = np.arange(0, len(scene), 7)
    for each in (every, table):
        poses, votes = vote(each, scene, asked, 1)
        both = np.concatenate([T[None], poses[np.argsort(-votes)]])
        others = distinct(
            both,
            np.arange(len(both)),
            surface.stated,
            surface.fixed,
            distance=0.1 * surface.diameter,
            angle=0.3,
            most=len(both),
        )
        # Most are the pose; a point in the middle of a plane does not know where it is.
        assert len(poses) - (len(others) - 1) > 0.4 * len(poses)


@pytest.mark.extensive
def test_a_fine_mesh_is_drawn_with_few_triangles_that_lie_on_it():
    coarse = prepare(read_part("bracket"))
    mesh = trimesh.Trimesh(coarse.vertices, coarse.triangles)
    v, f = trimesh.remesh.subdivide_to_size(mesh.vertices, mesh.faces, max_edge=0.002)
    fine = prepare(kind(trimesh.Trimesh(v, f), Symmetry()))
    assert len(f) > 10_000 and len(fine.triangles) <= 500
    points, _ = trimesh.sample.sample_surface(mesh, 300, seed=1)
    corners = np.array(fine.vertices)[fine.triangles]
    for point in points:
        nearest = trimesh.triangles.closest_point(corners, np.tile(point, (len(corners), 1)))
        assert np.linalg.norm(nearest - point, axis=1).min() < DRAWN_OFF * fine.diameter


def test_a_few_triangles_are_drawn_as_they_are():
    part = read_part("keyed_cylinder")
    assert len(prepare(part).triangles) == len(part.mesh.triangles)


@pytest.mark.parametrize(
    ("rpy", "least", "most"),
    [((np.pi / 2, 0, 0.4), 0.3, 0.7), ((0, 0, 0), 0.9, 1.0), ((np.pi, 0, 0), 0.9, 1.0)],
    ids=["lying", "open above", "closed above"],
)
def test_a_cup_that_lies_has_about_half_the_chance_to_be_the_right_way_round(rpy, least, most):
    cell = replace(read_cell("yumi"), parts=(kind(cup(), Symmetry(fold=0)),))
    height = 0.0225 if least < 0.5 else 0.0205
    T = cell.bin.T_world_bin * pose_from_rpy((0.02, 0.01, height), rpy)
    scan = synthesize(cell, (Detection(cell.parts[0].name, T),), seed=3)
    (found,) = localize(scan, cell.parts[0], cell, seed=0)
    np.testing.assert_allclose(found.T_world_part.translation, T.translation, atol=0.002)
    assert least < found.probability <= most


def test_the_rough_surface_has_fewer_triangles_and_lies_near_the_fine_one():
    surface = prepare(read_part("bolt"))
    assert len(surface.rough_triangles) < len(surface.triangles)
    rough = trimesh.Trimesh(surface.rough_vertices, surface.rough_triangles, process=False)
    points = trimesh.sample.sample_surface(rough, 2000, seed=1)[0].astype(np.float32)
    off = surface.scene.compute_distance(o3d.core.Tensor(points)).numpy()
    assert np.quantile(off, 0.95) < 2 * ROUGH_OFF * surface.diameter


@pytest.mark.parametrize("name", ["bracket", "puck"])
def test_a_resized_surface_is_that_of_the_resized_part(name):
    part, factor = read_part(name), 1.07
    fixed = prepare(part).fixed
    resized = resize_surface(prepare(part), factor)
    anew = prepare(sized(part, factor, about_middle=True))
    assert resized.diameter == pytest.approx(anew.diameter)
    np.testing.assert_allclose(resized.middle, anew.middle, atol=1e-9)
    np.testing.assert_allclose(resized.fixed, anew.fixed, atol=1e-9)
    # A near-symmetry takes the resized surface nearly onto itself, as before.
    points = np.array(resized.vertices, np.float32)
    for motion in resized.symmetry.motions:
        moved = (points @ motion[:3, :3].T + motion[:3, 3]).astype(np.float32)
        off = resized.scene.compute_distance(o3d.core.Tensor(moved)).numpy()
        small = fixed + (moved - fixed) / factor
        before = prepare(part).scene.compute_distance(o3d.core.Tensor(small.astype(np.float32)))
        np.testing.assert_allclose(off, factor * before.numpy(), atol=1e-5)


@pytest.mark.parametrize("by", [0.001, -0.001])
def test_faces_of_a_grown_part_lie_further_outside(by):
    part = read_part("puck")
    sizes = np.ptp(grown(part, by).mesh.points, axis=0) - np.ptp(part.mesh.points, axis=0)
    np.testing.assert_allclose(sizes, 2 * by, atol=2e-5)


def test_a_library_of_two_hundred_kinds_is_prepared_once(monkeypatch):
    prepared = []
    monkeypatch.setattr(part_surface, "_kept", {})
    monkeypatch.setattr(part_surface, "_prepare", lambda part: prepared.append(part) or part)
    kinds = [SimpleNamespace(digest=str(k)) for k in range(200)]
    for _ in range(3):
        assert [prepare(kind) for kind in kinds] == kinds
    assert prepared == kinds
