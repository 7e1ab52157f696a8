"""Meshes from CAD files that somebody else made, read in a process of its own.

The readers behind it are large, some of them C++; a broken or hostile file may make them crash,
hang, or take all the memory: then that process ends, and nothing else.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import MB, is_file, refuse_pointer
from workbench.formats.meshes.cad_bodies import (
    MESH_ENDINGS,
    ZIPPED,
    CadBodies,
    CadBody,
    bodies_of,
)
from workbench.formats.meshes.reading import LARGEST_MESH
from workbench.formats.meshes.shells import volumes_of
from workbench.model.errors import FileError
from workbench.model.geometry import Mesh
from workbench.model.messages.files import FileProblem

CAD_ENDINGS = (*MESH_ENDINGS, *ZIPPED)

LARGEST_CAD = LARGEST_MESH
"""[bytes] Of one file."""

SMALLEST_PART, LARGEST_PART = 0.005, 0.6
"""[m] The largest side of what is picked from bins; what else a file holds has another unit."""

PLASTIC = 1200.0
"""[kg/m3] What a part is taken to be made of when nobody says."""

NAMED = 6
"""Solids that a sentence names."""


class SeveralSolids(FileError):
    """A file holds several solids and nobody has chosen; `solids` are in the file's unit.

    `scale` makes metres of it.
    """

    def __init__(self, path: Path, solids: tuple[CadBody, ...], scale: float):
        self.solids, self.scale = solids, scale
        names = _names(solids)
        choose = "choose one (--solid NAME), or take them as one rigid part (--whole)"
        super().__init__(path, f"holds {len(solids)} solids, {names}: {choose}")


@dataclass(frozen=True, slots=True, eq=False)
class CadMesh:
    """The triangles of a file [m], and the unit that it was read in; empty if it says it itself.

    `is_assumed`: nobody said so, only one unit gives a size that parts have.  `taken` says in words
    what was taken of several solids; `solids` are the names of these, one of each shape.
    """

    mesh: Mesh
    unit: str
    is_assumed: bool
    taken: str = ""
    solids: tuple[str, ...] = ()


def read_cad(
    path: Path,
    unit: str | None = None,
    *,
    solid: str | None = None,
    density: float = PLASTIC,
    read: Callable[[Path], CadBodies] = bodies_of,
) -> CadMesh:
    """The triangles of a CAD file, or of the only one in a zip file.

    Args:
        path: of the file.
        unit: mm, m or inch, for formats that do not say or say it wrongly; None when not known.
        solid: name of the solid to take of several, in its own frame; None: all of them as they
            are placed, as one rigid body; empty: a file with several is refused.
        density: [kg/m3], to say what each unit would mean.
        read: reads the bodies; a process of its own does, and `read_bodies` is for who runs in one.

    Raises:
        FileError: not there, of another kind, too large, broken, without triangles, or it takes
            too long or too much memory; or the unit is needed.
        SeveralSolids: one has to be chosen.
    """
    kind = path.suffix.lower()
    if kind not in CAD_ENDINGS:
        raise FileError(path, FileProblem.NO_CAD_FILE(kinds=CAD_ENDINGS))
    if not is_file(path):
        raise FileError(path, FileProblem.MISSING())
    if path.stat().st_size > LARGEST_MESH:
        raise FileError(path, FileProblem.TOO_LARGE(most=f"{LARGEST_MESH / MB:g}"))
    refuse_pointer(path)
    if unit is not None and unit not in UNITS:
        raise FileError(path, FileProblem.UNIT(unit=repr(unit), known=UNITS))
    found = read(path)
    raw, taken = _choose_bodies(path, found, solid)
    is_assumed = unit is None and found.scale is None
    if is_assumed:
        unit = _likely_unit(path, raw, density)
    scale = found.scale if unit is None else UNITS[unit]
    mesh = Mesh(raw.points * (scale or 1.0), raw.triangles)
    size = float(np.ptp(mesh.points, axis=0).max())
    if not SMALLEST_PART / 10 <= size <= LARGEST_PART * 10:
        likely = _likely(float(np.ptp(raw.points, axis=0).max()))
        meanings = "; ".join(_meaning(raw, likely_unit, density) for likely_unit in likely)
        large = f"{size * 1000:.4g}"
        if not meanings:
            raise FileError(path, FileProblem.OTHER_UNIT(size=large))
        raise FileError(path, FileProblem.OTHER_UNIT_OF(size=large, meanings=meanings))
    solids = tuple(_shapes(found.bodies)) if len(found.bodies) > 1 else ()
    return CadMesh(mesh, unit or "", is_assumed, taken, solids)


def _choose_bodies(path: Path, found: CadBodies, solid: str | None) -> tuple[Mesh, str]:
    """The triangles in the file's unit, and what was taken of several solids."""
    bodies = found.bodies
    if solid:
        for body in bodies:
            if body.name == solid:
                return body.own, f"solid {solid} of {len(bodies)}, in its own frame"
        raise FileError(path, FileProblem.NO_SOLID(solid=repr(solid), solids=_names(bodies)))
    if solid == "" and len(bodies) > 1:
        raise SeveralSolids(path, bodies, found.scale or 1.0)
    if len(bodies) == 1:
        return bodies[0].placed, ""
    placed = [body.placed for body in bodies]
    starts = np.cumsum([0, *(len(solid_mesh.points) for solid_mesh in placed[:-1])])
    triangles = [
        solid_mesh.triangles + start for solid_mesh, start in zip(placed, starts, strict=True)
    ]
    mesh = Mesh(np.vstack([solid_mesh.points for solid_mesh in placed]), np.vstack(triangles))
    return mesh, f"{len(bodies)} solids taken as one rigid part: {_names(bodies)}"


