"""Where things that come with the workbench are found: robots, parts, pages, the manual."""

from pathlib import Path
from typing import Literal

from workbench.model.errors import FileError

Kind = Literal["robots", "parts", "static", "sessions", "docs"]

PACKAGE = Path(__file__).resolve().parents[2]


def folders(kind: Kind) -> list[Path]:
    """Folders that are searched, first one wins: the working directory, then what is shipped."""
    return [place for place in (Path.cwd() / kind, _shipped(kind)) if place.is_dir()]


def is_example_session(folder: Path) -> bool:
    """Whether a session's folder is the example that comes with the workbench."""
    return folder.resolve() == _shipped("sessions") / "example"


def _shipped(kind: Kind) -> Path:
    # A wheel carries its own copies; only in a checkout do they lie next to the package.
    shipped = PACKAGE / "shipped"
    return (shipped if shipped.is_dir() else PACKAGE.parent) / kind


def find(kind: Kind, name: str) -> Path:
    """The folder or file of that name, or the path itself when `name` is one that exists.

    Raises:
        FileError: nothing of that name; the message lists what is there.
    """
    given = Path(name)
    if exists(given) and (len(given.parts) > 1 or given.is_file()):
        return given
    if len(given.parts) == 1 and name != "..":
        for folder in folders(kind):
            if exists(folder / name):
                return folder / name
    known = sorted(
        {item.name for folder in folders(kind) for item in folder.iterdir() if item.is_dir()}
    )
    listed = ", ".join(known) if known else "nothing"
    shown = name if name.isprintable() and 0 < len(name) <= 200 else repr(name[:200])
    raise FileError(shown, f"no such path, and no such name under {kind}/ (there is {listed})")


def exists(path: Path) -> bool:
    """Whether there is such a path; also for names that none can have."""
    try:
        return path.exists()
    except (OSError, ValueError):  # a name too long, or one that no file can have
        return False
