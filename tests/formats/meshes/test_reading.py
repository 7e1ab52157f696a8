"""Convex meshes: whole, solid, of no more edges at a corner than the collision checker takes."""

import bz2
from pathlib import Path

import coal
import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.files.toml_keys import read_toml
from workbench.formats.meshes.pieces.convex_pieces import hull_of, pieces_of
from workbench.formats.meshes.reading import as_convex, convex_hull, read_mesh
from workbench.formats.meshes.solids import read_solid
from workbench.model.errors import FileError
from workbench.model.geometry import Floats, Mesh
from workbench.planning.collision.bodies import coal_shape
from workbench.proof.engine.shapes import coal_shape as coal_shape_of_proof


def prism(sides: int, *, flat: bool) -> str:
    """A prism of 100 mm as OBJ, each face with a normal of its own where it is to look flat."""
    angles = np.arange(sides) * 2 * np.pi / sides
    ring = 0.05 * np.column_stack([np.cos(angles), np.sin(angles)])
    lines = [f"v {x:.7f} {y:.7f} {z}" for z in (-0.05, 0.05) for x, y in ring]
    middle = angles + np.pi / sides
    lines += [f"vn {np.cos(angle):.5f} {np.sin(angle):.5f} 0" for angle in middle]
    lines += ["vn 0 0 1", "vn 0 0 -1"]
    faces = [(k, a, b, c) for k in range(sides) for a, b, c in _side(k, (k + 1) % sides, sides)]
    faces += [(sides, sides, sides + k, sides + k + 1) for k in range(1, sides - 1)]
    faces += [(sides + 1, 0, k + 1, k) for k in range(1, sides - 1)]
    for normal, *corners in faces:
        lines.append(
            "f " + " ".join(f"{c + 1}//{normal + 1}" if flat else f"{c + 1}" for c in corners)
        )
    return "\n".join(lines) + "\n"


def _side(k: int, j: int, sides: int) -> tuple[tuple[int, int, int], ...]:
    return (k, j, sides + j), (k, sides + j, sides + k)


def distances(shape: coal.CollisionGeometry) -> Floats:
    """From a box, over many poses [m]."""
    draw, box = np.random.default_rng(0), coal.Box(np.array([0.04, 0.06, 0.08]))
    found: list[float] = []
    for _ in range(300):
        there = coal.Transform3s(pin.exp3(draw.uniform(-2, 2, 3)), draw.uniform(-0.12, 0.12, 3))
        still, result = coal.Transform3s(np.eye(3), np.zeros(3)), coal.DistanceResult()
        found.append(coal.distance(shape, there, box, still, coal.DistanceRequest(), result))
    return np.array(found)


@pytest.mark.parametrize("made", [coal_shape, coal_shape_of_proof], ids=["planning", "proof"])
def test_a_convex_piece_that_is_shaded_flat_is_as_large_as_it_is(made, tmp_path: Path) -> None:
    """Its file gives each face corners of its own: Coal has to get from one to the next."""
    pieces: list[Mesh] = []
    for flat in (True, False):
        path = tmp_path / f"{flat}.convex.obj"
        path.write_text(prism(24, flat=flat))
        pieces.append(as_convex(path, read_mesh(path)))
    shaded, plain = (distances(made(piece)) for piece in pieces)
    assert shaded == pytest.approx(plain, abs=1e-5)
    assert 50 < np.sum(plain > 0) < 250, "one of the two answers hardly came"


def test_the_proof_joins_the_corners_of_a_convex_mesh_itself(tmp_path: Path) -> None:
    path = tmp_path / "prism.obj"
    path.write_text(prism(24, flat=True))
    mesh = read_mesh(path)
    split = Mesh(mesh.points, mesh.triangles, is_convex=True)
    assert len(mesh.points) > 48
    whole = convex_hull(mesh)
    assert whole is not None
    one, other = (distances(coal_shape_of_proof(shape)) for shape in (split, whole))
    assert one == pytest.approx(other, abs=1e-5)


def test_a_convex_piece_with_a_corner_on_no_face_is_whole_all_the_same(tmp_path: Path) -> None:
    box = trimesh.creation.box((0.1, 0.1, 0.1))
    loose = Mesh(np.vstack([np.zeros((1, 3)), box.vertices]), box.faces + 1)
    assert len(as_convex(tmp_path, loose).points) == 8


