"""The objects of a BOP data set: `models_info.json` and one PLY file for each, millimetres."""

from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.files.json_keys import parse_object
from workbench.formats.files.toml_keys import Table, quote
from workbench.formats.files.whole_files import MB, read_whole
from workbench.formats.meshes.reading import read_mesh
from workbench.model.errors import FileError
from workbench.model.geometry import Floats, Mesh, frozen, put
from workbench.model.symmetry import turn_about

INFO = "models_info.json"
LARGEST_FILE = 64 * MB

SYMMETRY_STEP = 0.01
"""Arc over the diameter between the turns that stand for any angle (`max_sym_disc_step`)."""

SAME_SIZE = 0.1
"""Share by which a mesh may be larger or smaller than its stated diameter."""

MOST_SYMMETRIES = 1000

SMALLEST = 0.003
"""[m] An object whose size nobody states is longer than this, or its unit is another."""


@dataclass(frozen=True, slots=True, eq=False)
class ObjectModel:
    """An object: its number, surface, diameter [m], and motions (k, 4, 4) [m] that nobody sees."""

    number: int
    mesh: Mesh
    diameter: float
    motions: Floats

    def __post_init__(self) -> None:
        put(self, motions=frozen(self.motions))


def read_models(folder: Path) -> dict[int, ObjectModel]:
    """All objects of a folder of models, by number.

    Without `models_info.json` each `obj_NUMBER.ply` is an object without symmetry.

    Raises:
        FileError: a file is missing or broken, there are no objects, or their lengths are not in
            millimetres.
    """
    path = folder / INFO
    files = sorted(folder.glob("obj_*.ply"))
    if files and not path.exists():
        return {model.number: model for model in map(_unstated_model, files)}
    table = Table(path, parse_object(path, read_whole(path, LARGEST_FILE)))
    models = {
        model.number: model
        for model in (_model(folder, name, table.table(name)) for name in table.names())
    }
    if not models:
        raise FileError(path, "names no object")
    return models


def whole_name(path: Path, name: str) -> int:
    """The number that a key is, as those of objects and images are.

    Raises:
        FileError: it is none.
    """
    if not (name.isascii() and name.isdigit() and len(name) <= 9):
        raise FileError(path, f"a number is expected as key, {quote(name)} is given")
    return int(name)


def _model(folder: Path, name: str, table: Table) -> ObjectModel:
    number = whole_name(table.path, name)
    diameter = table.number("diameter", low=1e-3, high=1e5) / 1000
    path = folder / f"obj_{number:06d}.ply"
    mesh = read_mesh(path, 0.001)
    # The diameter lies between the longest side of the box around it and that box's diagonal.
    sides = np.ptp(mesh.points, axis=0)
    longest, diagonal = float(sides.max()), float(np.linalg.norm(sides))
    if not longest / (1 + SAME_SIZE) <= diameter <= diagonal * (1 + SAME_SIZE):
        raise FileError(
            path,
            f"is {longest * 1000:.4g} mm long read as millimetres, but models_info.json says a "
            f"diameter of {diameter * 1000:.4g} mm",
        )
    return ObjectModel(number, mesh, diameter, _motions(table))


def _unstated_model(path: Path) -> ObjectModel:
    """An object of which nothing but its surface is stated."""
    number = whole_name(path, path.stem.removeprefix("obj_"))
    mesh = read_mesh(path, 0.001)
    diameter = _diameter(mesh)
    if diameter < SMALLEST:
        raise FileError(
            path, f"is {diameter * 1000:.4g} mm long: its lengths must be in millimetres"
        )
    return ObjectModel(number, mesh, diameter, np.eye(4)[None])


def _diameter(mesh: Mesh) -> float:
    """The largest distance between two of its points [m]."""
    from scipy.spatial import ConvexHull, QhullError
    from scipy.spatial.distance import pdist

    points = mesh.points
    with suppress(QhullError):  # a flat mesh has no hull
        points = points[ConvexHull(points).vertices]
    return float(pdist(points).max())


def _motions(table: Table) -> Floats:
    """The symmetries (k, 4, 4) [m], the identity first; any angle as steps.

    All turns about each axis of continuous symmetry after each discrete one, as
    `get_symmetry_transformations` has it (bop_toolkit_lib/misc.py).
    """
    rows = table.rows("symmetries_discrete", 16) if table.has("symmetries_discrete") else []
    if len(rows) > MOST_SYMMETRIES:
        raise table.error("symmetries_discrete", f"are more than {MOST_SYMMETRIES}")
    discrete = [np.eye(4)]
    for row in rows:
        M = row.reshape(4, 4).copy()
        M[:3, 3] /= 1000
        discrete.append(M)
    turns: list[Floats] = []
    for axis in table.tables("symmetries_continuous"):
        direction, offset = axis.numbers("axis", 3), axis.numbers("offset", 3) / 1000
        length = float(np.linalg.norm(direction))
        if not length > 0:
            raise axis.error("axis", "has no direction")
        count = int(np.ceil(np.pi / SYMMETRY_STEP))
        for angle in np.arange(count) * 2 * np.pi / count:
            M = np.eye(4)
            M[:3, :3] = turn_about(direction / length, float(angle))
            M[:3, 3] = offset - M[:3, :3] @ offset
            turns.append(M)
    return np.array([turn @ M for M in discrete for turn in turns or [np.eye(4)]])
