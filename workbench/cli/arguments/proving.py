"""What can be typed to prove plans and to check certificates."""

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from workbench.cli.arguments.names import CellOfPlan, Json, Maybe, PartOfPoses


@dataclass(frozen=True, slots=True)
class Prove:
    """Prove a plan and write a certificate, or check one (docs/proof.md).

    A certificate holds plan, scene and what was proven: any machine with the cell checks it, in
    less time than it took to find.
    """

    plan: Positional[Maybe[Path]] = None
    """JSON file of a plan, also of one that another program made."""
    scan: Maybe[Path] = None
    """PLY or PCD file of the scan that it was made for."""
    poses: Maybe[Path] = None
    """Our JSON or a HALCON tuple file of all parts known to be in the bin."""
    part: PartOfPoses = None
    certificate: Maybe[Path] = None
    """Write the certificate to this file, when the proof holds."""
    check: Maybe[Path] = None
    """Check this certificate, instead of proving a plan."""
    out: Maybe[Path] = None
    """Write the plan with its digest to this file, when the proof holds."""
    cell: CellOfPlan = None
    json: Json = False


@dataclass(frozen=True, slots=True)
class Verify:
    """Prove a plan again, from its file and the cell, and against a scan or poses if given.

    What the plan says of the bin is compared with scan or poses (docs/proof.md); `prove` writes a
    certificate besides.
    """

    plan: Positional[Path]
    """JSON file of a plan."""
    scan: Maybe[Path] = None
    """PLY or PCD file of the scan that it was made for."""
    poses: Maybe[Path] = None
    """Our JSON or a HALCON tuple file of all parts known to be in the bin."""
    part: PartOfPoses = None
    cell: CellOfPlan = None
    json: Json = False
