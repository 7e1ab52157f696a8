"""The bodies in a CAD file, with their names and places; read in a process of its own."""

import zipfile
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from io import BytesIO
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np

from workbench.formats.clouds.scans import points_of
from workbench.formats.files.reader_process import Answer, apart
from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import MB, read_whole
from workbench.formats.meshes.cloud_surface import surface_through
from workbench.formats.meshes.reading import LARGEST_MESH, EmptyMesh, bare_collada, read_mesh
from workbench.formats.meshes.repair import joined_corners, shells_of
from workbench.formats.meshes.step_files import converted_step, stated_unit
from workbench.model.errors import FileError
from workbench.model.geometry import Floats, Mesh
from workbench.model.messages.files import FileProblem, FileText

STEP_KINDS = (".step", ".stp")
SCENES = (".3mf", ".dae", ".glb", ".gltf", *STEP_KINDS)
"""Formats whose bodies have names, and that say in which unit they are."""

MESH_ENDINGS = (".stl", ".obj", ".ply", ".pcd", *SCENES)
ZIPPED = (".zip", ".zae")

MOST_TRIANGLES = 4_000_000
MOST_BODIES = 10_000

UNITS_OF_3MF = {
    "micron": 1e-6,
    "millimeter": 1e-3,
    "centimeter": 1e-2,
    "inch": 0.0254,
    "foot": 0.3048,
    "meter": 1.0,
}
"""[m]"""


@dataclass(frozen=True, slots=True, eq=False)
class CadBody:
    """Triangles in a file's unit, in the body's own frame.

    `T` (4, 4), its shift in that unit, places them in the file's frame.
    """

    name: str
    mesh: Mesh
    T: Floats

    @property
    def placed(self) -> Mesh:
        """The body in the frame of the file."""
        return _move(self.mesh, self.T)

    @property
    def own(self) -> Mesh:
        """The body in its own frame, as large as it is in the file."""
        A = self.T[:3, :3]
        scale = float(np.linalg.norm(A, axis=0).mean())
        is_rigid = np.allclose(A.T @ A, scale**2 * np.eye(3), atol=1e-6 * scale**2)
        M = np.eye(4)
        M[:3, :3] = scale * np.eye(3) if is_rigid and np.linalg.det(A) > 0 else A
        return _move(self.mesh, M)


@dataclass(frozen=True, slots=True, eq=False)
class CadBodies:
    """What a file holds; `scale` makes metres of its lengths, None when it does not say its unit.

    `kind` is the ending of the file, or of the one in an archive.
    """

    bodies: tuple[CadBody, ...]
    scale: float | None
    kind: str


def bodies_of(path: Path) -> CadBodies:
    """The bodies in a file, read by a process of its own.

    Raises:
        FileError: it cannot be read, or holds nothing that has a surface.
    """
    answer = apart(path, raw_bodies)
    content: Any = answer.value
    points, triangles = answer.arrays["points"], answer.arrays["triangles"]
    of_points = np.cumsum(answer.arrays["counts"][:, 0])[:-1]
    of_triangles = np.cumsum(answer.arrays["counts"][:, 1])[:-1]
    bodies = zip(
        content["names"],
        np.split(points, of_points),
        np.split(triangles, of_triangles),
        answer.arrays["places"],
        strict=True,
    )
    each = tuple(CadBody(name, Mesh(p, t), T) for name, p, t, T in bodies)
    return CadBodies(each, content["scale"], content["kind"])


def raw_bodies(path: Path) -> Answer:
    """The bodies as what `apart` brings back.

    Raises:
        FileError: as `bodies_of` has it.
    """
    found = read_bodies(path)
    return Answer(
        {"names": [body.name for body in found.bodies], "scale": found.scale, "kind": found.kind},
        {
            "points": np.vstack([body.mesh.points for body in found.bodies]),
            "triangles": np.vstack([body.mesh.triangles for body in found.bodies]),
            "counts": np.array([(len(b.mesh.points), len(b.mesh.triangles)) for b in found.bodies]),
            "places": np.array([body.T for body in found.bodies]),
        },
    )


