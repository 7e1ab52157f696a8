"""What can be typed: one dataclass a command, its docstrings are the help.

Nothing heavy is imported here: this is all that `--help` loads.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from workbench.cli.names import OrderName, PlannerName, StrategyName
from workbench.cli.nested_arguments import Bench, CellCommands, SessionCommands, Study


@dataclass(frozen=True, slots=True)
class Serve:
    """Serve the page of a cell.

    A cell whose controller is on this machine, where nothing answers, gets a simulated one.
    """

    cell: str = "yumi"
    """Name under robots/, or path of a cell.toml."""
    host: str = "127.0.0.1"
    """Address to listen on."""
    port: int = 8080
    """Port to listen on; 0 takes a free one."""


@dataclass(frozen=True, slots=True)
class Demo:
    """Run whole cycles without a page: scan, find, plan, approve, send to a simulated controller.

    Succeeds when the controller has reported every part of every plan as placed.
    """

    cell: str = "yumi"
    """Name under robots/, or path of a cell.toml."""
    seed: int = 0
    """Of the pile and of everything else that is random; each further cycle takes the next one."""
    cycles: int = 1
    """How many."""
    sessions: Path = Path("sessions")
    """Folder for the folder of this session."""
    speed: float = 1.0
    """Of the simulated robot: 1 is real time."""
    json: bool = False
    """Print one JSON object and nothing else."""


@dataclass(frozen=True, slots=True)
class Scan:
    """Drop parts into the bin and scan them with the simulated scanner."""

    cell: Positional[str]
    """Name under robots/, or path of a cell.toml."""
    out: Path
    """PLY file to write."""
    seed: int = 0
    """Of the pile and of the scanner's noise."""
    parts: int = 2
    """How many parts lie in the bin."""
    truth: Path | None = None
    """JSON file to write the true poses to."""


@dataclass(frozen=True, slots=True)
class Localize:
    """Find the parts in a scan."""

    cell: Positional[str]
    """Name under robots/, or path of a cell.toml."""
    scan: Path
    """PLY file, points in metres in the scanner's frame."""
    out: Path
    """JSON file of poses to write."""
    seed: int = 0
    """Of everything random."""


@dataclass(frozen=True, slots=True)
class Plan:
    """Judge every grasp, plan the pick, and prove the plan."""

    cell: Positional[str]
    """Name under robots/, or path of a cell.toml."""
    poses: Path
    """Our JSON, or a HALCON tuple file (rows of [R|t] in the world frame, millimetres)."""
    out: Path
    """JSON file of the plan to write."""
    scan: Path | None = None
    """PLY file that the poses were found in: what it shows beside the parts is kept clear of."""
    strategy: StrategyName = "auto"
    """Which arms work."""
    threshold: float | None = None
    """Distance of two parts [m] from which both arms may work; the cell's when not given."""
    planner: PlannerName | None = None
    """Of the free legs; the cell's when not given."""
    iterations: int | None = None
    """That the planner may use for each free leg; the cell's when not given."""
    order: OrderName | None = None
    """Which part is taken first: least joint travel, highest, best score, nearest to the tool,
    farthest from the walls, or the thesis' rules; the cell's when not given."""
    margin: float | None = None
    """Distance [m] kept to everything on free legs, at least the cell's."""
    metric: float | None = None
    """How much each joint counts of the one before it when planners measure, 0.05 to 1."""
    seed: int = 0
    """Of everything random."""
    part: str | None = None
    """What the poses of a HALCON file are of, when the cell has several parts."""
    json: bool = False
    """Print one JSON object and nothing else."""


@dataclass(frozen=True, slots=True)
class Explain:
    """Judge every grasp and tell why each can or cannot be taken, and what would help."""

    cell: Positional[str]
    """Name under robots/, or path of a cell.toml."""
    poses: Path
    """Our JSON, or a HALCON tuple file (rows of [R|t] in the world frame, millimetres)."""
    scan: Path | None = None
    """PLY file that the poses were found in: what it shows beside the parts is in the way, too."""
    seed: int = 0
    """Of everything random."""
    part: str | None = None
    """What the poses of a HALCON file are of, when the cell has several parts."""
    json: bool = False
    """Print one JSON object and nothing else."""


