"""A session as one file to take elsewhere, and back: journal, files, and what people can read."""

import json
import re
import tempfile
import time
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import Any

from workbench.app.records.case_folder import CASE_NAME, FOLDER, case_files
from workbench.app.records.certificates import certificates
from workbench.app.records.record import SESSION
from workbench.app.statistics.statistics import statistics
from workbench.app.statistics.statistics_table import csv_text
from workbench.formats.files.archives import unpacked_beside, write_archive
from workbench.formats.files.shipped import is_example_session
from workbench.formats.files.whole_files import is_file, plain_name
from workbench.journal.files import file_path
from workbench.journal.journal import DATABASE, Journal
from workbench.journal.schema import is_foreign
from workbench.model.errors import FileError, InputError, JournalError

KNOWN = re.compile(
    r"journal\.sqlite|files/[0-9a-f]{2}/[0-9a-f]{64}|summary\.(txt|json)|statistics\.csv|scene\.html|log\.jsonl"
    rf"|certificates/certificate-[0-9a-f]{{12}}\.json|{FOLDER}/{CASE_NAME.pattern}",
    re.ASCII,
)
"""What may be in the zip file of a session."""


@dataclass(frozen=True, slots=True)
class SessionListing:
    """What happened in a session, entry by entry, for people."""

    head: Mapping[str, Any]
    entries: tuple[Mapping[str, Any], ...]


def open_journal(folder: Path) -> Journal:
    """The journal of a session's folder.

    Raises:
        InputError: the folder holds none.
    """
    if not is_file(folder / DATABASE):
        raise InputError(f"{folder}: is not the folder of a session (there is no {DATABASE})")
    return Journal(folder)


def sessions_in(root: Path) -> tuple[Path, ...]:
    """The folders of all sessions below a folder, by name, without the example that is shipped."""
    found = sorted(file.parent for file in root.glob(f"*/{DATABASE}"))
    return tuple(folder for folder in found if not is_example_session(folder))


def list_session(
    journal: Journal, certified: Mapping[int, str] = MappingProxyType({})
) -> SessionListing:
    """Each entry in a few words.

    Args:
        journal: of the session.
        certified: number of an entry -> the file of what was proven there.

    Raises:
        JournalError: the journal cannot be read.
    """
    entries: list[dict[str, Any]] = []
    head: dict[str, Any] = {"session": journal.folder.name, "head": journal.head}
    for row in journal.entries():
        try:
            body: Any = json.loads(row.body)
            after = body.get("after", {})
            if row.kind == SESSION:
                head |= {key: body[key] for key in ("workbench", "cell", "cell_digest")}
                if "follows" in body:
                    head["follows"] = body["follows"]["session"]
        except (AttributeError, KeyError, ValueError) as error:
            raise JournalError(f"entry {row.number} ({row.kind}) cannot be read") from error
        entries.append(
            {
                "number": row.number,
                "at": body.get("at"),
                "actor": body.get("actor", ""),
                "kind": row.kind,
                "phase": after.get("phase", ""),
                "message": after.get("message", f"cell {body.get('cell', '')}"),
                "files": len(row.files),
            }
        )
        if row.number in certified:
            entries[-1]["certificate"] = certified[row.number]
    return SessionListing(head, tuple(entries))


def export_session(
    journal: Journal, path: Path, scene: bytes | None, log: Path | None = None
) -> None:
    """Write a session into one zip file.

    Args:
        journal: of the session, which may go on meanwhile.
        path: of the zip file.
        scene: a page that shows its last plan.
        log: what the server wrote into its log last, which may be of other sessions too.

    Raises:
        JournalError: the journal cannot be read, or was changed after it was written.
        FileError: the zip file cannot be written.
    """
    if problems := journal.verify():
        raise JournalError(f"{journal.folder}: {problems[0]}; a changed session is not exported")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / DATABASE
        journal.save_copy(copy)
        with closing(Journal(Path(folder))) as still:
            files = sorted({digest for row in still.entries() for digest in row.files})
            content: dict[str, Path | bytes] = _readable(journal, still)
        content[DATABASE] = copy
        for digest in files:
            content[f"files/{digest[:2]}/{digest}"] = file_path(journal.folder / "files", digest)
        content |= {f"{FOLDER}/{file.name}": file for file in case_files(journal.folder)}
        if scene is not None:
            content["scene.html"] = scene
        if log is not None:
            # A copy: it goes on being written.
            content["log.jsonl"] = log.read_bytes()
        write_archive(path, content)


def _readable(journal: Journal, still: Journal) -> dict[str, Path | bytes]:
    proven = tuple(certificates(still.entries(), journal.read, only_approved=True))
    names = {
        certificate.number: f"certificates/certificate-{certificate.digest[:12]}.json"
        for certificate in proven
    }
    counted = statistics(still.entries())
    said = list_session(still, names)
    head = {**said.head, "session": journal.folder.name, "entries": still.count}
    head |= {"cycles": len(counted.cycles), "picked": counted.picked}
    return {
        "summary.txt": _text(head, said).encode(),
        "summary.json": json.dumps({**head, "log": said.entries}, indent=1).encode(),
        "statistics.csv": csv_text(counted).encode(),
        **{names[certificate.number]: certificate.certificate for certificate in proven},
    }


def _text(head: Mapping[str, Any], said: SessionListing) -> str:
    lines = [f"{key.replace('_', ' ')}: {value}" for key, value in head.items()]
    lines += ["", "time (UTC)           who              what             says"]
    for entry in said.entries:
        at = time.strftime("%Y-%m-%d %H:%M:%S", time.gmtime(entry["at"] or 0))
        lines.append(f"{at}  {entry['actor']:<15}  {entry['kind']:<15}  {entry['message']}")
        if "certificate" in entry:
            lines.append(f"{'':<54}proven: {entry['certificate']}")
    return "\n".join(lines) + "\n"


def import_session(path: Path, root: Path) -> Path:
    """Take a session from a zip file, if nothing in it was changed.

    Args:
        path: of the zip file.
        root: of the sessions; the new folder there has the name of the zip file.

    Returns:
        The new folder.

    Raises:
        FileError: the zip file is not one of a session, or the folder is there already.
        JournalError: the journal is not whole.
    """
    name = plain_name(path.stem).lstrip(".")
    if not name:
        raise FileError(path, "has no name that a folder could have; rename the zip file")
    target = root / name
    if target.exists():
        raise FileError(target, "is there already; rename the zip file to take it beside")
    with unpacked_beside(path, root) as place:
        names = [file.relative_to(place).as_posix() for file in place.rglob("*") if file.is_file()]
        for name in sorted(names):
            if not KNOWN.fullmatch(name):
                raise FileError(path, f"is not a session's: it holds {name!r}")
        check_journal(path, place)
        place.rename(target)
        # The block removes a folder of this name when it ends.
        place.mkdir()
    return target


def check_journal(path: Path, folder: Path) -> None:
    """Look whether an unpacked folder holds the whole journal of a session.

    Raises:
        FileError: it holds none, or a database with other tables or triggers; the message names
            `path`.
        JournalError: the journal is not whole.
    """
    try:
        if not (folder / DATABASE).is_file() or is_foreign(folder / DATABASE):
            raise FileError(path, "does not hold the journal of a session")
    except JournalError:
        raise FileError(path, f"its {DATABASE} is no journal") from None
    with closing(Journal(folder)) as journal:
        if problems := journal.verify():
            raise JournalError(f"{path}: {problems[0]}")
        first = next(journal.entries(), None)
        if first is None or first.kind != SESSION:
            raise FileError(path, "does not hold the journal of a session")
