"""What can be typed after `workbench part` and `workbench grasps`; the docstrings are the help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import CellName, Json, Maybe, PartName


@dataclass(frozen=True, slots=True)
class PartImport:
    """Make a part from a CAD file: STL, OBJ, PLY, GLB or STEP.

    Writes a folder with part.toml, the mesh in millimetres, and a grasps.toml to be filled.
    """

    file: Positional[Path]
    """The CAD file."""
    name: str
    """Name of the part and of its folder, which must not be there yet."""
    unit: Maybe[Literal["mm", "m", "inch"]] = None
    """Unit of an STL, OBJ or PLY file; needed when its size leaves a doubt."""
    mass_g: Maybe[float] = None
    """Mass of the part; from its volume when not given."""
    density: float = 1200.0
    """[kg/m3] Used for the mass: plastic 1200, aluminium 2700, steel 7850."""
    into: Path = Path("parts")
    """Folder of parts."""
    repair: bool = False
    """Mend a surface that is not closed: small holes, turned triangles, crumbs."""
    accept_symmetry: bool = False
    """State the symmetry that was found; otherwise it is a comment, for you to confirm."""
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
    """Make parts from CAD files and look whether they are fit for picking."""

    what: (
        Annotated[PartImport, subcommand("import")]
        | Annotated[PartCheck, subcommand("check")]
        | Annotated[PartList, subcommand("list")]
    )


@dataclass(frozen=True, slots=True)
class Grasps:
    """Suggest grasps that the shape of a part offers to a tool, the best first.

    None is like one that the part has already.
    """

    what: Positional[Literal["suggest"]]
    """What to do."""
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
    json: Json = False