def read_bodies(path: Path) -> CadBodies:
    """The bodies in a file; for a process of its own, since readers may crash it.

    Raises:
        FileError: as `bodies_of` has it.
    """
    kind = path.suffix.lower()
    try:
        if kind in ZIPPED:
            inner = _unzip(path, Path("unzipped"))
            try:
                return read_bodies(inner)
            except FileError as error:
                within = FileText.WITHIN(file=inner.name, problem=error.problem)
                raise FileError(path, within) from None
        if kind not in SCENES:
            return CadBodies((_read_unnamed(path),), None, kind)
        if kind in STEP_KINDS:
            bodies, _ = _scene(converted_step(path, Path("converted.glb")), 1.0)
            # As in the file, so that a person who knows that it states a wrong unit can say so.
            scale = stated_unit(path)
            bodies = [solid for body in bodies for solid in _solids(_in_unit(body, scale))]
        else:
            bodies, scale = _scene(path, None)
    except FileError as error:
        raise FileError(path, error.problem) from None
    return CadBodies(tuple(bodies), scale, kind)


def _in_unit(body: CadBody, unit: float) -> CadBody:
    """A body in metres in a unit of this many metres."""
    T = body.T.copy()
    T[:3, 3] /= unit
    return CadBody(body.name, Mesh(body.mesh.points / unit, body.mesh.triangles), T)


def _read_unnamed(path: Path) -> CadBody:
    # Bounded as if it were in millimetres: the unit is looked at later.
    if path.suffix.lower() == ".pcd":
        return _read_points(path)
    try:
        mesh = read_mesh(path, 0.001, most=MOST_TRIANGLES)
    except EmptyMesh:
        if path.suffix.lower() != ".ply":
            raise
        return _read_points(path)
    return CadBody(path.stem, Mesh(mesh.points * 1000, mesh.triangles), np.eye(4))


def _read_points(path: Path) -> CadBody:
    """A model that is a cloud.

    Raises:
        FileError: it cannot be read, or no surface passes its points.
    """
    mesh = surface_through(points_of(path, read_whole(path, LARGEST_MESH)))
    if mesh is None:
        raise FileError(path, FileProblem.NO_SURFACE())
    return CadBody(path.stem, mesh, np.eye(4))


def _scene(path: Path, scale: float | None) -> tuple[list[CadBody], float]:
    """Every body of a file whose bodies have names, and how many metres its unit has."""
    import trimesh
    from trimesh.resolvers import FilePathResolver

    kind = path.suffix[1:].lower()
    content = read_whole(path, 4 * LARGEST_MESH)
    options: dict[str, Any] = {"merge_primitives": True} if kind in ("glb", "gltf") else {}
    resolver = FilePathResolver(str(path))
    try:
        source = bare_collada(content) if kind == "dae" else BytesIO(content)
        scene = trimesh.load_scene(source, file_type=kind, resolver=resolver, **options)
        unit = str(scene.units or "")
        bodies = list(_nodes(scene))
    except MemoryError:
        raise
    except FileNotFoundError as error:
        name = Path(str(error.filename or error)).name
        raise FileError(path, FileProblem.NEEDS(name=name)) from None
    except zipfile.BadZipFile:
        raise FileError(path, FileProblem.BROKEN(kind=kind.upper(), detail="ZIP")) from None
    except Exception as error:  # the loaders behind trimesh raise whatever they like
        broken = FileProblem.BROKEN(kind=kind.upper(), detail=quote(str(error)))
        raise FileError(path, broken) from None
    if not bodies:
        raise FileError(path, FileProblem.NO_TRIANGLES())
    count = sum(len(body.mesh.triangles) for body in bodies)
    if count > MOST_TRIANGLES or len(bodies) > MOST_BODIES:
        raise FileError(path, FileProblem.TRIANGLES(count=count, most=MOST_TRIANGLES))
    if not all(
        np.isfinite(body.mesh.points).all() and np.isfinite(body.T).all() for body in bodies
    ):
        raise FileError(path, FileProblem.NOT_FINITE())
    return bodies, scale or _metres(kind, unit)


