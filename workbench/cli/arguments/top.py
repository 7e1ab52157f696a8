"""What can be typed: one dataclass a command, its docstrings are the help.

Nothing heavy is imported here: this is all that `--help` loads.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, arg, subcommand

from workbench.cli.arguments.access import USERS, UserCommands
from workbench.cli.arguments.bench import BenchCommands
from workbench.cli.arguments.cell import CellCommands, PoseFormatName
from workbench.cli.arguments.names import (
    BinName,
    CellName,
    CellOfPlan,
    Json,
    ListenOn,
    Maybe,
    OrderName,
    PartOfPoses,
    RecipeNumber,
    Seed,
    UsersFile,
    ViewName,
)
from workbench.cli.arguments.part import Grasps, PartCommands
from workbench.cli.arguments.plc import OpcUaCommands
from workbench.cli.arguments.proving import Prove, Verify
from workbench.cli.arguments.rapid import RapidCommands
from workbench.cli.arguments.scanner import ScannerCommands
from workbench.cli.arguments.serving import Serve
from workbench.cli.arguments.session import SessionCommands
from workbench.cli.arguments.studies import Study
from workbench.cli.arguments.upkeep import (
    Acceptance,
    Compile,
    Doctor,
    Evidence,
    Plugins,
    StatisticsArguments,
)


@dataclass(frozen=True, slots=True)
class Demo:
    """Run whole cycles without a page: scan, find, plan, approve, send to a simulated controller.

    Succeeds when the controller has reported every part of every plan as placed.
    """

    cell: CellName = "yumi"
    recipe: RecipeNumber = 0
    bin: BinName = ""
    seed: int = 0
    """Seed of the pile and of all else that is random; each further cycle takes the next one."""
    cycles: int = 1
    """How many cycles."""
    sessions: Path = Path("sessions")
    """Folder for the folder of this session."""
    speed: float = 1.0
    """Speed of the simulated robot: 1 is real time."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class ScanArguments:
    """Drop parts into the bin and scan them with the simulated scanner."""

    cell: Positional[CellName]
    out: Path
    """PLY file to write."""
    seed: int = 0
    """Seed of the pile and of the scanner's noise."""
    parts: int = 2
    """How many parts lie in the bin."""
    part: str = ""
    """Which part of the cell; the first one unless stated otherwise; all: of each in turn."""
    truth: Maybe[Path] = None
    """JSON file to write the true poses to."""
    recipe: RecipeNumber = 0
    bin: BinName = ""
    view: ViewName = ""


@dataclass(frozen=True, slots=True)
class Localize:
    """Find the parts in a scan."""

    cell: Positional[CellName]
    scan: Path
    """PLY or PCD file in the scanner's frame, with the cell's unit and axes of clouds."""
    out: Path
    """JSON file of poses to write."""
    rejected: Annotated[bool, arg(aliases=["--discarded"])] = False
    """Tell also which poses were hypotheses and rejected, and why."""
    seed: Seed = 0
    recipe: RecipeNumber = 0
    bin: BinName = ""
    view: ViewName = ""
    detail: float = 1.0
    """How fine the scan is searched, 0.3 to 2; finer sees smaller features and takes longer."""
    least_score: float = 0.0
    """Parts with a lower score are left out, 0 to 1."""
    scale: tuple[str, ...] = ()
    """Parts that are larger or smaller than their CAD files, each PART=SIZE: pipe=0.92."""
    learn: bool = False
    """Search until the sizes fit the scan, and write them as `scale` into each part.toml. A surface
    that lies off the CAD file is written as `offset_mm`."""
    overlay: Maybe[Path] = None
    """PNG file to write: the scan as its scanner sees it, with what was found drawn over it."""


