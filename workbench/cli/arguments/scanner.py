"""What can be typed after `workbench scanner`: its help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.names import CellName, Json


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
    """Write unit, axes and, if nobody has calibrated the scanner, its pose into the cell file."""
    bin: bool = False
    """With --write: write the bin's size as well, where another bin than the cell's is seen."""
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
class ScannerCommands:
    """Look at the first scan of a scanner; see whether it has drifted since its calibration."""

    what: Annotated[ScannerFit, subcommand("fit")] | Annotated[ScannerDrift, subcommand("drift")]
