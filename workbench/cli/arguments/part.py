"""What can be typed after `workbench part` and `workbench grasps`; the docstrings are the help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import CellName, Json, Maybe, PartName


@dataclass(frozen=True, slots=True)
class PartImport:
    """Make a part from a CAD file: STL, OBJ, PLY, GLB, GLTF, 3MF, DAE, STEP, or a zip of one.

    Writes a folder with part.toml, the mesh in millimetres, and a grasps.toml by which
    plans search grips.
    """

    file: Positional[Path]
    """The CAD file."""
    name: Maybe[str] = None
    """Name of the part and of its folder, which must not be there yet; that of the file when not
    given."""
    unit: Maybe[Literal["mm", "m", "inch"]] = None
    """Unit of an STL, OBJ or PLY file, needed when its size leaves a doubt; or of a GLB, GLTF, 3MF
    or DAE file that states another than it has."""
    solid: Maybe[str] = None
    """Name of the solid to take of a file with several; it keeps its own frame."""
    whole: bool = False
    """Take several solids as one rigid part, placed as they are in the file."""
    mass_g: Maybe[float] = None
    """Mass of the part; from its volume when not given."""
    density: float = 1200.0
    """[kg/m3] Used for the mass: plastic 1200, aluminium 2700, steel 7850."""
    into: Path = Path("parts")
    """Folder of parts."""
    repair: bool = False
    """Mend a surface that is not closed: slits, small holes, turned triangles, sheets, crumbs."""
    open: bool = False
    """Take a surface that cannot be closed as it is, for a part that is only to be found."""
    accept_symmetry: bool = False
    """State the symmetry that was found; otherwise it is a comment, for you to confirm."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class PartFromScans:
    """Merge scans of one part from known poses into a closed model, for `part import`.

    The folder holds the scans and views.toml, which says where each was taken from; see
    docs/new_part.md.  What no scan shows is closed, and its share of the surface is reported.
    """

    folder: Positional[Path]
    """Holds views.toml and the scans."""
    out: Path
    """PLY or STL file to write, in millimetres, in the frame of the poses."""
    voxel_mm: Maybe[float] = None
    """Width of the voxels; that of the scans' pixels when not given."""
    tolerance_mm: float = 0.2
    """By so much the surface may change for the sake of fewer triangles."""
    as_given: bool = False
    """Take the poses as they are; otherwise they are improved by what several scans show, and a
    scan that does not fit the others is refused."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class PartCheck:
    """Look whether a part is fit for picking: mesh, pieces, symmetry, grasps, poses covered.

    Ends with 3 when something speaks against it.
    """

    part: Positional[PartName]
    cell: str = "yumi"
    """Whose tools, bin and arms are used: name under robots/, or path of a cell.toml."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class PartList:
    """List the parts that are found by name."""

    json: Json = False


@dataclass(frozen=True, slots=True)
class PartCommands:
    """Make parts from CAD files or scans and look whether they are fit for picking."""

    what: (
        Annotated[PartImport, subcommand("import")]
        | Annotated[PartFromScans, subcommand("from-scans")]
        | Annotated[PartCheck, subcommand("check")]
        | Annotated[PartList, subcommand("list")]
    )


@dataclass(frozen=True, slots=True)
class Grasps:
    """Suggest grasps that the shape of a part offers to a tool, the best first.

    None is like one that the part has already.
    """

    what: Positional[Literal["suggest"]]
    """What to do: suggest."""
    part: Positional[PartName]
    cell: CellName = "yumi"
    arm: Maybe[str] = None
    """Whose tool; the cell's first arm when not given."""
    most: int = 20
    """How many grasps."""
    seed: int = 0
    """Seed of the samples on the surface."""
    add: bool = False
    """Write them into the part's grasps.toml, behind what stands there."""
    fill: bool = False
    """Make the whole library with which the cell's bin is emptied, and write it behind what stands
    there: families of grasps, chosen by what they add in simulated piles.  Takes about a minute."""
    json: Json = False
