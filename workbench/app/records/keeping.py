"""Cells, parts and sessions below a working directory as one file."""

import contextlib
import json
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from workbench import __version__
from workbench.app.records.case_folder import case_files
from workbench.formats.files.archives import write_archive
from workbench.journal.journal import DATABASE, Journal
from workbench.model.errors import InputError

FORMAT = "workbench-backup/1"
MANIFEST = "backup.json"
WITHOUT_SESSIONS = ("robots", "parts")
"""Folders of a backup that holds cells and parts alone."""

BACKED_UP_FOLDERS = (*WITHOUT_SESSIONS, "sessions")
"""Folders below the working directory that are kept; each thing is a folder or a file in them."""


def write_backup(root: Path, out: Path, kinds: Sequence[str], more: Mapping[str, bytes]) -> int:
    """Write what is kept into one zip file.

    Args:
        root: the working directory.
        out: the zip file.
        kinds: some of `BACKED_UP_FOLDERS`.
        more: files that come beside, by name.

    Returns:
        How many files are in it.

    Raises:
        InputError: there is neither a cell nor a part.
        FileError: something cannot be read or written.
        JournalError: a session cannot be read.
    """
    content: dict[str, Path | bytes] = {}
    with contextlib.ExitStack() as stack:
        for kind in kinds:
            for thing in things_in(root / kind):
                if kind == "sessions":
                    content |= _session(thing, stack)
                else:
                    content |= {_name(root, file): file for file in files_of(thing)}
        if not any(name.startswith(("robots/", "parts/")) for name in content):
            raise InputError(f"{root}: has neither cells in robots/ nor parts in parts/ to keep")
        content |= more
        head = {"format": FORMAT, "workbench": __version__}
        write_archive(out, {MANIFEST: json.dumps(head).encode(), **content})
    return len(content)


def _session(folder: Path, stack: contextlib.ExitStack) -> dict[str, Path | bytes]:
    """The files of a session, its database as it is at this moment."""
    if not (folder / DATABASE).is_file():
        return {}
    place = Path(stack.enter_context(tempfile.TemporaryDirectory()))
    with contextlib.closing(Journal(folder)) as journal:
        journal.save_copy(place / DATABASE)
    root = folder.parents[1]
    kept = (*files_of(folder / "files"), *case_files(folder))
    files = {_name(root, file): file for file in kept}
    return {f"sessions/{folder.name}/{DATABASE}": place / DATABASE, **files}


def things_in(folder: Path) -> Iterator[Path]:
    """Cells, parts or sessions in the folder of their kind, by name; none when it is not there."""
    if folder.is_dir():
        yield from sorted(path for path in folder.iterdir() if not _is_hidden(path))


def files_of(thing: Path) -> Iterator[Path]:
    """All files of a thing that are kept: none that are hidden, half written or compiled."""
    if thing.is_file():
        yield thing
        return
    for file in sorted(thing.rglob("*")):
        if file.is_file() and not any(
            _is_hidden(Path(part)) for part in file.relative_to(thing).parts
        ):
            yield file


def _is_hidden(path: Path) -> bool:
    return path.name.startswith(".") or path.name == "__pycache__" or path.suffix == ".partial"


def _name(root: Path, file: Path) -> str:
    return file.relative_to(root).as_posix()
