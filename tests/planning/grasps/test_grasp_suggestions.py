"""Suggested grasps: each works, none is like another, the same for the same seed."""

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, Solid
from workbench.model.part import GraspLibrary, Part
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.grasps.part_rays import centre_of_mass


@pytest.fixture(scope="module")
def tools():
    return {name: read_cell(name).arms[0].tool for name in ("yumi", "tx2_90")}


def alone(part: Part, symmetry: Symmetry | None = None) -> Part:
    """The part without the grasps that people gave it."""
    kept = part.symmetry if symmetry is None else symmetry
    return Part(part.name, part.mesh, part.pieces, part.mass, kept, GraspLibrary())


@pytest.mark.parametrize(("name", "tool"), [("keyed_cylinder", "yumi"), ("puck", "tx2_90")])
def test_every_suggestion_works_and_the_best_comes_first(name, tool, tools):
    part = alone(read_part(name))
    found = suggest(part, tools[tool], most=12, seed=4)
    assert len(found) >= 2
    checker = GraspChecker(part, tools[tool])
    assert all(checker.check(one.grasp).findings == () for one in found)
    scores = [one.score for one in found]
    assert scores == sorted(scores, reverse=True) and 0 < scores[-1] <= scores[0] <= 1
    assert len({one.grasp.name for one in found}) == len(found)


def test_the_same_seed_gives_the_same_and_most_is_kept(tools):
    part = alone(read_part("keyed_cylinder"))
    one, two = (suggest(part, tools["yumi"], most=5, seed=9) for _ in range(2))
    assert len(one) == 5
    for a, b in zip(one, two, strict=True):
        assert a.grasp.T_part_tcp == b.grasp.T_part_tcp and a.score == b.score


def test_none_is_like_another_nor_like_one_of_the_library(tools):
    part = read_part("keyed_cylinder")
    found = [one.grasp for one in suggest(part, tools["yumi"], most=20)]
    swap = pin.SE3(pin.exp3(np.array([0, 0, np.pi])), np.zeros(3))
    for number, grasp in enumerate(found):
        for other in (*found[:number], *part.library.grasps):
            for same in (other.T_part_tcp, other.T_part_tcp * swap):
                between = same.actInv(grasp.T_part_tcp)
                turn = np.linalg.norm(pin.log3(between.rotation))
                assert np.linalg.norm(between.translation) > 0.01 or turn > np.deg2rad(29)


def test_symmetry_leaves_out_what_is_the_same_grip(tools):
    part = read_part("puck")
    with_turns = suggest(alone(part), tools["tx2_90"], most=50)
    without = suggest(alone(part, Symmetry(fold=1)), tools["tx2_90"], most=50)
    assert 0 < len(with_turns) < len(without)


def test_a_part_too_wide_for_the_fingers_gets_none(tools):
    surface = trimesh.creation.box((0.06, 0.07, 0.08))
    mesh = Mesh(surface.vertices, surface.faces)
    hull = Mesh(mesh.points, mesh.triangles, is_convex=True)
    part = Part(
        "big", mesh, (Solid("all", hull, pin.SE3.Identity()),), 1, Symmetry(), GraspLibrary()
    )
    assert suggest(part, tools["yumi"]) == ()
    # A cup takes it by the middle of a face.
    best = suggest(part, tools["tx2_90"], most=3)[0]
    assert best.lever == pytest.approx(0.0, abs=1e-9)


def test_the_centre_of_mass_is_that_of_the_body_not_of_its_corners():
    fine = trimesh.creation.box((0.02, 0.02, 0.02)).subdivide()
    corner = np.asarray(fine.vertices).max(axis=0)
    uneven = fine.copy()
    uneven.apply_translation([0.5, 0.0, 0.0])
    mesh = Mesh(np.vstack([uneven.vertices, uneven.vertices + 0]), uneven.faces)
    assert centre_of_mass(mesh) == pytest.approx([0.5, 0, 0], abs=1e-12)
    cone = trimesh.creation.cone(0.01, 0.04, sections=64)
    assert centre_of_mass(Mesh(cone.vertices, cone.faces))[2] == pytest.approx(0.01, abs=1e-4)
    assert corner[0] == pytest.approx(0.01)


def test_a_tube_is_taken_across_its_outside(tools):
    tube = trimesh.creation.annulus(0.014, 0.0166, 0.078)
    shape = Mesh(tube.vertices, tube.faces)
    part = Part("tube", shape, (), 0.02, Symmetry(0), GraspLibrary())
    found = suggest(part, tools["yumi"], most=4, seed=0)
    assert any(one.check.width == pytest.approx(0.0332, abs=2e-4) for one in found)