@dataclass(frozen=True, slots=True)
class Calibrate:
    """Find out where the scanner is, from scans of a three-ball plate.

    The robot holds the plate, or carries the scanner and the plate stands. The folder holds scans
    and calibration.toml, which states where the arm stood for each; see docs/calibration.md. Pairs
    of poses of another program are read, too. Poses that do not agree with the others are named and
    left out.
    """

    cell: Positional[CellName]
    poses: Path
    """Folder with the scans and calibration.toml; or pairs of a flange pose and a target pose:
    CSV, YAML of OpenCV, MoveIt or easy_handeye, or a folder of Zivid's."""
    in_hand: bool = False
    """The robot holds the scanner, and the target stands. Only for pairs; scans go by the cell."""
    unit: Literal["m", "mm"] = "m"
    """Unit of lengths in a file of pairs."""
    format: Maybe[PoseFormatName] = None
    """Whose pendant shows the flange's pose as the first columns of a CSV file have it."""
    write: Maybe[Path] = None
    """YAML file to write the scanner's pose to, for another program."""
    style: Literal["opencv", "ros", "zivid"] = "opencv"
    """Whose form that file has."""
    save: bool = False
    """Write the scanner's pose into the cell file, with date, author and accuracy."""
    by: str = ""
    """Name of the person who answers for it; needed to save."""
    simulate: bool = False
    """Make the folder first: scans by the simulated scanner, hanging some 20 mm and 2 degrees from
    where the cell has it."""
    count: int = 8
    """How many poses to simulate."""
    seed: int = 0
    """Seed of the simulated poses and noise."""
    next: bool = False
    """Say, too, which pose to take next: the one that lessens errors at the bin most."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class PlanArguments:
    """Judge every grasp, plan the pick, and prove it; or --view, --stir, --tool, --drop-back."""

    cell: Positional[CellName]
    out: Path
    """JSON file of the plan to write."""
    poses: Maybe[Path] = None
    """Our JSON, or a HALCON tuple file (rows of [R|t] in the world frame, millimetres)."""
    view: Maybe[str] = None
    """Name of the view from which the scanner on an arm scans; without --poses the path there is
    planned, or with the word home the path back."""
    start: str = "home"
    """Where the path to --view begins: home, or the name of another view."""
    stir: bool = False
    """Plan how an arm stirs the parts at --poses with its hand, instead of a pick."""
    tool: Maybe[str] = None
    """Plan how an arm changes its tool for the one of that name; --strategy names the arm where
    several have a slot for it."""
    drop_back: Maybe[Literal["one", "two", "unknown"]] = None
    """Plan how an arm drops back what it holds: one part, two parts, or unknown;
    --strategy names the arm, --joints where it stands."""
    joints: Maybe[str] = None
    """Axes of the arm [deg, mm] as its controller shows them, with commas between; home when not
    given."""
    scan: Maybe[Path] = None
    """PLY or PCD file the poses were found in: what it shows beside the parts is kept clear of."""
    strategy: Maybe[str] = None
    """Which arms work: auto, alternated, coordinated, both, or one arm by its name; that of the
    recipe when not given, or auto."""
    threshold: Maybe[float] = None
    """Distance of two parts [m] from which both arms may work; the cell's when not given."""
    planner: Maybe[str] = None
    """Planner of the free legs, see `workbench plugins`; the cell's when not given."""
    iterations: Maybe[int] = None
    """How many iterations the planner may use for each free leg; the cell's when not given."""
    order: Maybe[OrderName] = None
    """Which part is taken first: least time, highest, best score, nearest to the tool,
    farthest from the walls, or the thesis' rules; the cell's when not given."""
    margin: Maybe[float] = None
    """Distance [m] kept to everything on free legs, at least the cell's."""
    metric: Maybe[float] = None
    """How much each joint counts of the one before it when planners measure, 0.05 to 1."""
    picks: Maybe[int] = None
    """Plans in a row at most, each proven in the scene that those before leave, while no part that
    stays may have moved; the second goes to OUT-2.json, and so on; the cell's when not given."""
    protocol: Maybe[str] = None
    """Robot link that it is meant for, see `workbench plugins`; that of the cell when not given."""
    seed: Seed = 0
    recipe: RecipeNumber = 0
    bin: BinName = ""
    part: PartOfPoses = None
    json: Json = False


