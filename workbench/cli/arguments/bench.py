"""What can be typed after `workbench bench`, and its help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import (
    CellName,
    FirstSeed,
    Json,
    Maybe,
    Piles,
    Seed,
)


@dataclass(frozen=True, slots=True)
class BenchPlanners:
    """Compare the planners: one arm, from one configuration to random tool poses in its bin.

    The bin is empty.  Poses that the arm cannot reach or take up without touching something are
    counted apart.  Times include shortening, rounding and the last check.
    """

    cell: str = "tx2_90"
    """Name under robots/, or path of a cell.toml; its first arm moves."""
    targets: int = 200
    """How many tool poses."""
    planners: tuple[str, ...] = ("rrt", "rrtconnect", "sbl")
    """Which planners; birrt is the thesis' name for rrtconnect."""
    iterations: tuple[int, ...] = (2, 5, 10, 20, 50, 100, 500)
    """Iterations allowed; each is a column of the comparison."""
    start: Literal["home", "zero"] = "zero"
    """Where the arm starts: at home, or with all its axes at zero (the TX2-90 stands upright)."""
    against: Maybe[Literal["klampt"]] = None
    """Give the same start and goals to Klamp't as well (extra `bench`)."""
    seconds: float = 5.0
    """How long a plan by Klamp't may take [s]."""
    seed: int = 0
    """Seed of the targets."""
    plot: Maybe[Path] = None
    """HTML file to draw the comparison in."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchMotion:
    """Plan motion problems from files as a free leg of a plan is: shortened, rounded and checked.

    Problems that start or end in something are counted apart.  Times are processor time, from
    two configurations to checked waypoints; robot and obstacles are made ready before.
    """

    folder: Positional[Path]
    """Folder with sets of problems in JSON and the robot's URDF and SRDF beside them, or with a
    folder of these for each robot."""
    robot: Maybe[str] = None
    """Whose problems; all when not given."""
    planner: str = "rrtconnect"
    """Which planner."""
    against: Maybe[Literal["ompl", "klampt"]] = None
    """Give the same problems to OMPL's RRT-Connect as well, over the same check of edges; or to
    Klamp't's SBL (extra `bench`), which checks states by itself and shortens nothing."""
    iterations: int = 10000
    """Iterations that a search may take."""
    margin: float = 0.0
    """Distance to keep from everything [m]."""
    seconds: float = 30.0
    """How long a plan may take [s]."""
    seed: Seed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchBothArms:
    """Plan all joints of two arms as one, past an empty bin, by our planner and by OMPL's.

    Each tool begins on one side of the bin and ends on the other.  Times are processor time, from
    two configurations to checked waypoints; both planners ask the same check of edges.
    """

    cell: CellName = "yumi"
    pairs: int = 200
    """How many pairs of a start and a goal."""
    seconds: float = 30.0
    """How much processor time a plan may take [s]."""
    seed: FirstSeed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchPick:
    """Plan seeded piles of known poses and tell how long each stage took."""

    cell: CellName = "yumi"
    scenes: Piles = 40
    parts: int = 2
    """How many parts in each."""
    strategy: str = "auto"
    """Which arms work: auto, alternated, coordinated, both, or one arm by its name."""
    planner: Maybe[str] = None
    """Planner of the free legs; the cell's when not given."""
    seed: FirstSeed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchSoak:
    """Run very many whole cycles against a simulated controller: none may be lost, nothing grow.

    Ends with 1 when a cycle was lost or the journal is not whole.
    """

    cell: CellName = "yumi"
    cycles: int = 1000
    """How many cycles."""
    piles: int = 20
    """How many different piles, again and again: the scan of each is kept once."""
    speed: float = 1000.0
    """Speed of the simulated robot: 1 is real time."""
    seed: FirstSeed = 0
    recall: bool = False
    """Run each task once and take its result from memory when it is asked again: very many cycles
    of rules, journal and robot link in a short time."""
    ahead: bool = False
    """Scan, find and plan beside the motion of the cycle before, by a scanner that sees as well
    while arms move."""
    rapid: Maybe[Path] = None
    """Folder of RAPID modules that the controller runs, as robots/yumi/rapid."""
    sessions: Path = Path("sessions")
    """Folder for the folder of this session."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchPage:
    """Serve a page, have many browsers look at a plan while one scrubs it, and tell how it holds.

    Ends with 1 when a value that was typed became no command.
    """

    cell: CellName = "yumi"
    browsers: int = 10
    """How many browsers; they read everything and draw nothing."""
    seconds: float = 300.0
    """How long the page is loaded [s]."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchStalls:
    """Serve a page, do with it what it can do, and tell what held its process up, and for how long.

    The robot link is in that process. Only an error fails: figures differ between machines.
    """

    cell: CellName = "yumi"
    triangles: int = 950_000
    """Of the CAD files that are sent; the page takes 1,000,000."""
    points: int = 4_000_000
    """Of the scan that is sent; a file may have 50 MB."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchScale:
    """Measure how costs grow with the library, the bin, the session and the browsers.

    An exponent of 1 between two sizes is linear growth.  Times of browsers are on the clock, all
    others processor time.
    """

    of: tuple[Literal["library", "bin", "session", "browsers"], ...] = (
        "library",
        "bin",
        "session",
        "browsers",
    )
    """What grows."""
    kinds: tuple[int, ...] = (10, 50, 200)
    """Kinds of parts that the cell knows; four parts lie in the bin."""
    parts: tuple[int, ...] = (15, 30, 60)
    """Parts in the bin."""
    entries: tuple[int, ...] = (1_000, 10_000, 100_000)
    """Entries of the session's journal."""
    browsers: tuple[int, ...] = (1, 5, 20)
    """Browsers that come to a page which one browser has led to a plan."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchShort:
    """Run the short form of every benchmark and set it beside the figures of last time.

    Ends with 1 when one of them could not be run; times differ between machines and fail nothing.
    """

    against: Path = Path("docs/benchmarks.json")
    """JSON file of figures."""
    keep: bool = False
    """Write the figures there."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class BenchCommands:
    """Measure how fast and how reliable planning is, and how the page holds."""

    what: (
        Annotated[BenchPlanners, subcommand("planners")]
        | Annotated[BenchMotion, subcommand("motion")]
        | Annotated[BenchBothArms, subcommand("both-arms")]
        | Annotated[BenchPick, subcommand("pick")]
        | Annotated[BenchSoak, subcommand("soak")]
        | Annotated[BenchPage, subcommand("page")]
        | Annotated[BenchStalls, subcommand("stalls")]
        | Annotated[BenchScale, subcommand("scale")]
        | Annotated[BenchShort, subcommand("short")]
    )