def _nodes(scene: Any) -> Iterator[CadBody]:
    """The meshes of a scene, each under a name of its own; lines and points are left out."""
    named: dict[str, int] = {}
    for node in sorted(scene.graph.nodes_geometry):
        T, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        triangles = np.asarray(getattr(mesh, "faces", ()))
        if len(triangles) == 0:
            continue
        name = str(geometry)
        named[name] = named.get(name, 0) + 1
        if named[name] > 1:
            name = f"{name}-{named[name]}"
        points = np.array(mesh.vertices, np.float64)
        if triangles.min() < 0 or triangles.max() >= len(points):
            raise ValueError("a triangle has a corner that does not exist")
        yield CadBody(name, Mesh(points, triangles), np.array(T, np.float64))


def _metres(kind: str, unit: str) -> float:
    """How many metres the unit has that trimesh says a file has."""
    if kind in ("glb", "gltf"):
        return 1.0
    if kind == "3mf":
        return UNITS_OF_3MF.get(unit.rstrip("s").replace("inche", "inch"), 1e-3)
    number = unit.partition(" * ")[0]
    return float(number) if " * " in unit else 1.0


def _solids(body: CadBody) -> list[CadBody]:
    """A body of a STEP file as its solids, which one product may have several of."""
    mesh, _ = joined_corners(body.mesh)
    of_shell, outer = shells_of(mesh)
    solids = sorted(set(outer.tolist()))
    if len(solids) < 2:
        return [body]
    found: list[CadBody] = []
    for number, solid in enumerate(solids, 1):
        used, triangles = np.unique(mesh.triangles[outer[of_shell] == solid], return_inverse=True)
        solid_mesh = Mesh(mesh.points[used], triangles.reshape(-1, 3))
        found.append(replace(body, name=f"{body.name}/{number}", mesh=solid_mesh))
    return found


def _unzip(path: Path, folder: Path) -> Path:
    """The only CAD file in an archive, unpacked with what lies beside it."""
    try:
        with zipfile.ZipFile(BytesIO(read_whole(path, LARGEST_MESH))) as archive:
            members = [info for info in archive.infolist() if _is_wanted(info)]
            named = [
                member.filename for member in members if _suffix(member.filename) in MESH_ENDINGS
            ]
            if len(named) != 1:
                held = FileProblem.SEVERAL_CAD(count=len(named), names=named[:8])
                raise FileError(path, held if named else FileProblem.NO_CAD())
            left = 4 * LARGEST_MESH
            for member in members:
                place = folder / PurePosixPath(member.filename)
                place.parent.mkdir(parents=True, exist_ok=True)
                with archive.open(member) as source:
                    content = source.read(left + 1)
                left -= len(content)
                if left < 0:
                    raise FileError(path, FileProblem.UNPACKS(most=f"{4 * LARGEST_MESH / MB:g}"))
                place.write_bytes(content)
    except (zipfile.BadZipFile, zlib.error, ValueError, OSError, EOFError, RuntimeError):
        raise FileError(path, FileProblem.NO_ZIP()) from None
    return folder / PurePosixPath(named[0])


def _is_wanted(member: zipfile.ZipInfo) -> bool:
    """Whether it is a file that stays in the folder and is not what macOS adds."""
    parts = PurePosixPath(member.filename).parts
    is_odd = any(part in ("..", "__MACOSX") or part.startswith((".", "/")) for part in parts)
    return bool(parts) and not member.is_dir() and not is_odd


def _suffix(name: str) -> str:
    return PurePosixPath(name).suffix.lower()


def _move(mesh: Mesh, T: Floats) -> Mesh:
    """A mesh after an affine map; what was outside stays outside where it mirrors."""
    if np.array_equal(T, np.eye(4)):
        return mesh
    triangles = np.asarray(mesh.triangles)
    is_mirrored = np.linalg.det(T[:3, :3]) < 0
    return Mesh(
        mesh.points @ T[:3, :3].T + T[:3, 3], triangles[:, ::-1] if is_mirrored else triangles
    )