@dataclass(frozen=True, slots=True)
class Verify:
    """Prove a plan again, from its file and the cell alone."""

    plan: Positional[Path]
    """JSON file of a plan."""
    cell: str | None = None
    """Name under robots/, or path of a cell.toml; the name in the plan when not given."""
    json: bool = False
    """Print one JSON object and nothing else."""


@dataclass(frozen=True, slots=True)
class Send:
    """Prove a plan, approve it by name, and send it to a robot controller."""

    plan: Positional[Path]
    """JSON file of a plan."""
    host: str
    """Address of the controller."""
    port: int
    """Port on which it takes motion."""
    approve_as: str
    """Name of the person who has looked at the plan and answers for it."""
    cell: str | None = None
    """Name under robots/, or path of a cell.toml; the name in the plan when not given."""
    json: bool = False
    """Print one JSON object and nothing else."""


@dataclass(frozen=True, slots=True)
class Controller:
    """Run the simulated robot controller until it is interrupted."""

    cell: str = "yumi"
    """Name under robots/, or path of a cell.toml."""
    host: str = "127.0.0.1"
    """Address to listen on."""
    port: int = 1025
    """Port for motion; 0 takes a free one."""
    state_port: int | None = None
    """Port for reports of its state; the next one when not given, 0 takes a free one."""
    speed: float = 1.0
    """Of the robot: 1 is real time."""
    record: Path | None = None
    """File to which every configuration that arrives is appended, one JSON object a line."""
    until_eof: bool = False
    """End when standard input ends, too."""
    json: bool = False
    """Print one JSON object, the ports, and nothing else."""


@dataclass(frozen=True, slots=True)
class ExportWorld:
    """Write the scene of every phase as a Klamp't world, for checking with other tools."""

    cell: Positional[str]
    """Name under robots/, or path of a cell.toml."""
    out: Path
    """Folder to write to; made when missing."""
    plan: Path | None = None
    """JSON file of a plan, for its parts and phases; the bare cell when not given."""


@dataclass(frozen=True, slots=True)
class Import:
    """Make a cell from another program's world: robot, bin, and the rest as fixtures.

    As `cell new`, for a world file; a start to change, not a cell to trust.
    """

    program: Positional[Literal["klampt"]]
    """That has written the file."""
    world: Positional[Path]
    """World file (.xml) with one robot (.rob or .urdf), its files beside it."""
    out: Path
    """Folder to write to. It must not be there yet."""
    flange: tuple[str, ...] = ()
    """Links that carry the tools, one for each arm, the right arm's first; found by themselves
    when not given. What hangs on them is left out: tools stand in the cell file."""
    bin: str | None = None
    """Name of the thing that is the bin; otherwise one is put where the arms reach it."""
    tool: Literal["gripper", "suction"] = "gripper"
    """What the arms carry to begin with."""
    part: str = "keyed_cylinder"
    """Name under parts/, or path of a part's folder."""
    json: bool = False
    """Print one JSON object and nothing else."""


Arguments = (
    Annotated[Serve, subcommand("serve")]
    | Annotated[Demo, subcommand("demo")]
    | Annotated[Scan, subcommand("scan")]
    | Annotated[Localize, subcommand("localize")]
    | Annotated[Plan, subcommand("plan")]
    | Annotated[Explain, subcommand("explain")]
    | Annotated[Verify, subcommand("verify")]
    | Annotated[Send, subcommand("send")]
    | Annotated[Controller, subcommand("controller")]
    | Annotated[ExportWorld, subcommand("export-world")]
    | Annotated[Bench, subcommand("bench")]
    | Annotated[Study, subcommand("study")]
    | Annotated[CellCommands, subcommand("cell")]
    | Annotated[Import, subcommand("import")]
    | Annotated[SessionCommands, subcommand("session")]
)
