"""What can be typed after `workbench session`, and its help."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, subcommand

from workbench.cli.arguments.access import USERS
from workbench.cli.arguments.names import (
    Json,
    ListenOn,
    Maybe,
    SessionFolder,
    UsersFile,
)


@dataclass(frozen=True, slots=True)
class SessionList:
    """List the sessions: cell, entries, how each ended."""

    sessions: Path = Path("sessions")
    """Folder that holds them."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class SessionShow:
    """Tell what happened in a session, entry by entry: when, who, what, and what followed."""

    session: Positional[SessionFolder]
    json: Json = False


@dataclass(frozen=True, slots=True)
class SessionVerify:
    """Look whether a session was changed after it was written: its chain of hashes and its files.

    Ends with 3 when it was.
    """

    session: Positional[SessionFolder]
    anchors: Maybe[Path] = None
    """File of anchors that were kept elsewhere: the journal must be the one that they are of."""


@dataclass(frozen=True, slots=True)
class SessionReplay:
    """Compute a session again, its scans, parts, plans and proofs from the same inputs and seeds.

    Ends with 3 when a result differs.
    """

    session: Positional[SessionFolder]


@dataclass(frozen=True, slots=True)
class SessionExport:
    """Write a session into one zip file that anybody can open.

    What happened as text, JSON and CSV, a page that plays the last plan without a network, and all
    that `session import` needs.
    """

    session: Positional[Path]
    """Folder of the session; it may still be going on."""
    out: Path
    """File to write."""
    no_scene: bool = False
    """Leave the page out: it takes a few seconds."""
    mcap: bool = False
    """Write an MCAP file instead, for Foxglove and tools of ROS; cannot be imported again."""


@dataclass(frozen=True, slots=True)
class SessionImport:
    """Take a session from a zip file, provided that nothing in it was changed."""

    file: Positional[Path]
    """Zip file that `session export` has written."""
    sessions: Path = Path("sessions")
    """Folder for the session's folder, which gets the name of the zip file."""


@dataclass(frozen=True, slots=True)
class SessionCases:
    """List what was kept of a session's searches as cases, and copy them into a folder of cases.

    `study localization --cases FOLDER` searches in them again. Ends with 2 when one cannot be used.
    """

    session: Positional[SessionFolder]
    out: Maybe[Path] = None
    """Folder to copy those that can be used to; what is there already stays."""
    json: Json = False


@dataclass(frozen=True, slots=True)
class SessionPrune:
    """Remove old sessions, after telling which and what that frees."""

    sessions: Path = Path("sessions")
    """Folder that holds them; folders without a time in their name are left alone."""
    keep: Maybe[int] = None
    """How many of the newest to keep."""
    older_than_days: Maybe[float] = None
    """Keep those that are younger."""
    yes: bool = False
    """Do not ask."""


@dataclass(frozen=True, slots=True)
class SessionOpen:
    """Serve the page on a recorded session, to look at each moment of it; nothing can be sent."""

    session: Positional[SessionFolder]
    host: ListenOn = "127.0.0.1"
    port: int = 8081
    """Port to listen on; 0 takes a free one."""
    users: UsersFile = USERS
    certificate: Maybe[Path] = None
    """PEM file to serve over TLS with."""
    key: Maybe[Path] = None
    """PEM file of the certificate's key, not encrypted."""
    name: tuple[str, ...] = ()
    """Names under which browsers ask for this machine, beside --host and addresses."""
    hours: float = 8.0
    """How long a login lasts [h]."""


@dataclass(frozen=True, slots=True)
class SessionCommands:
    """Look into recorded sessions, check them, compute them again, take them along."""

    what: (
        Annotated[SessionList, subcommand("list")]
        | Annotated[SessionShow, subcommand("show")]
        | Annotated[SessionVerify, subcommand("verify")]
        | Annotated[SessionReplay, subcommand("replay")]
        | Annotated[SessionOpen, subcommand("open")]
        | Annotated[SessionExport, subcommand("export")]
        | Annotated[SessionImport, subcommand("import")]
        | Annotated[SessionCases, subcommand("cases")]
        | Annotated[SessionPrune, subcommand("prune")]
    )