@dataclass(frozen=True, slots=True)
class Explain:
    """Judge every grasp and tell why each can or cannot be taken, and what would help."""

    cell: Positional[CellName]
    poses: Path
    """Our JSON, or a HALCON tuple file (rows of [R|t] in the world frame, millimetres)."""
    scan: Maybe[Path] = None
    """PLY or PCD file the poses were found in: what it shows beside the parts is in the way."""
    recipe: RecipeNumber = 0
    stands: tuple[str, ...] = ()
    """Kinds of the recipe's assembly that stand at their places already, exactly unless a nest
    states its error."""
    seed: Seed = 0
    part: PartOfPoses = None
    json: bool = False
    """Print one JSON object and nothing else: in it `detection` counts from 0, `parts` from 1."""


@dataclass(frozen=True, slots=True)
class SendArguments:
    """Prove a plan, approve it by its digest, and send it to a robot controller.

    What there is to know of the plan is printed first.  At a terminal the digest is asked for; in a
    script the command is given once to read, and again with --digest.  A plan goes out once.  Plans
    made in a row go out by one approval, one after the other, until anything is in doubt.
    """

    plan: Positional[Path]
    """JSON file of a plan."""
    host: str
    """Address of the controller."""
    port: int
    """Port on which it takes motion."""
    approve_as: str
    """Name of the person who has checked the plan and answers for it."""
    row: Positional[tuple[Path, ...]] = ()
    """Files of the plans that follow it in a row, in the order in which plan --picks wrote them."""
    digest: Maybe[str] = None
    """The digest of the plan or row, as it was printed before: 12 characters of it, or more."""
    scan: Maybe[Path] = None
    """PLY or PCD file of the scan that the plan was made for, for the proof."""
    poses: Maybe[Path] = None
    """Our JSON or a HALCON tuple file of all parts known to be in the bin, for the proof."""
    part: PartOfPoses = None
    state_port: Maybe[int] = None
    """Port on which the controller reports its state; the next one when not given."""
    record: Path = Path("approvals")
    """Folder with the record of who has approved which plan."""
    cell: CellOfPlan = None
    protocol: Maybe[str] = None
    """Robot link to the controller, see `workbench plugins`; that of the cell when not given."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class ControllerArguments:
    """Run the simulated robot controller until it is interrupted; it speaks both protocols."""

    cell: CellName = "yumi"
    host: ListenOn = "127.0.0.1"
    port: int = 1025
    """Port for motion; 0 takes a free one."""
    state_port: Maybe[int] = None
    """Port for reports of its state; the next one when not given, 0 takes a free one."""
    speed: float = 1.0
    """Speed of the robot: 1 is real time."""
    record: Maybe[Path] = None
    """File to which every configuration that arrives is appended, one JSON object a line."""
    trace: Maybe[Path] = None
    """File to which every state that the arms go through is appended."""
    fault: tuple[str, ...] = ()
    """What goes wrong, each once: NAME or NAME:n, as in `drop:3 garbage:9`; n counts messages."""
    rapid: Maybe[Path] = None
    """Folder of RAPID modules that are run instead, as robots/yumi/rapid; it reports no state."""
    home_after: Maybe[float] = None
    """Seconds after which arms that were left somewhere go home; they stay when not given."""
    before_view: bool = False
    """Begin with the arm that carries the scanner at its home_deg, not at the view."""
    until_eof: bool = False
    """End when standard input ends, too."""
    json: bool = False
    """Print one JSON object, the ports, and nothing else."""


@dataclass(frozen=True, slots=True)
class ExportWorld:
    """Write the scene of every phase as a Klamp't world, for checking with other tools."""

    cell: Positional[CellName]
    out: Path
    """Folder to write to; made when missing."""
    plan: Maybe[Path] = None
    """JSON file of a plan, for its parts and phases; the bare cell when not given."""


