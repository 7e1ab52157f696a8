"""What several commands are reported: options with the help that all of them share, and choices.

Choices are repeated here because `--help` loads nothing heavy.
"""

from pathlib import Path
from typing import Annotated, Literal, Optional, TypeVar

from tyro.conf import arg

T = TypeVar("T")
Maybe = Optional[T]  # noqa: UP045
"""That, or None. Written `T | None`, tyro takes a library of its own to see that None is one."""

OrderName = Literal["travel", "highest", "score", "nearest", "walls", "thesis"]

Json = Annotated[bool, arg(help="Print one JSON object and nothing else.")]
CellName = Annotated[str, arg(help="Name under robots/, or path of a cell.toml.")]
CellOfPlan = Annotated[
    Maybe[str],
    arg(help="Name under robots/, or path of a cell.toml; the name in the plan when not given."),
]
RecipeNumber = Annotated[
    int, arg(help="Number of the cell's recipe; 0: none, the cell is as its file states it.")
]
BinName = Annotated[
    str,
    arg(help="Name of the bin that parts are taken from; as recipe or cell say when not given."),
]
PartName = Annotated[str, arg(help="Name under parts/, or path of a part's folder.")]
PartOfPoses = Annotated[
    Maybe[str],
    arg(help="What the poses of a HALCON file are of, when the cell has several parts."),
]
ViewName = Annotated[
    str,
    arg(
        help="Name of the view from which the scanner on an arm scans; the first of the bin when "
        "not given."
    ),
]
Seed = Annotated[int, arg(help="Seed of everything random.")]
FirstSeed = Annotated[int, arg(help="Seed of the first pile; the others follow.")]
Piles = Annotated[int, arg(help="How many piles.")]
SessionFolder = Annotated[Path, arg(help="Folder of the session.")]
UserName = Annotated[str, arg(help="Name of the user.")]
UsersFile = Annotated[Path, arg(help="File of users and logins.")]
CertificatesFolder = Annotated[Path, arg(help="Folder of certificates.")]
ListenOn = Annotated[str, arg(help="Address to listen on.")]
