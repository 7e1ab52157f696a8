"""What is wrong with surfaces, and what mending makes of it."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.formats.meshes.repair import (
    examine_surface,
    joined_corners,
    outside_out,
    repair_surface,
)
from workbench.model.geometry import Mesh


def mesh_of(surface: trimesh.Trimesh) -> Mesh:
    return Mesh(surface.vertices, surface.faces)


def soup(surface: trimesh.Trimesh) -> Mesh:
    """As an STL file has it: every triangle with corners of its own."""
    points = np.asarray(surface.triangles).reshape(-1, 3)
    return Mesh(points, np.arange(len(points)).reshape(-1, 3))


@pytest.fixture
def ball() -> trimesh.Trimesh:
    return trimesh.creation.icosphere(2, 0.01)


def test_a_closed_surface_has_no_problems(ball):
    mesh, done = joined_corners(soup(ball))
    surface = examine_surface(mesh)
    assert done == () and surface.problems == () and surface.is_watertight
    assert (surface.triangles, surface.components) == (320, 1)
    assert surface.size == pytest.approx([0.02] * 3, rel=0.01)
    assert surface.volume == pytest.approx(ball.volume)


def test_a_hole_is_told_and_closed(ball):
    holed = Mesh(ball.vertices, ball.faces[1:])
    surface = examine_surface(holed)
    assert surface.problems == ("3 edges are open",) and surface.volume == 0.0
    mended, done = repair_surface(holed)
    assert done == ("holes closed with 1 triangles",)
    assert examine_surface(mended).problems == ()
    assert examine_surface(mended).volume == pytest.approx(ball.volume)


def test_half_a_part_is_not_closed_with_a_lid(ball):
    half = Mesh(ball.vertices, ball.faces[np.asarray(ball.triangles_center)[:, 2] > 0])
    mended, _ = repair_surface(half)
    assert "edges are open" in examine_surface(mended).problems[0]


def test_turned_triangles_are_turned_back(ball):
    faces = np.array(ball.faces)
    faces[10:20] = faces[10:20, ::-1]
    mesh = Mesh(ball.vertices, faces)
    assert "do not fit together" in examine_surface(mesh).problems[0]
    mended, done = repair_surface(mesh)
    assert "10 triangles turned" in done[0]
    assert examine_surface(mended).problems == ()
    assert examine_surface(mended).volume == pytest.approx(ball.volume)


def test_inside_out_is_told_and_turned(ball):
    mesh = Mesh(ball.vertices, ball.faces[:, ::-1])
    assert examine_surface(mesh).problems == ("it is inside out",)
    mended, done = repair_surface(mesh)
    assert done == ("1 body that was inside out turned",)
    assert examine_surface(mended).problems == ()


def test_a_hollow_stays_a_hollow(ball):
    inner = ball.copy().apply_scale(0.5)
    inner.invert()
    hollow = trimesh.util.concatenate([ball, inner])
    mended, done = repair_surface(mesh_of(hollow))
    assert done == ()
    assert examine_surface(mended).volume == pytest.approx(ball.volume * 7 / 8)


def test_what_is_there_twice_or_has_no_corners_is_left_out(ball):
    faces = np.vstack([ball.faces, ball.faces[:3], [[5, 5, 6]]])
    mesh, done = joined_corners(Mesh(ball.vertices, faces))
    assert len(mesh.triangles) == 320
    assert done == (
        "1 triangles with two corners left out",
        "3 triangles left out that were there twice",
    )


def test_crumbs_are_left_out_and_other_pieces_stay(ball):
    crumb = ball.copy().apply_scale(0.01).apply_translation([0.1, 0, 0])
    beside = ball.copy().apply_translation([0.05, 0, 0])
    mended, done = repair_surface(mesh_of(trimesh.util.concatenate([ball, crumb, beside])))
    assert done == ("1 crumbs beside the part left out",)
    assert examine_surface(mended).components == 2


def test_a_slit_without_area_is_closed_at_the_corner_in_it():
    box = trimesh.creation.box((0.06, 0.04, 0.02))
    a, b = box.faces[0][:2]
    third = box.faces[0][2]
    points = np.vstack([box.vertices, (box.vertices[a] + box.vertices[b]) / 2])
    faces = np.vstack([box.faces[1:], [[a, 8, third], [8, b, third]]])
    assert examine_surface(Mesh(points, faces)).open_edges == 3
    mended, done = repair_surface(Mesh(points, faces))
    assert done == ("slits closed at 1 corners",)
    assert examine_surface(mended).problems == () and examine_surface(
        mended
    ).volume == pytest.approx(48e-6)


def test_corners_that_nearly_meet_are_joined(ball):
    points = np.vstack([ball.vertices, ball.vertices[ball.faces[0]] + [1.5e-6, 0, 0]])
    faces = np.array(ball.faces)
    faces[0] = len(ball.vertices) + np.arange(3)
    mended, done = repair_surface(Mesh(points, faces))
    assert done[0] == "3 corners along gaps joined"
    assert examine_surface(mended).problems == ()


def test_bodies_that_touch_are_two_bodies():
    box = trimesh.creation.box((0.06, 0.04, 0.02))
    above = trimesh.creation.box((0.06, 0.04, 0.015))
    above.apply_translation([0, 0, 0.0175])
    mesh, done = joined_corners(soup(trimesh.util.concatenate([box, above])))
    surface = examine_surface(mesh)
    assert done == () and surface.problems == ()
    assert surface.components == 2 and surface.volume == pytest.approx(84e-6)


def test_one_body_of_two_that_is_inside_out_is_told_and_turned(ball):
    beside = ball.copy().apply_scale(0.5).apply_translation([0.05, 0, 0])
    beside.invert()
    mesh = mesh_of(trimesh.util.concatenate([ball, beside]))
    assert examine_surface(mesh).problems == ("it is inside out",)
    mended, _ = outside_out(mesh)
    assert examine_surface(mended).volume == pytest.approx(ball.volume * 9 / 8)


def test_a_surface_written_from_both_sides_gets_one():
    box = trimesh.creation.box((0.06, 0.04, 0.02))
    mesh, _ = joined_corners(Mesh(box.vertices, np.vstack([box.faces, box.faces[:, ::-1]])))
    mended, done = repair_surface(mesh)
    assert done[0].startswith("12 triangles left out that were there twice")
    assert examine_surface(mended).problems == () and examine_surface(
        mended
    ).volume == pytest.approx(48e-6)


def test_a_sheet_that_hangs_in_a_body_is_left_out():
    box = trimesh.creation.box((0.06, 0.04, 0.02))
    low, high = box.vertices.min(axis=0), box.vertices.max(axis=0)
    a, b = (int(np.flatnonzero((box.vertices == c).all(axis=1))[0])
            for c in ((low[0], low[1], low[2]), (high[0], low[1], low[2])))  # fmt: skip
    points = np.vstack([box.vertices, [0, 0, 0]])
    mesh = Mesh(points, np.vstack([box.faces, [[a, b, 8]]]))
    assert examine_surface(mesh).problems
    mended, done = repair_surface(mesh)
    assert done == ("sheets of 1 triangles that enclose nothing left out",)
    assert examine_surface(mended).volume == pytest.approx(48e-6)


@settings(max_examples=60, deadline=None)
@given(
    st.lists(st.tuples(*[st.integers(0, 9)] * 3), min_size=1, max_size=40),
    st.integers(0, 2**32 - 1),
)
def test_no_surface_is_too_broken_to_look_at(triangles, seed):
    points = np.random.default_rng(seed).uniform(-0.05, 0.05, (10, 3))
    mesh, _ = joined_corners(Mesh(points, np.array(triangles)))
    if len(mesh.triangles) == 0:
        return
    before = examine_surface(mesh)
    mended, _ = repair_surface(mesh)
    after = examine_surface(mended)
    # Of two triangles on each other one may go.
    gone = max(0, before.triangles - after.triangles)
    assert after.open_edges <= before.open_edges + before.bad_edges * 2 + 3 * gone
    assert np.isfinite(after.volume)
