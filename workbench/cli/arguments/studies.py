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
    """Find the parts of seeded piles in simulated scans, and compare with their true poses.

    With --cases it searches saved scans again, which people have corrected: it ends with 3 when a
    correct part is missing or more parts are wrong, with 2 when a case cannot be used.
    """

    cell: CellName = "yumi"
    scenes: int = 10
    """Number of piles for each part, count and noise."""
    parts: tuple[str, ...] = ("keyed_cylinder", "bracket", "bolt")
    """Names under parts/, or paths, one after the other; a+b for both in one pile."""
    counts: tuple[int, ...] = (2, 8)
    """Parts in a pile."""
    noise: tuple[Noise, ...] = ("fine", "rough")
    """Builds of scanner: that of the cell, one with twice its noise and many flaws, other kinds."""
    raised: float = 0.0
    """Calibration error: scans show everything this much too high [mm]."""
    tilted: float = 0.0
    """Calibration error: turn of the scans about the bin's x axis [degrees]."""
    search: str = ""
    """Kinds to search for instead of those in the pile, as in --parts: every find is wrong."""
    seed: FirstSeed = 0
    cad_scale: float = 1.0
    """Size of the CAD files relative to the parts; counts whether the search reports it."""
    models: Maybe[Path] = None
    """Folder with a PLY file [mm] for each part, searched with instead of its CAD file."""
    cases: Maybe[Path] = None
    """Folder of saved cases, searched without any pile; combine it with --json only."""
    plot: Maybe[Path] = None
    """HTML file for the plot."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyModels:
    """Merge simulated scans of parts into models and compare them with the parts' CAD files.

    For comparison it also measures the convex hull of the first scan.
    """

    parts: tuple[str, ...] = ("bracket", "keyed_cylinder")
    """Names under parts/, or paths."""
    ways: tuple[Literal["turntable", "held"], ...] = ("turntable", "held")
    """On a turntable under one scanner, or held and scanned from all sides."""
    noise: tuple[Literal["fine", "rough"], ...] = ("fine", "rough")
    """Builds of scanner."""
    views: int = 12
    """Number of scans of each part."""
    shift_mm: float = 0.2
    """Error of the poses (root mean square) [mm]."""
    turn_deg: float = 0.1
    """Error of the poses about the turntable's or the flange's frame [degrees]."""
    off_mm: float = 0.0
    """Further error of the second scan along x [mm]; the study counts whether it is reported."""
    keep: Maybe[Path] = None
    """Folder for the models, for `study localization --models`; with one way and one noise only."""
    seed: FirstSeed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyThreshold:
    """Compare distance thresholds between alternated and coordinated arms.

    Each pile has two parts that fell into the bin at random, and is planned both ways.
    """

    cell: str = "yumi"
    """Name under robots/, or path of a cell.toml with two arms or more."""
    cycles: Piles = 100
    thresholds: tuple[float, ...] = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3)
    """Distances [m] to compare."""
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    scheduler: Maybe[str] = None
    """Address of a Dask cluster for the work, tcp://host:port."""
    seed: FirstSeed = 0
    plot: Maybe[Path] = None
    """HTML file for the plot."""
    keep: bool = False
    """Store the result in the folder of the cell, where the page shows it with the threshold."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyEmptying:
    """Empty full bins in simulation: the parts taken, the speed, and the parts left, with reasons.

    Parts fall into the bin by physics.  Then scans, plans and picks alternate until three scans in
    a row bring no plan, or three picks in a row have failed.
    """

    cell: Positional[CellName] = "yumi"
    parts: int = 15
    """Number of parts in a pile."""
    part: str = ""
    """One of the cell's parts, `all` for all of them in turn, or names under parts/ or paths, a+b
    for both in one pile; the cell's first when not given."""
    recipe: RecipeNumber = 0
    bin: BinName = ""
    scenes: Piles = 10
    seed: FirstSeed = 0
    seen: Literal["truth", "scan"] = "truth"
    """Plan with the true poses, or with the poses found in a simulated scan."""
    settle: bool = True
    """Whether the other parts move and settle by physics when a part is lifted out."""
    strategy: str = "auto"
    """Strategy of the arms, as in plan --strategy."""
    picks: int = 1
    """Largest number of plans after one scan; with more than one, the same piles are also emptied
    with one plan a scan, for comparison."""
    stirs: Maybe[int] = None
    """Largest number of stirs in a row when nothing can be taken, also if the cell's robot link
    cannot stir; the cell's when not given."""
    displaced_mm: float = 0.0
    """Displacement of each base of an assembly after it was placed [mm]; then parts must mate."""
    bound: bool = False
    """Try many grasps on the parts that are left: a library with a grasp that works could help."""
    what_if: str = ""
    """Empty the same piles with single changes of the cell, too, and rank these: `all`, or some of
    fingers, grasps, lifts, margins, bin, arms, order and tool, joined by +."""
    resume: Maybe[Path] = None
    """Folder for the result of each pile; an interrupted study continues with the piles that are
    missing there."""
    scan_seconds: float = 1.0
    """Duration of a scan [s], for the parts per hour."""
    approval_seconds: float = 0.0
    """Duration of an approval by a person [s], for the parts per hour."""
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    scheduler: Maybe[str] = None
    """Address of a Dask cluster for the work, tcp://host:port."""
    plot: Maybe[Path] = None
    """HTML file for the plot."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyPlacing:
    """Compare the predicted pose of parts in the hand with MuJoCo's.

    Parts fall one at a time, are found in a simulated scan and gripped by some of the grasps that
    fit.  Each grip has an error drawn from the stated errors of scanner and search.
    """

    cell: Positional[CellName] = "yumi"
    grips: int = 2000
    """Number of grips."""
    part: str = ""
    """One of the cell's parts, a name under parts/ or a path; the cell's first when not given."""
    noise: Noise = "fine"
    """Build of scanner, as in study localization."""
    wider: float = 1.0
    """Factor of the search's true error to its stated error."""
    force: float = 20.0
    """Force of each finger [N]."""
    acceleration: float = 0.0
    """Acceleration of the hand, upwards and to all sides [m/s2]; 0: what one joint of the
    arm causes at home."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyMating:
    """Compare the predicted chance that parts mate with insertions by MuJoCo.

    Parts fall, are found in a simulated scan and gripped.  The errors of the part in the hand and
    of its base are drawn from their error budgets.
    """

    cell: Positional[CellName] = "yumi"
    insertions: int = 500
    """Number of insertions of each joint."""
    joints: tuple[str, ...] = ("peg in ring", "bolt in bracket hole", "cap on cylinder")
    wider: float = 1.0
    """Factor of the true errors to those of the budgets."""
    rigid: bool = False
    """A hand that is stiff sideways."""
    look_again: bool = False
    """Find each base again in a simulated scan, and bring the part to the pose found."""
    force: float = 50.0
    """Largest force of the insertion [N]."""
    friction: float = 0.2
    """Friction coefficient of the parts."""
    stiffness: float = 3.0
    """Sideways stiffness of the hand [N/mm], unless it is --rigid."""
    seed: FirstSeed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyPallets:
    """Fill pallets in layers, with one part of each pile, and count the stacks that stand.

    Parts fall in simulation, and their poses are known.  Each plan is proven, and MuJoCo computes
    how the released parts come to rest.
    """

    cell: Positional[CellName] = "robots/tx2_90/pallet.toml"
    pallets: int = 10
    """Number of pallets."""
    parts: int = 8
    """Number of parts in each pile."""
    part: str = ""
    """One of the cell's parts; its first when not given."""
    off_mm: float = 0.0
    """Standard deviation of the true place of release, along x and along y [mm]."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyGrips:
    """Compare the predicted load of grips with MuJoCo's.

    Grips, masses and frictions are random, and about half of the parts are too heavy.  Each grip is
    pulled in many directions.
    """

    cell: Positional[CellName] = "yumi"
    """Name under robots/, or path of a cell.toml; the hand of its first arm takes the parts."""
    grips: int = 200
    """Number of grips."""
    part: str = ""
    """Parts of the cell, names under parts/ or paths, joined by +; all of the cell's when not
    given."""
    force: float = 20.0
    """Force of each finger, or of the vacuum [N]."""
    acceleration: float = 5.0
    """Acceleration of the hand, in any direction [m/s2]."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyBop:
    """Find the objects of a data set in BOP's layout, with the measures of BOP 2024.

    The study uses the depth images only.
    """

    folder: Positional[Path]
    """The data set: its folder with the models and the splits."""
    split: str = "test"
    """Name of the folder with the scenes."""
    models: str = "models"
    """Name of the folder with the models to search for; errors are measured on models_eval, if
    there is one."""
    sensor: str = ""
    """Sensor, if scenes have several: scene_camera_SENSOR.json, depth_SENSOR and so on."""
    cell: str = "yumi"
    """Name under robots/, or path of a cell.toml.  Its localizer searches; the noise of its
    scanner counts for images that state none."""
    own_bin: bool = False
    """The images show that cell's bin, by its scanner.  Otherwise the search is above the main
    plane of an image; a floor close to a table may be taken for the table."""
    images: int = 0
    """Number of images, from the first; 0 takes all."""
    results: Maybe[Path] = None
    """A CSV file of results in BOP's form, measured without a search."""
    out: Maybe[Path] = None
    """CSV file for the results, in BOP's form."""
    seed: int = 0
    """Seed of the search."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyScans:
    """Find the parts in every scan of a folder: parts found, parts not taken, and the time."""

    cell: Positional[CellName]
    folder: Positional[Path]
    """Folder with PLY or PCD files of the cell's scanner."""
    scale: tuple[str, ...] = ()
    """Sizes of parts relative to their CAD files, each PART=SIZE: pipe=0.92."""
    overlays: Maybe[Path] = None
    """Folder for a picture of each scan, with the parts found drawn over it."""
    seed: int = 0
    """Seed of the search."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyAbsent:
    """Search for parts that are absent, and count those that are reported.

    The bin holds another part, nothing, or rubbish.
    """

    cell: CellName = "yumi"
    scans: int = 100
    """Number of scans of each situation."""
    parts: tuple[str, ...] = ("keyed_cylinder", "bracket", "bolt", "puck", "spacer")
    """Names under parts/, or paths; each is searched for, and is the other part for the others."""
    noise: tuple[Noise, ...] = EVERY_BUILD
    """Builds of scanner, as in study localization."""
    seed: FirstSeed = 0
    workers: int = 1
    """Processes on this machine; more than one needs the extra `cluster`."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class StudyWrongCad:
    """Find parts by CAD files of a wrong size; count the parts found and the errors reported."""

    cell: CellName = "yumi"
    scenes: int = 1
    """Number of piles of eight parts for each part, build and error."""
    parts: tuple[str, ...] = ("keyed_cylinder", "bracket", "bolt")
    """Names under parts/, or paths."""
    noise: tuple[Noise, ...] = EVERY_BUILD
    """Builds of scanner, as in study localization."""
    scales: tuple[float, ...] = (1.0, 1.02, 1.05, 1.1)
    """Sizes of the CAD files relative to the parts."""
    offsets_mm: tuple[float, ...] = (0.5, 1.0, 2.0)
    """Offsets of the CAD files' faces, outwards [mm]."""
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
