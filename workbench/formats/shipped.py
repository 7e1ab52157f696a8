"""Where things that come with the workbench are found: robots, parts, pages."""

from pathlib import Path
from typing import Literal

from workbench.model.errors import FileError

Kind = Literal["robots", "parts", "static", "sessions"]

PACKAGE = Path(__file__).resolve().parent.parent


def folders(kind: Kind) -> list[Path]:
    """Folders that are searched, first one wins: working directory, checkout, wheel."""
    places = [Path.cwd() / kind, PACKAGE.parent / kind, PACKAGE / "shipped" / kind]
    # Beside an installed package lies site-packages, where `robots` may be anybody's.
    if not (PACKAGE.parent / "pyproject.toml").is_file():
        del places[1]
    return [place for place in places if place.is_dir()]


def find(kind: Kind, name: str) -> Path:
    """The folder or file of that name, or the path itself when `name` is one that exists.

    Raises:
        FileError: nothing of that name; the message lists what is there.
    """
    given = Path(name)
    if given.exists() and (len(given.parts) > 1 or given.is_file()):
        return given
    plain = len(given.parts) == 1 and name not in ("", ".", "..")
    for folder in folders(kind):
        if plain and (folder / name).exists():
            return folder / name
    known = sorted(
        {item.name for folder in folders(kind) for item in folder.iterdir() if item.is_dir()}
    )
    listed = ", ".join(known) if known else "nothing"
    raise FileError(name, f"no such path, and no such name under {kind}/ (there is {listed})")