def _shapes(solids: tuple[CadBody, ...]) -> dict[str, int]:
    """The first solid of each shape by its name, with how many are of it."""
    first: dict[tuple[float, ...], str] = {}
    times: dict[str, int] = {}
    for solid in solids:
        sides = np.ptp(solid.own.points, axis=0)
        shape = (len(solid.mesh.triangles), *np.round(sides / sides.max(), 3).tolist())
        name = first.setdefault(shape, solid.name)
        times[name] = times.get(name, 0) + 1
    return times


def _names(solids: tuple[CadBody, ...]) -> str:
    """The names of solids, those of one shape together."""
    shapes = [
        name if count == 1 else f"{name} and {count - 1} like it"
        for name, count in _shapes(solids).items()
    ]
    more = f" and {len(shapes) - NAMED} other shapes" if len(shapes) > NAMED else ""
    return ", ".join(shapes[:NAMED]) + more


def _likely_unit(path: Path, raw: Mesh, density: float) -> str:
    """The only unit in which the largest side is that of a part."""
    likely = _likely(float(np.ptp(raw.points, axis=0).max()))
    if len(likely) == 1:
        return likely[0]
    meanings = "; ".join(_meaning(raw, unit, density) for unit in likely or UNITS)
    raise FileError(path, FileProblem.NO_UNIT(meanings=meanings))


def _likely(side: float) -> list[str]:
    """The units in which a largest side is that of a part."""
    return [
        unit for unit, metres in UNITS.items() if SMALLEST_PART <= side * metres <= LARGEST_PART
    ]


def _meaning(raw: Mesh, unit: str, density: float) -> str:
    """What a unit would mean in size and mass."""
    size = " x ".join(f"{side * 1000 * UNITS[unit]:.4g}" for side in np.ptp(raw.points, axis=0))
    volume = abs(float(volumes_of(raw, np.zeros(len(raw.triangles), int)).sum()))
    return f"in {unit}: {size} mm, {mass_words(volume * UNITS[unit] ** 3 * density)}"


def mass_words(mass: float) -> str:
    """A mass [kg] for people, in g or kg."""
    return f"{mass:.4g} kg" if mass >= 1 else f"{mass * 1000:.3g} g"


def is_unusual(mesh: Mesh) -> bool:
    """Whether a part is larger or smaller than parts in bins are, so that its unit may be wrong."""
    size = float(np.ptp(mesh.points, axis=0).max())
    return not SMALLEST_PART <= size <= LARGEST_PART
