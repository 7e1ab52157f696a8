"""Triangle meshes from files, in metres."""

import xml.etree.ElementTree as ElementTree
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import numpy as np

from workbench.formats.clouds.pcd import read_pcd
from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import MB, is_file, read_whole
from workbench.formats.meshes.mesh_cache import load_or_make, pack_meshes, recipe, unpack_meshes
from workbench.formats.meshes.repair import examine_surface
from workbench.model.errors import FileError
from workbench.model.geometry import Floats, Mesh
from workbench.model.messages.files import FileProblem

MESH_ENDINGS = (".stl", ".obj", ".ply", ".glb", ".dae", ".off", ".pcd")
"""Of mesh files.  Among what else trimesh reads are archives, and these may hold any amount."""
LARGEST_MESH = 100 * MB
LARGEST_KEPT = 8 * MB
"""Of a file whose triangles are kept: reading a larger one takes longer than starting to."""
MOST_TRIANGLES = 1_000_000
MOST_FACES = 4_000
"""Of a convex piece: one with more is no simple piece, and slow to check."""
LARGEST_EXTENT = 20.0
"""[m] Anything larger is taken for millimetres read as metres."""
SLIVER = 5e-5
"""[m] A triangle with less height than this has no plane of its own."""
FLATNESS = 1e-4
"""[m] How far a corner of a convex piece may stand beyond the plane of one of its faces."""
THINNEST = 1e-6
"""Thickness [m] up to which a body counts as flat: rounding moves corners off a plane by this."""
HEADER, TRIANGLE = 84, 50
"""[bytes] In a binary STL file."""
MOST_NEIGHBOURS = 254
"""Of one corner of a convex mesh: Coal counts them in one byte."""


class WrongUnit(FileError):
    """A mesh would be as large as none is; it has another unit."""


class EmptyMesh(FileError):
    """A whole file of a mesh without a triangle, as makers publish where a link has no shape."""


def read_mesh(
    path: Path,
    scale: Floats | float = 1.0,
    *,
    is_piece: bool = False,
    most: int = MOST_TRIANGLES,
) -> Mesh:
    """The triangles of an STL, OBJ, PLY, GLB, DAE or OFF file, multiplied by `scale`, no unit.

    One number, or (3,) for the axes, makes metres of the file's lengths.  Numbers below zero mirror
    it; what was outside stays outside.  With `is_piece` its file calls it convex (`as_convex`);
    `most` are the triangles that it may have.

    A PCD file is a part taught by scanning it: its convex hull, in a frame in the middle of its
    points.

    Raises:
        FileError: not there, of another kind, too large, not a mesh, empty, not finite, or of a
            size that speaks for another unit; or not convex, though it should be.
    """
    if not is_file(path):
        raise FileError(path, FileProblem.MISSING())
    kind = path.suffix.lower()
    if kind not in MESH_ENDINGS:
        raise FileError(path, FileProblem.NO_MESH(kinds=MESH_ENDINGS))
    content = read_whole(path, LARGEST_MESH)

    def make() -> Mesh:
        is_taught = kind == ".pcd"
        mesh = (
            _read_taught(path, content, scale)
            if is_taught
            else _load_mesh(path, content, scale, most)
        )
        return as_convex(path, mesh) if is_piece else mesh

    # What reads points of a scanner is code of another folder, which a recipe does not know of.
    if len(content) > LARGEST_KEPT or kind == ".pcd":
        return make()
    axes = np.broadcast_to(np.asarray(scale, np.float64), 3).tobytes()
    how = f"mesh {recipe('trimesh', 'scipy', 'pycollada')} {kind} {is_piece}"
    found = load_or_make(how, [axes, content], lambda: pack_meshes([make()]))
    return unpack_meshes(found)[0] if found else make()


def _load_mesh(path: Path, content: bytes, scale: Floats | float, most: int) -> Mesh:
    import trimesh  # takes a while, and is seldom needed

    kind = path.suffix[1:].lower()
    if kind == "stl":
        _check_stl(path, content)
    try:
        source = bare_collada(content) if kind == "dae" else BytesIO(content)
        loaded = trimesh.load_mesh(source, file_type=kind, process=False)
    except MemoryError:
        raise
    except Exception as error:  # the loaders behind trimesh raise whatever they like
        broken = FileProblem.BROKEN(kind=kind.upper(), detail=quote(str(error)))
        raise FileError(path, broken) from None
    triangles = np.asarray(loaded.faces)
    if len(triangles) == 0:
        raise EmptyMesh(path, FileProblem.NO_TRIANGLES())
    if len(triangles) > most:
        raise FileError(path, FileProblem.TRIANGLES(count=len(triangles), most=most))
    points = np.asarray(loaded.vertices, dtype=np.float64) * scale
    if not np.all(np.isfinite(points)):
        raise FileError(path, FileProblem.NOT_FINITE())
    if triangles.min() < 0 or triangles.max() >= len(points):
        raise FileError(path, FileProblem.NO_CORNER())
    size = float(np.ptp(points, axis=0).max())
    if size > LARGEST_EXTENT:
        raise WrongUnit(path, FileProblem.HUGE(size=f"{size:.0f}"))
    is_mirrored = np.prod(np.broadcast_to(scale, 3)) < 0
    return Mesh(points, triangles[:, ::-1] if is_mirrored else triangles)


