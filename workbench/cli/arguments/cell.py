"""What can be typed after `workbench cell`, and its help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import (
    CellName,
    Json,
    Maybe,
)


@dataclass(frozen=True, slots=True)
class CellCheck:
    """Look whether a cell can work: limits, home, reach into the bin and to the places.

    Ends with 3 when something speaks against the cell.
    """

    cell: Positional[CellName]
    json: Json = False
    picture: Maybe[Path] = None
    """HTML file to write: how each tool stands on its arm, with the axes of the flange."""


@dataclass(frozen=True, slots=True)
class CellShow:
    """Tell what a cell is made of: arms, bin, fixtures, parts, scanner, controller, policy."""

    cell: Positional[CellName]


@dataclass(frozen=True, slots=True)
class CellNew:
    """Make a first cell around a robot from its URDF: a start to change, not a cell to trust.

    Meshes that are checked become convex pieces; pairs of links that need no check are found by
    trying; a bin, a table, a scanner, homes and places are put where the arms reach them.
    """

    name: Positional[str]
    """Name of the cell and of its folder."""
    urdf: Path
    """URDF, xacro or Klamp't robot (.rob), with its meshes beside or above it; or a Klamp't world
    (.xml) with one robot, whose things become fixtures."""
    out: Maybe[Path] = None
    """Folder to write to; robots/NAME when not given. It must not be there yet."""
    flange: tuple[str, ...] = ()
    """Links that carry the tools, one for each arm, the right arm's first; found by themselves
    when not given. What hangs on them is no part of the robot: tools stand in the cell file."""
    bin: Maybe[str] = None
    """Name of the thing in a Klamp't world that is the bin; otherwise one is put where the arms
    reach it."""
    tool: str = ""
    """What the arms carry to begin with: gripper, suction, or URDF or xacro of a tool; when not
    given the hand that hangs on the flange in the robot's own file, or else gripper."""
    part: Maybe[str] = None
    """Name under parts/, or path of a part's folder; when not given keyed_cylinder, or puck where
    no tool has fingers."""
    position_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Where the URDF's root link stands in the world."""
    mesh_unit: Maybe[Literal["m", "mm"]] = None
    """Unit of meshes of which neither the URDF nor their own file says it; metres when not given,
    or millimetres where metres would make them larger than any robot."""
    xacro: tuple[str, ...] = ()
    """Arguments for a xacro file, each NAME:=VALUE."""
    package_path: tuple[Path, ...] = ()
    """Folders with packages that the file names; those around it are found without."""
    fix: tuple[str, ...] = ()
    """Joints that stand still, each JOINT=VALUE in degrees or mm: torsos, lifts, rails."""
    tolerance_mm: float = 5.0
    """By how much a convex piece may be larger than its mesh before it is divided."""
    pieces: int = 32
    """How many pieces one mesh may be divided into."""
    json: Json = False


PoseFormatName = Literal[
    "abb", "denso", "fanuc", "kawasaki", "kuka", "mitsubishi", "staubli", "ur", "yaskawa"
]


@dataclass(frozen=True, slots=True)
class CellPose:
    """Print flange and TCP of an arm as the pendant of a maker shows them, to compare.

    With --shown, what the pendant shows is compared, and what would explain a difference is
    named: the zero of a joint, the robot's base, the tool.  Ends with 3 when they differ.
    """

    cell: Positional[CellName]
    joints_deg: Maybe[tuple[float, ...]] = None
    """Joints as the controller shows them, axis 1 first, degrees or mm; home when not given."""
    arm: Maybe[str] = None
    """Which arm; the first one when not given."""
    format: PoseFormatName = "abb"
    """Whose pendant it is."""
    shown: Maybe[tuple[float, ...]] = None
    """The pose on the pendant: X, Y, Z in mm, then the numbers of the orientation."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class CellTool:
    """Have an arm carry a gripper from its URDF or xacro: body, two fingers, stroke and TCP.

    The root link is put onto the flange, its z out of the arm.  What is written stands in the cell
    file, to be changed there or in the tab Cell.
    """

    cell: Positional[CellName]
    gripper: Positional[Path]
    """URDF or xacro, in a folder with its meshes or below one."""
    name: str = ""
    """Name of the tool; that of the robot in the file when not given."""
    arm: tuple[str, ...] = ()
    """Which arms; all when not given."""
    widest_mm: Maybe[float] = None
    """It is never opened further; where not given as far as tips of a linkage come forward by no
    more than 5 mm as they close."""
    mesh_unit: Maybe[Literal["m", "mm"]] = None
    """Unit of meshes of which neither the URDF nor their own file says it."""
    xacro: tuple[str, ...] = ()
    """Arguments for a xacro file, each NAME:=VALUE."""
    package_path: tuple[Path, ...] = ()
    """Folders with packages that the file names; those around it are found without."""


@dataclass(frozen=True, slots=True)
class CellSchema:
    """Print the JSON Schema of cell files, for editors that check while one types."""


@dataclass(frozen=True, slots=True)
class CellCommands:
    """Make a cell, look at it, and see whether it can work."""

    what: (
        Annotated[CellNew, subcommand("new")]
        | Annotated[CellCheck, subcommand("check")]
        | Annotated[CellShow, subcommand("show")]
        | Annotated[CellPose, subcommand("pose")]
        | Annotated[CellTool, subcommand("tool")]
        | Annotated[CellSchema, subcommand("schema")]
    )
