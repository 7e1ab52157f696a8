"""What can be typed after `workbench scanner`: its help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import CellName, Json, Seed


@dataclass(frozen=True, slots=True)
class ScannerFit:
    """Look at the first scan of a scanner: unit, axes, bin, the scanner's pose and its noise.

    Says in words what does not fit the cell, with the key to change. Ends with 3 when something
    does not.
    """

    scan: Positional[Path]
    """Point cloud, PLY or PCD, of the bin without the robot."""
    cell: CellName = "yumi"
    write: bool = False
    """Write unit, axes and range into the cell file and, if nobody has calibrated the scanner, its
    pose."""
    bin: bool = False
    """With --write: write the size of another bin that is seen, or a bin without walls around the
    parts where no rim is seen."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class ScannerDrift:
    """Say whether the scanner still hangs where it was calibrated, by recorded sessions.

    Bin and fixtures are checked in the scans of every day, and parts where the robot has put them
    in view of the scanner. Nothing is changed unless --save is given.
    """

    cell: Positional[CellName]
    sessions: Positional[tuple[Path, ...]] = ()
    """Folders of sessions; all below sessions/ when none is given."""
    save: bool = False
    """Write the scanner's pose by all of this into the cell file, with how sure it is then."""
    by: str = ""
    """Name of the person who answers for it; needed to save."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class ScannerTrueness:
    """Compare distances of balls in scans with the stated ones: sphere-spacing and scale error.

    A plate of three balls or a bar of two lies where parts lie, in three places or more. Ends with
    3 when an error is above the limit.
    """

    cell: Positional[CellName]
    scans: tuple[Path, ...]
    """Point clouds, PLY or PCD, or folders of them, in the unit of the cell's scanner."""
    lengths: tuple[float, ...] = (80.0, 100.0, 120.0)
    """Distances of the centres [mm]: one of a bar; three of a plate, 1 to 2, 2 to 3, 3 to 1."""
    ball: float = 30.0
    """Diameter of the balls [mm]."""
    limit: float = 0.3
    """Largest sphere-spacing error that is good [mm]."""
    simulate: bool = False
    """Without hardware: make the folder of --scans, three places in the bin."""
    seed: Seed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class ScannerTouch:
    """Compare where scanner and robot have balls that a tool tip touches.

    A person has jogged the robot; nothing moves. Ends with 3 when an offset is above the error that
    the calibration predicts, or the limit.
    """

    cell: Positional[CellName]
    scan: Path
    """Point cloud of the plate, PLY or PCD, in the unit of the cell's scanner."""
    joints: Path
    """Text file: a line for each touch, joints as the pendant shows them."""
    arm: str = ""
    """Whose tool touches; the cell's first when not given."""
    tip: float = 0.0
    """Inner diameter of a hollow tip, which centres itself on the ball [mm]; 0: a point."""
    lengths: tuple[float, ...] = (80.0, 100.0, 120.0)
    """Distances of the centres [mm]: 1 to 2, 2 to 3, 3 to 1."""
    ball: float = 30.0
    """Diameter of the balls [mm]."""
    limit: float = 0.0
    """Largest offset that is good [mm]; 0: as the calibration predicts."""
    simulate: bool = False
    """Without hardware: make both files; the scanner is off as its calibration predicts."""
    seed: Seed = 0
    json: Json = False


@dataclass(frozen=True, slots=True)
class ScannerCommands:
    """Look at the first scan of a scanner; check its drift, its trueness, and it by touches."""

    what: (
        Annotated[ScannerFit, subcommand("fit")]
        | Annotated[ScannerDrift, subcommand("drift")]
        | Annotated[ScannerTrueness, subcommand("trueness")]
        | Annotated[ScannerTouch, subcommand("touch")]
    )