def _check_stl(path: Path, content: bytes) -> None:
    """Refuse an STL file that was not written or copied to its end.

    Raises:
        FileError: says how much is missing.
    """
    if content[:6].lstrip().lower().startswith(b"solid") and b"facet" in content[:2000]:
        if b"endsolid" not in content:
            raise FileError(path, FileProblem.CUT_OFF(detail="endsolid is missing at its end"))
        return
    if len(content) < HEADER:
        return
    count = int.from_bytes(content[HEADER - 4 : HEADER], "little")
    there = (len(content) - HEADER) // TRIANGLE
    if there < count and b"facet" not in content[:2000]:
        detail = f"of {count} triangles that it has, {there} are there"
        raise FileError(path, FileProblem.CUT_OFF(detail=detail))


MATERIALS = ("bind_material", "library_images", "library_effects", "library_materials")


def bare_collada(content: bytes) -> BytesIO:
    """A DAE file without what it says of colours.

    Its reader leaves out the bodies whose picture is missing: the robot would have a hole.
    """
    root = ElementTree.fromstring(content)
    for parent in root.iter():
        for child in list(parent):
            if child.tag.rpartition("}")[2] in MATERIALS:
                parent.remove(child)
    return BytesIO(ElementTree.tostring(root))


def collada_unit(path: Path) -> float:
    """How many metres the unit has that a DAE file states; 1 where it states none.

    Raises:
        FileError: the file cannot be read.
    """
    content = read_whole(path, LARGEST_MESH)
    with suppress(ElementTree.ParseError, ValueError):  # `read_mesh` refuses what is no XML
        for _, element in ElementTree.iterparse(BytesIO(content), ("start",)):
            if element.tag.rpartition("}")[2] == "unit":
                unit = float(element.get("meter", "1"))
                return unit if 0 < unit < np.inf else 1.0
    return 1.0


def _read_taught(path: Path, content: bytes, scale: Floats | float) -> Mesh:
    points = read_pcd(path, content, MOST_TRIANGLES).points
    # Many scanners put pixels without a measurement at exactly (0, 0, 0).
    points = points[np.isfinite(points).all(axis=1) & points.any(axis=1)] * scale
    if len(points) < 4:
        raise FileError(path, "holds fewer than four points")
    hull = convex_hull(Mesh(points - points.mean(axis=0), np.empty((0, 3), np.int32)))
    if hull is None:
        raise FileError(path, FileProblem.FLAT())
    size = float(np.ptp(hull.points, axis=0).max())
    if size > LARGEST_EXTENT:
        raise FileError(path, FileProblem.HUGE(size=f"{size:.0f}"))
    return Mesh(hull.points, hull.triangles)


def convex_hull(mesh: Mesh) -> Mesh | None:
    """The convex hull as a solid convex mesh; None when all points lie in one plane."""
    if is_flat(np.asarray(mesh.points)):
        return None
    import trimesh
    from scipy.spatial import QhullError

    try:
        hull = trimesh.Trimesh(mesh.points, mesh.triangles, process=False).convex_hull
    except QhullError:
        return None
    return Mesh(hull.vertices, hull.faces, is_convex=True)


def is_flat(points: Floats) -> bool:
    """Whether points (n, 3) [m] lie in one plane."""
    if len(points) < 4:
        return True
    off = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(off, full_matrices=False)
    return bool(np.ptp(off @ axes[2]) < THINNEST)


def most_neighbours(mesh: Mesh) -> int:
    """To how many others an edge leads from the corner of a mesh that has most of them."""
    ends = np.sort(mesh.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return int(np.bincount(np.unique(ends, axis=0).ravel()).max())


def as_convex(path: Path, mesh: Mesh) -> Mesh:
    """A mesh that its file calls convex, as a solid convex one.

    Raises:
        FileError: it is not: a corner lies outside of a face, or a face looks inwards.  The
            collision checker would believe it, and overlook what sticks out.  Or it is flat, or
            has too many faces, in all or at one corner.
    """
    if len(mesh.triangles) > MOST_FACES:
        raise FileError(
            path, f"has {len(mesh.triangles)} faces, a convex piece may have {MOST_FACES}"
        )
    a, b, c = mesh.points[mesh.triangles.T]
    outward = np.cross(b - a, c - a)
    length = np.linalg.norm(outward, axis=1, keepdims=True)
    # The plane of a sliver means nothing: rounding a corner turns it as it likes.
    edges = np.stack([b - a, c - b, a - c])
    is_sliver = length[:, 0] < SLIVER * np.linalg.norm(edges, axis=2).max(axis=0)
    a, outward, length = a[~is_sliver], outward[~is_sliver], length[~is_sliver]
    if len(a) < 4:
        raise FileError(path, "is called convex, but has fewer than four faces")
    planes = outward / length
    beyond = mesh.points @ planes.T - np.einsum("nk,nk->n", planes, a)
    if beyond.max() > FLATNESS:
        raise FileError(
            path,
            f"is called convex, but a corner lies {beyond.max() * 1000:.2f} mm outside of a face",
        )
    # Coal walks from corner to corner along the edges: in a surface in pieces, as files have it
    # that give each face a normal of its own, it would not get far.
    surface, corners = examine_surface(mesh), len(np.unique(mesh.triangles))
    is_whole = surface.is_watertight and surface.components == 1 and corners == len(mesh.points)
    solid = Mesh(mesh.points, mesh.triangles, is_convex=True) if is_whole else convex_hull(mesh)
    if solid is None or is_flat(np.asarray(mesh.points)):
        raise FileError(path, "is called convex, but lies in one plane")
    if most_neighbours(solid) > MOST_NEIGHBOURS:
        raise FileError(
            path, f"has more than {MOST_NEIGHBOURS} edges at one corner; give it fewer faces"
        )
    return solid