@dataclass(frozen=True, slots=True)
class Backup:
    """Write the cells and parts below the working directory into one zip file."""

    out: Positional[Path]
    """Zip file to write."""
    with_sessions: bool = False
    """The sessions as well; they are large."""
    with_users: bool = False
    """The users as well, with the hashes of their passwords: keep the file to yourself."""
    users: UsersFile = USERS


@dataclass(frozen=True, slots=True)
class Restore:
    """Put back what a backup holds, once every cell, part and session in it could be read.

    What has the same name is replaced, except for sessions, which stay; all else is left alone.
    """

    file: Positional[Path]
    """Zip file that `backup` has written."""
    dry_run: bool = False
    """Only tell what would be new and what replaced."""
    users: Path = USERS
    """File of users, for those in the backup who are not there yet."""


@dataclass(frozen=True, slots=True)
class Import:
    """Make a cell from another program's world: robot, bin, and the rest as fixtures.

    As `cell new`, for a world file; a start to change, not a cell to trust.
    """

    program: Positional[Literal["klampt"]]
    """The program that has written the file."""
    world: Positional[Path]
    """World file (.xml) with one robot (.rob or .urdf), its files beside it."""
    out: Path
    """Folder to write to. It must not be there yet."""
    flange: tuple[str, ...] = ()
    """Links that carry the tools, one for each arm, the right arm's first; found by themselves
    when not given. What hangs on them is left out: tools stand in the cell file."""
    bin: Maybe[str] = None
    """Name of the thing that is the bin; otherwise one is put where the arms reach it."""
    tool: Literal["gripper", "suction"] = "gripper"
    """What the arms carry to begin with."""
    part: Maybe[str] = None
    """Name under parts/, or path of a part's folder; when not given keyed_cylinder, or puck where
    no tool has fingers."""
    json: Json = False


Arguments = (
    Annotated[Serve, subcommand("serve")]
    | Annotated[Demo, subcommand("demo")]
    | Annotated[Plugins, subcommand("plugins")]
    | Annotated[ScanArguments, subcommand("scan")]
    | Annotated[Localize, subcommand("localize")]
    | Annotated[Calibrate, subcommand("calibrate")]
    | Annotated[ScannerCommands, subcommand("scanner")]
    | Annotated[PlanArguments, subcommand("plan")]
    | Annotated[Explain, subcommand("explain")]
    | Annotated[Prove, subcommand("prove")]
    | Annotated[Verify, subcommand("verify")]
    | Annotated[SendArguments, subcommand("send")]
    | Annotated[ControllerArguments, subcommand("controller")]
    | Annotated[RapidCommands, subcommand("rapid")]
    | Annotated[ExportWorld, subcommand("export-world")]
    | Annotated[BenchCommands, subcommand("bench")]
    | Annotated[Study, subcommand("study")]
    | Annotated[CellCommands, subcommand("cell")]
    | Annotated[PartCommands, subcommand("part")]
    | Annotated[Grasps, subcommand("grasps")]
    | Annotated[Import, subcommand("import")]
    | Annotated[SessionCommands, subcommand("session")]
    | Annotated[UserCommands, subcommand("user")]
    | Annotated[OpcUaCommands, subcommand("opcua")]
    | Annotated[StatisticsArguments, subcommand("statistics")]
    | Annotated[Evidence, subcommand("evidence")]
    | Annotated[Acceptance, subcommand("acceptance")]
    | Annotated[Backup, subcommand("backup")]
    | Annotated[Restore, subcommand("restore")]
    | Annotated[Compile, subcommand("compile")]
    | Annotated[Doctor, subcommand("doctor")]
)