def flat_meshes() -> dict[str, Mesh]:
    """A square, a fan of 120 corners, and the same aslant as an STL file rounds it."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]) * 0.1
    square = Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))
    angles = np.arange(120) * 2 * np.pi / 120
    ring = 0.05 * np.column_stack([np.cos(angles), np.sin(angles), np.zeros(120)])
    fan = Mesh(ring, np.array([[0, k, k + 1] for k in range(1, 119)]))
    aslant = (ring @ pin.exp3(np.array([0.5, 0.7, 0.2])).T + 0.4).astype(np.float32)
    return {"square": square, "fan": fan, "aslant": Mesh(aslant, fan.triangles)}


@pytest.mark.parametrize("name", ["square", "fan", "aslant"])
def test_what_is_flat_has_no_hull_and_no_pieces(name: str) -> None:
    mesh = flat_meshes()[name]
    assert convex_hull(mesh) is None
    assert pieces_of(mesh, tolerance=0.001) is None


def test_what_is_thin_has_a_hull() -> None:
    foil = convex_hull(Mesh(*_surface(trimesh.creation.box((0.1, 0.1, 1e-5)))))
    assert foil is not None and len(foil.points) == 8


def test_a_flat_cloud_is_no_part(tmp_path: Path) -> None:
    head = "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 25\nHEIGHT 1\n"
    rows = [f"{x / 100} {y / 100} 0.4" for x in range(5) for y in range(5)]
    (tmp_path / "flat.pcd").write_text(
        f"{head}VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 25\nDATA ascii\n" + "\n".join(rows) + "\n"
    )
    with pytest.raises(FileError, match="its points lie in one plane"):
        read_mesh(tmp_path / "flat.pcd")


@pytest.mark.parametrize("name", ["part.stl.bz2", "part.zip", "part", "part.3mf"])
def test_only_meshes_are_opened(name: str, tmp_path: Path) -> None:
    """An archive may hold more than there is memory for."""
    inner = prism(24, flat=False).encode()
    (tmp_path / name).write_bytes(bz2.compress(inner) if name.endswith("bz2") else inner)
    with pytest.raises(FileError, match=r"is no mesh that can be read: one of \.stl, \.obj,"):
        read_mesh(tmp_path / name)


def test_a_flat_piece_is_no_convex_one(tmp_path: Path) -> None:
    square = flat_meshes()["fan"]
    both = np.concatenate([square.triangles, square.triangles[:, ::-1]])
    with pytest.raises(FileError, match="lies in one plane"):
        as_convex(tmp_path, Mesh(square.points, both))


def _surface(found: trimesh.Trimesh) -> tuple[Floats, np.ndarray]:
    return np.asarray(found.vertices), np.asarray(found.faces)


ROUND = {
    "cone": trimesh.creation.cone(0.1, 0.2, sections=300),
    "cylinder": trimesh.creation.cylinder(0.1, 0.2, sections=520),
}


@pytest.mark.parametrize("name", ROUND)
def test_a_hull_with_a_corner_of_many_edges_is_one_that_coal_takes(name: str) -> None:
    mesh = Mesh(*_surface(ROUND[name]))
    hull = hull_of(mesh)
    assert hull is not None
    for made in (coal_shape, coal_shape_of_proof):
        far = coal.Transform3s(np.eye(3), np.array([0.5, 0.0, 0.0]))
        near = coal.Transform3s(np.eye(3), np.zeros(3))
        ball, result = coal.Sphere(0.1), coal.DistanceResult()
        gap = coal.distance(made(hull), near, ball, far, coal.DistanceRequest(), result)
        assert 0.299 < gap < 0.3001, "it may be too large, by little, and not too small"


def test_a_solid_with_a_corner_of_many_edges_can_be_checked(tmp_path: Path) -> None:
    ROUND["cone"].export(tmp_path / "cone.stl")
    (tmp_path / "solid.toml").write_text(
        'name = "cone"\nshape = "mesh"\nfile = "cone.stl"\nunit = "m"\n'
    )
    coal_shape(read_solid(read_toml(tmp_path / "solid.toml")).shape)


def test_a_convex_piece_with_a_corner_of_many_edges_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FileError, match="has more than 254 edges at one corner"):
        as_convex(tmp_path, Mesh(*_surface(ROUND["cone"])))
