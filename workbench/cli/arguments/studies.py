"""What can be typed after `workbench study`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import (
    BinName,
    CellName,
    FirstSeed,
    Json,
    Maybe,
    Piles,
    RecipeNumber,
)

Noise = Literal[
    "fine", "rough", "structured_light", "stereo", "time_of_flight", "laser_line", "moving"
]
"""Builds of scanner."""


EVERY_BUILD: tuple[Noise, ...] = (
    "fine",
    "rough",
    "structured_light",
    "stereo",
    "time_of_flight",
    "laser_line",
)


@dataclass(frozen=True, slots=True)
class StudyLocalization:
    """Find the parts of seeded piles in simulated scans and compare with where they lie.

    Or search again in scans that were kept with what people said of them: it ends with 3 when a
    part that was right is not now, or more is wrong; and with 2 when a case cannot be used.
    """

    cell: CellName = "yumi"
    scenes: int = 10
    """How many piles for each part, count and noise."""
    parts: tuple[str, ...] = ("keyed_cylinder", "bracket", "bolt")
    """Names under parts/, or paths, one after the other; a+b for both in one pile."""
    counts: tuple[int, ...] = (2, 8)
    """Parts in a pile."""
    noise: tuple[Noise, ...] = ("fine", "rough")
    """Builds of scanner: that of the cell, one with twice its noise and many flaws, other kinds."""
    raised: float = 0.0
    """All that is seen lies this much higher than it does [mm]: a scanner calibrated badly."""
    tilted: float = 0.0
    """And is turned by this about the bin's x axis [degrees]."""
    search: str = ""
    """Kinds to look for instead of those that lie there, as in --parts: what is found is wrong."""
    seed: FirstSeed = 0
    cad_scale: float = 1.0
    """The CAD files are this many times as large as what lies there: is that said?"""
    models: Maybe[Path] = None
    """Folder with a PLY file [mm] for each part, searched with instead of its CAD file."""
    cases: Maybe[Path] = None
    """Folder of kept cases, to search in these and in no pile; goes with --json alone."""
    plot: Maybe[Path] = None
    """HTML file to draw it in."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyModels:
    """Merge simulated scans of parts into models and compare them with the parts' CAD files.

    Beside each stands the convex hull of what its first scan shows.
    """

    parts: tuple[str, ...] = ("bracket", "keyed_cylinder")
    """Names under parts/, or paths."""
    ways: tuple[Literal["turntable", "held"], ...] = ("turntable", "held")
    """On a turntable under one scanner, or held and seen from all sides."""
    noise: tuple[Literal["fine", "rough"], ...] = ("fine", "rough")
    """Builds of scanner."""
    views: int = 12
    """Scans of each part."""
    shift_mm: float = 0.2
    """By so much poses are wrong (root mean square)."""
    turn_deg: float = 0.1
    """And by this, about the turntable's or the flange's frame."""
    off_mm: float = 0.0
    """The pose of the second scan is wrong by this besides, along x: is that said?"""
    keep: Maybe[Path] = None
    """Folder for the models, for `study localization --models`; one way and noise only."""
    seed: FirstSeed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyThreshold:
    """What each distance threshold between alternated and coordinated arms would give.

    Two parts fall into the bin at random, again and again; every pile is planned both ways.
    """

    cell: str = "yumi"
    """Name under robots/, or path of a cell.toml with two arms or more."""
    cycles: Piles = 100
    thresholds: tuple[float, ...] = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
    """Distances [m] to compare."""
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    scheduler: Maybe[str] = None
    """Address of a Dask cluster that does the work instead, tcp://host:port."""
    seed: FirstSeed = 0
    plot: Maybe[Path] = None
    """HTML file to draw the comparison in."""
    keep: bool = False
    """Keep the result beside the cell, where the page shows it with the threshold."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyEmptying:
    """Empty full bins: what is taken, how fast, and what stays in the corners and why.

    Parts fall into the bin by physics; plan after plan is made, carried out and the bin checked
    again; until three looks in a row bring no plan, or three picks in a row have failed.
    """

    cell: Positional[CellName] = "yumi"
    parts: int = 15
    """Parts in a pile."""
    part: str = ""
    """One of the cell's parts, `all` for all of them in turn, or names under parts/ or paths, a+b
    for both in one pile; the cell's first when not given."""
    recipe: RecipeNumber = 0
    bin: BinName = ""
    scenes: Piles = 10
    seed: FirstSeed = 0
    seen: Literal["truth", "scan"] = "truth"
    """Plan with the true poses, or with those found in a simulated scan."""
    settle: bool = True
    """Whether the rest moves and settles by physics as a part is lifted out."""
    strategy: str = "auto"
    """Which arms work and how, as in plan --strategy."""
    picks: int = 1
    """Plans in a row after one look, at most; with more than one the same piles are emptied by one
    plan a look, too, to be compared."""
    stirs: Maybe[int] = None
    """How often in a row a hand stirs where nothing can be taken; as the cell says when not
    given. Stirs also where the cell's robot link could not."""
    displaced_mm: float = 0.0
    """How far a base of an assembly moves sideways once it was placed; then parts have to mate."""
    bound: bool = False
    """Try many grasps of the tool on what stays: where one takes it, a library could."""
    what_if: str = ""
    """Empty the same piles with single changes, too, and rank them: `all`, or some of fingers,
    grasps, lifts, margins, bin, arms, order and tool, joined by +."""
    resume: Maybe[Path] = None
    """Folder in which each pile is kept as soon as it is done; what is there already is not done
    again, so that a study that was stopped goes on."""
    scan_seconds: float = 1.0
    """What a scan takes, for the parts an hour."""
    approval_seconds: float = 0.0
    """What a person needs to approve a plan, for the parts an hour."""
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    scheduler: Maybe[str] = None
    """Address of a Dask cluster that does the work instead, tcp://host:port."""
    plot: Maybe[Path] = None
    """HTML file to draw it in."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyPlacing:
    """How sure the hand is: where parts lie in it as said before, and as MuJoCo has it.

    Parts fall one at a time, are found in a simulated scan and gripped by some of the grasps that
    fit; each time off by an error drawn from what is said of scanner and search.
    """

    cell: Positional[CellName] = "yumi"
    grips: int = 2000
    part: str = ""
    """One of the cell's parts, a name under parts/ or a path; the cell's first when not given."""
    noise: Noise = "fine"
    """Build of scanner, as in study localization."""
    wider: float = 1.0
    """The search is this many times less sure than it says."""
    force: float = 20.0
    """Of each finger [N]."""
    acceleration: float = 0.0
    """Of the hand, upwards and to all sides [m/s2]; 0: as one joint of the arm brings about at
    home."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyMating:
    """Whether parts mate as often as their error budgets say: MuJoCo inserts them.

    Errors are drawn from the budgets of parts that fall, are found in a simulated scan and fit a
    grasp: those of the part in the hand and of its base.
    """

    cell: Positional[CellName] = "yumi"
    insertions: int = 500
    """Of each joint."""
    joints: tuple[str, ...] = ("peg in ring", "bolt in bracket hole", "cap on cylinder")
    wider: float = 1.0
    """All errors are this many times as large."""
    rigid: bool = False
    """The hand does not give way sideways."""
    look_again: bool = False
    """Each base is found again in a simulated scan, and the part goes to where it is seen."""
    force: float = 50.0
    """With which the hand inserts at most [N]."""
    friction: float = 0.2
    """Between the parts."""
    stiffness: float = 3.0
    """Of the hand that gives way [N/mm]."""
    seed: FirstSeed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyPallets:
    """Fill pallets in layers, a part from each of many piles, and see whether the stacks stand.

    Parts fall in simulation, their poses are known; each plan is proven, and MuJoCo says how the
    parts come to rest that are let go of.
    """

    cell: Positional[CellName] = "robots/tx2_90/pallet.toml"
    pallets: int = 10
    parts: int = 8
    """In each pile."""
    part: str = ""
    """One of the cell's kinds; its first when not given."""
    off_mm: float = 0.0
    """Standard deviation of where a hand really lets go, along x and along y."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyGrips:
    """Whether grips hold a part's weight as said before, and as MuJoCo has it.

    Grips, masses and frictions are drawn, about half of them too heavy; each is pulled in many
    directions.
    """

    cell: Positional[CellName] = "yumi"
    """Its first arm's hand takes the parts."""
    grips: int = 200
    part: str = ""
    """Parts of the cell, names under parts/ or paths, joined by +; all of the cell's when not
    given."""
    force: float = 20.0
    """Of each finger, or of the vacuum [N]."""
    acceleration: float = 5.0
    """Of the hand, in any direction [m/s2]."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyBop:
    """Find the objects of a data set in BOP's layout, and measure as BOP 2024 does.

    Its depth images alone are checked.
    """

    folder: Positional[Path]
    """The data set: its folder with the models and the splits."""
    split: str = "test"
    """Name of the folder with the scenes."""
    models: str = "models"
    """Name of the folder with the models to look for; errors are measured on models_eval, if there
    is one."""
    sensor: str = ""
    """Which one, where scenes have several: scene_camera_SENSOR.json, depth_SENSOR and so on."""
    cell: str = "yumi"
    """Name under robots/, or path of a cell.toml.  Its localizer searches; its scanner's noise
    counts where an image states none."""
    own_bin: bool = False
    """The images are of that cell's bin, by its scanner.  If not, things are searched for above the
    plane on which most of an image lies: a floor little above a table is taken for the table."""
    images: int = 0
    """No more than the first this many images; 0 takes all."""
    results: Maybe[Path] = None
    """A CSV file of BOP's results to be measured instead of a search."""
    out: Maybe[Path] = None
    """CSV file for what was found, as BOP takes it."""
    seed: int = 0
    """Of the search."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyScans:
    """Find the parts in every scan of a folder: what is found, what is not taken, and the time."""

    cell: Positional[CellName]
    folder: Positional[Path]
    """Folder with PLY or PCD files, as of the cell's scanner."""
    scale: tuple[str, ...] = ()
    """Parts that are larger or smaller than their CAD files, each PART=SIZE: pipe=0.92."""
    overlays: Maybe[Path] = None
    """Folder for a picture of each scan with what was found drawn over it."""
    seed: int = 0
    """Of the search."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyAbsent:
    """Search for parts that do not lie there: how often is one reported?

    Another part lies there than is searched for, or nothing, or rubbish.
    """

    cell: CellName = "yumi"
    scans: int = 100
    """How many scans of each situation."""
    parts: tuple[str, ...] = ("keyed_cylinder", "bracket", "bolt", "puck", "spacer")
    """Names under parts/, or paths; each is searched for, and lies where another is searched."""
    noise: tuple[Noise, ...] = EVERY_BUILD
    """Builds of scanner, as in study localization."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyWrongCad:
    """Find parts by CAD files of a wrong size: are they found, and is the error reported?"""

    cell: CellName = "yumi"
    scenes: int = 1
    """How many piles of eight for each part, build and error."""
    parts: tuple[str, ...] = ("keyed_cylinder", "bracket", "bolt")
    """Names under parts/, or paths."""
    noise: tuple[Noise, ...] = EVERY_BUILD
    """Builds of scanner, as in study localization."""
    scales: tuple[float, ...] = (1.0, 1.02, 1.05, 1.1)
    """The CAD files are this many times as large as what lies there."""
    offsets_mm: tuple[float, ...] = (0.5, 1.0, 2.0)
    """And those whose faces lie this far outside."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class Study:
    """Measure how well the cell does on many seeded piles."""

    what: (
        Annotated[StudyThreshold, subcommand("threshold")]
        | Annotated[StudyLocalization, subcommand("localization")]
        | Annotated[StudyModels, subcommand("models")]
        | Annotated[StudyEmptying, subcommand("emptying")]
        | Annotated[StudyPlacing, subcommand("placing")]
        | Annotated[StudyMating, subcommand("mating")]
        | Annotated[StudyPallets, subcommand("pallets")]
        | Annotated[StudyGrips, subcommand("grips")]
        | Annotated[StudyBop, subcommand("bop")]
        | Annotated[StudyScans, subcommand("scans")]
        | Annotated[StudyAbsent, subcommand("absent")]
        | Annotated[StudyWrongCad, subcommand("wrong-cad")]
    )
