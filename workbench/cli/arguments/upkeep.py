"""What can be typed to count and show what was recorded, and to look after an installation."""

from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from workbench.cli.arguments.names import Json, Maybe


@dataclass(frozen=True, slots=True)
class StatisticsArguments:
    """Tell what sessions have brought: parts per hour, success, times, causes of refusal."""

    sessions: Positional[tuple[Path, ...]] = ()
    """Folders of sessions; all of those in sessions/ when none is given."""
    csv: Maybe[Path] = None
    """CSV file to write, a row for each part that was sent for."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class Evidence:
    """Write a session with all that happened into one signed zip file; make its key or verify.py.

    `workbench evidence SESSION --out FILE --sign KEY` writes journal, files, certificates, wire, a
    report as HTML and PDF, a manifest with its signature, and verify.py, which needs Python alone.
    `workbench evidence key --out KEY` makes a key and prints the public one; `workbench evidence
    script --out verify.py` writes verify.py of this version (docs/evidence.md).
    """

    session: Positional[str]
    """Folder of the session, or the word `key` or `script`."""
    out: Maybe[Path] = None
    """File to write: evidence.zip; or evidence.key or verify.py, which must not be there yet."""
    sign: Maybe[Path] = None
    """PEM file of the Ed25519 key to sign with."""
    stamp: bool = False
    """Write the request for a time stamp (RFC 3161) beside it, too."""


@dataclass(frozen=True, slots=True)
class Acceptance:
    """Write the record by which a cell is accepted: the last picks against targets, with causes.

    It also states the steps of commissioning, success by part, grasp and arm, and has lines for
    signatures.  Ends with 1 when a target is missed.
    """

    sessions: Positional[tuple[Path, ...]]
    """Folders of sessions of one cell, the latest last; its checklist and cell count."""
    out: Path = Path("acceptance.html")
    """File to write: HTML, or PDF where it ends with .pdf (needs the extra `evidence`)."""
    picks: int = 200
    """How many picks are judged: the last ones."""
    share: float = 0.98
    """Share of these picks that must be taken, 0 to 1."""
    seconds: Maybe[float] = None
    """Time for each part taken that must not be exceeded [s], without approvals."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class Doctor:
    """Say what is installed, what is missing, and the command that installs it.

    Ends with 3 when something is missing that every command needs.
    """

    sbom: Maybe[Path] = None
    """Write a bill of the installed dependencies to this file: CycloneDX JSON."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class Compile:
    """Compile now, once on a machine, what is otherwise compiled at its first use."""


@dataclass(frozen=True, slots=True)
class Plugins:
    """List scanners, robot links, planners, localizers, tools and tabs: ours and installed ones."""

    json: Json = False
