"""A part's grasps in files: versions saved with a remark, and a draft until then.

`versions/0001.toml` and so on hold what was saved each time; `changes.log` states for each who
saved it, when, and why; `grasps.draft.toml` holds changes that nobody has saved yet.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from workbench.formats.files.change_log import LOG, add_line, utc
from workbench.formats.files.toml_documents import read_document, shorts
from workbench.formats.files.toml_keys import LARGEST_FILE
from workbench.formats.files.whole_files import make_folder, read_whole, write_whole
from workbench.formats.parts.grasp_files import GRASPS, as_written, save_grasps
from workbench.formats.parts.grasp_words import changes_in_words
from workbench.formats.parts.reading import read_grasps
from workbench.formats.parts.scales import write_shape
from workbench.model.digest import digest_of
from workbench.model.errors import FileError
from workbench.model.part import GraspLibrary, Part
from workbench.model.symmetry import Symmetry

DRAFT = "grasps.draft.toml"
VERSIONS = "versions"


@dataclass(frozen=True, slots=True)
class Version:
    """A library that was saved: its number from 1, when (UTC), by whom and why, and its file."""

    number: int
    at: str
    by: str
    remark: str
    file: Path

    @property
    def library(self) -> GraspLibrary:
        """The grasps as they were saved.

        Raises:
            FileError: the file is gone or broken.
        """
        return read_grasps(self.file)


def save_part(
    folder: Path, old: Part, new: Part, *, actor: str, at: float, remark: str
) -> int | None:
    """Write what a part has otherwise than its files: grasps, symmetry, size and offset.

    Args:
        folder: of the part.
        old: as its files have it.
        new: as it shall be read from now on.
        actor: who saves.
        at: when [s since the epoch].
        remark: why.

    Returns:
        The number of the version that was made; None where the grasps are as they were.

    Raises:
        FileError: a file cannot be read or written.
    """
    version = None
    if is_resized(old, new):
        write_shape(folder, new.scale, new.offset)
    if digest_of(old.symmetry) != digest_of(new.symmetry):
        _save_symmetry(folder / "part.toml", new.symmetry)
    if digest_of(old.library) != digest_of(as_written(new.library)):
        if not versions(folder):
            _add_version(folder, old.library, actor="", at=at, remark="as it was before")
        save_grasps(folder / GRASPS, new.library)
        version = _add_version(folder, new.library, actor=actor, at=at, remark=remark)
    drop_draft(folder)
    return version


def is_resized(old: Part, new: Part) -> bool:
    """Whether a part has another size, or another offset, than before."""
    return (old.scale, old.offset) != (new.scale, new.offset)


def _add_version(folder: Path, library: GraspLibrary, *, actor: str, at: float, remark: str) -> int:
    """Add a version and return its number."""
    earlier = versions(folder)
    make_folder(folder / VERSIONS)
    number = 1 + max((version.number for version in earlier), default=0)
    while (file := folder / VERSIONS / f"{number:04}.toml").exists():
        number += 1  # of a version that did not get into the log, or out of it
    save_grasps(file, library)
    before = earlier[-1].library if earlier else GraspLibrary()
    entry = {
        "version": number,
        "at": utc(at),
        "by": actor,
        "remark": remark,
        "changes": list(map(str, changes_in_words(before, library))) if earlier else [],
    }
    add_line(folder / LOG, entry)
    return number


def versions(folder: Path) -> tuple[Version, ...]:
    """The versions of a part's grasps that were saved, oldest first.

    Raises:
        FileError: the log cannot be read.
    """
    if not (folder / LOG).is_file():
        return ()
    return tuple(_versions(folder))


def _versions(folder: Path) -> Iterator[Version]:
    text = read_whole(folder / LOG, LARGEST_FILE).decode("utf-8", errors="replace")
    for line in text.splitlines():
        try:
            entry: Any = json.loads(line)
            number = int(entry["version"])
            at, by, remark = (str(entry[key])[:200] for key in ("at", "by", "remark"))
        except (ValueError, KeyError, TypeError):
            continue  # a line that a person wrote, or half of one
        file = folder / VERSIONS / f"{number:04}.toml"
        if file.is_file():
            yield Version(number, at, by, remark, file)


def write_draft(folder: Path, library: GraspLibrary) -> None:
    """Keep changes that nobody has saved yet.

    Raises:
        FileError: it cannot be written.
    """
    draft = folder / DRAFT
    if (folder / GRASPS).is_file() and not draft.is_file():
        write_whole(draft, read_whole(folder / GRASPS, LARGEST_FILE))
    save_grasps(draft, library)
    if draft_of(folder) is None:
        drop_draft(folder)


def draft_of(folder: Path) -> GraspLibrary | None:
    """Changes that nobody has saved, if there are any: a draft that says what is saved is none.

    Raises:
        FileError: the draft is broken, or the file with the grasps.
    """
    if not (folder / DRAFT).is_file():
        return None
    draft, file = read_grasps(folder / DRAFT), folder / GRASPS
    saved = read_grasps(file) if file.is_file() else GraspLibrary()
    return draft if changes_in_words(saved, draft) else None


def drop_draft(folder: Path) -> None:
    """Forget changes that nobody has saved.

    Raises:
        FileError: the file cannot be removed.
    """
    try:
        (folder / DRAFT).unlink(missing_ok=True)
    except OSError as error:
        raise FileError(folder / DRAFT, error.strerror or "cannot be removed") from None


def _stated_besides(symmetry: Symmetry) -> dict[str, list[Any]]:
    """The keys of a symmetry besides its main axis; empty without any."""
    also = [{"axis": shorts(axis.axis, 6), "fold": axis.fold} for axis in symmetry.also]
    point = shorts(1000 * np.array(symmetry.point), 4) if any(symmetry.point) else []
    return {"point_mm": point, "also": also}


def _save_symmetry(path: Path, symmetry: Symmetry) -> None:
    document: Any = read_document(path)
    if "symmetry" not in document:
        document["symmetry"] = tomlkit.table()
    table = document["symmetry"]
    table["axis"] = shorts(symmetry.axis, 6)
    table["fold"] = symmetry.fold
    for key, value in _stated_besides(symmetry).items():
        table.pop(key, None)
        if value:
            table[key] = value
    write_whole(path, tomlkit.dumps(document).encode())
