"""Meshes from CAD files that somebody else made, read in a process of its own.

The readers behind it are large, some of them C++, and a broken or hostile file may make them crash,
hang, or take all the memory: then that process ends, and nothing else.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.files.apart import Answer, apart
from workbench.formats.files.toml_keys import shown
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import MB, is_file
from workbench.formats.meshes.reading import LARGEST_MESH, MOST_TRIANGLES, read_mesh
from workbench.model.errors import FileError
from workbench.model.geometry import Mesh

STEP = (".step", ".stp")
KINDS = (".stl", ".obj", ".ply", ".glb", *STEP)
WITH_UNIT = (".glb", *STEP)
"""Formats that say in which unit they are."""

LARGEST_CAD = LARGEST_MESH
"""[bytes] Of one file."""

FINENESS_MM, FINENESS_DEG = 0.05, 10.0
"""How far a facet may lie from a round face of a STEP file, and be turned against the next."""

SMALLEST_PART, LARGEST_PART = 0.005, 0.6
"""[m] The largest side of what is picked from bins; what else a file holds has another unit."""


@dataclass(frozen=True, slots=True, eq=False)
class CadMesh:
    """The triangles of a file [m], and the unit that it was read in; empty if it says it itself.

    `is_assumed`: nobody said so, only one unit gives a size that parts have.
    """

    mesh: Mesh
    unit: str
    is_assumed: bool


def read_cad(
    path: Path, unit: str | None = None, *, raw: Callable[[Path], Mesh] | None = None
) -> CadMesh:
    """The triangles of an STL, OBJ, PLY, GLB or STEP file.

    Args:
        path: of the file.
        unit: mm, m or inch, for formats that do not say; None when it is not known.
        raw: reads the triangles in the file's unit; None: a process of its own does, and `read_raw`
            is for who runs in one already.

    Raises:
        FileError: not there, of another kind, too large, broken, without triangles, or it takes
            too long or too much memory; the unit is needed, or is not the format's.
    """
    kind = path.suffix.lower()
    if kind not in KINDS:
        raise FileError(path, f"is no CAD file that can be read: one of {', '.join(KINDS)}")
    if not is_file(path):
        raise FileError(path, "there is no such CAD file")
    if path.stat().st_size > LARGEST_MESH:
        raise FileError(path, f"is larger than {LARGEST_MESH / MB:g} MB")
    if unit is not None and unit not in UNITS:
        raise FileError(path, f"unit {unit!r} is not one of {', '.join(UNITS)}")
    if kind in WITH_UNIT and unit not in (None, "m"):
        raise FileError(path, f"says its unit itself, so it cannot be read in {unit}")
    read = (raw or _read_apart)(path)
    is_assumed = unit is None and kind not in WITH_UNIT
    if is_assumed:
        unit = _likely_unit(path, float(np.ptp(read.points, axis=0).max()))
    mesh = Mesh(read.points * UNITS[unit or "m"], read.triangles)
    size = float(np.ptp(mesh.points, axis=0).max())
    if not SMALLEST_PART / 10 <= size <= LARGEST_PART * 10:
        raise FileError(path, f"would be {size * 1000:.4g} mm large: is it another unit?")
    return CadMesh(mesh, "" if kind in WITH_UNIT else unit or "m", is_assumed)


def _likely_unit(path: Path, size: float) -> str:
    """The only unit in which the largest side `size` is that of a part."""
    sizes = {unit: size * scale for unit, scale in UNITS.items()}
    likely = [unit for unit, length in sizes.items() if SMALLEST_PART <= length <= LARGEST_PART]
    if len(likely) == 1:
        return likely[0]
    told = ", ".join(f"{length * 1000:.4g} mm in {unit}" for unit, length in sizes.items())
    raise FileError(path, f"does not say its unit; it would be {told} large: say which (--unit)")


def _read_apart(path: Path) -> Mesh:
    """The triangles in the file's unit, read by a process of its own."""
    arrays = apart(path, raw_triangles).arrays
    return Mesh(arrays["points"], arrays["triangles"])


def raw_triangles(path: Path) -> Answer:
    """The triangles in the file's unit as what `apart` brings back: `points` and `triangles`.

    Raises:
        FileError: as `read_cad` has it.
    """
    mesh = read_raw(path)
    return Answer(arrays={"points": mesh.points, "triangles": mesh.triangles})


def read_raw(path: Path) -> Mesh:
    """The triangles in the file's unit; for a process of its own, since readers may crash it.

    Raises:
        FileError: as `read_cad` has it.
    """
    is_step = path.suffix.lower() in STEP
    try:
        # Bounded as if it were in millimetres: the unit is looked at later.
        mesh = read_mesh(_converted(path, Path("converted.glb")) if is_step else path, 0.001)
    except FileError as error:
        raise FileError(path, error.problem) from None
    return Mesh(mesh.points * 1000, mesh.triangles)


def _converted(path: Path, target: Path) -> Path:
    """A STEP file as GLB, in metres."""
    import cascadio  # OpenCASCADE: large, and seldom needed

    try:
        cascadio.step_to_glb(
            str(path),
            str(target),
            tol_linear=FINENESS_MM,
            tol_angular=float(np.deg2rad(FINENESS_DEG)),
            use_parallel=False,
        )
    except RuntimeError as error:
        raise FileError(path, f"cannot be read as STEP: {shown(str(error))}") from None
    if not target.is_file() or target.stat().st_size == 0:
        raise FileError(path, "cannot be read as STEP, or holds no solid")
    if target.stat().st_size > 4 * LARGEST_MESH:
        raise FileError(path, f"gives more than {MOST_TRIANGLES} triangles")
    return target
