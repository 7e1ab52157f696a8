"""A session as evidence: one zip file with its journal, what people read, and a signature."""

import hashlib
import inspect
import itertools
import json
import re
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench import __version__
from workbench.app.core.command import Entry
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.state import State
from workbench.app.records.certificates import certificates
from workbench.app.records.replay import replay
from workbench.app.records.sessions import cell_of
from workbench.extras.evidence import ed25519, packing, steps, verify
from workbench.extras.evidence.pages import html_page, pdf_pages
from workbench.extras.evidence.report import Moment, clock, tables_of
from workbench.extras.evidence.signing import signature_of
from workbench.formats.files import zip_frame
from workbench.formats.files.archives import write_archive
from workbench.journal import anchors
from workbench.journal.files import file_path
from workbench.journal.journal import DATABASE, Journal
from workbench.model.errors import JournalError
from workbench.model.scan import Scan

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

README = """\
Evidence of a session of Workbench.

report.html, report.pdf   what happened, for people
log.json, approvals.json, wire.txt   the same in detail, made from the journal
certificates/   what was proven of each plan; `workbench prove --check FILE` proves it again
session/   the journal and its files; `workbench session open session` shows it moment by moment
manifest.json, manifest.sig   the SHA-256 of every file, signed with Ed25519
verify.py   tells whether anything was changed; it needs Python 3.11 or later, alone:

    python verify.py BUNDLE.zip --key PUBLIC_KEY

Take the public key from whoever signs, not from here, and verify.py from where you trust it.
Pass the zip file on as it is: unpacked and packed again, it is no longer what was signed.
"""

NO_POINTS: Mapping[str, Any] = {
    "points": np.zeros((1, 3)), "pixels": None, "colours": None, "views": ()
}  # fmt: skip
"""Of a scan whose points nobody reads any more."""

STANDARD = re.compile(r"^(?:from (?!workbench)(\S+) )?import (.*)\n", re.MULTILINE)
"""A line that imports from Python's own."""


@dataclass(frozen=True, slots=True)
class Bundle:
    """What was written: where the chain ended, and the manifest as its bytes."""

    entries: int
    head: str
    manifest: bytes
    has_pdf: bool


def write_bundle(
    journal: Journal, path: Path, at: float, key: "Ed25519PrivateKey | None" = None
) -> Bundle:
    """Write the evidence of a session, which may go on meanwhile, into one zip file.

    Args:
        journal: of the session.
        path: of the zip file.
        at: when [s since the epoch].
        key: signs; None leaves the bundle without a signature.

    Raises:
        JournalError: the journal cannot be read, was changed, or is none of a session.
        FileError: the zip file cannot be written.
    """
    if problems := journal.verify():
        raise JournalError(f"{journal.folder}: {problems[0]}; of a changed session is no evidence")
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / DATABASE
        journal.save_copy(copy)
        try:
            entries = verify.entries_of(copy)
            derived = verify.derive_files(entries)
        except verify.VerificationError as problem:
            raise JournalError(f"{journal.folder}: {problem}") from problem
        _check_session(journal, entries)
        content: dict[str, Path | bytes] = {verify.JOURNAL: copy}
        for digest in sorted({digest for entry in entries for digest in entry.files}):
            name = f"{verify.FILES}/{digest[:2]}/{digest}"
            content[name] = file_path(journal.folder / "files", digest)
        content |= derived
        moments, broke = moments_of(journal, len(entries))
        rows = itertools.islice(journal.entries(), len(moments) + 1)
        for certificate in certificates(rows, journal.read):
            content[f"certificates/{certificate.number}-{certificate.digest[:12]}.json"] = (
                certificate.certificate
            )
        head = _head(journal, entries, at)
        tables = tables_of(head, moments, broke)
        title = f"Evidence of session {journal.folder.name}"
        content["report.html"] = html_page(title, tables)
        if (pdf := pdf_pages(title, tables)) is not None:
            content["report.pdf"] = pdf
        content["README.txt"] = README.encode()
        content["verify.py"] = verify_script()
        manifests: list[bytes] = []

        def last(packed: str) -> Mapping[str, bytes]:
            manifest = _manifest(journal.folder.name, entries, at, content, packed)
            manifests.append(manifest)
            signed = {} if key is None else {packing.SIGNATURE: signature_of(key, manifest)}
            return {packing.MANIFEST: manifest, **signed}

        write_archive(path, content, last)
    return Bundle(len(entries), entries[-1].hash, manifests[0], pdf is not None)


def verify_script() -> bytes:
    """`verify.py` as one file: what it imports of ours is put where it is imported."""
    head, _, script = inspect.getsource(verify).partition('"""\n\n')
    for module, says in (
        (ed25519, "Ed25519, after RFC 8032, section 5.1.7"),
        (packing, "The files of a bundle"),
        (zip_frame, "The zip file"),
        (steps, "Approvals, rows, speed and steps"),
        (anchors, "Anchors"),
    ):
        imported = re.compile(
            rf"^from {module.__name__} import (\([^)]*\)|[^(\n]*)\n", re.MULTILINE
        )
        inside = inspect.getsource(module).partition('"""\n\n')[2].strip()
        before, _, after = imported.split(script, 1)
        script = f"{before}\n\n# {says}\n\n{inside}\n{imported.sub('', after)}"
    taken: dict[str, set[str]] = {}
    for source, names in STANDARD.findall(script):
        taken.setdefault(source and f"from {source} ", set()).update(names.split(", "))
    lines = [f"import {name}" for name in sorted(taken.pop(""))]
    lines += [f"{source}import {', '.join(sorted(taken[source]))}" for source in sorted(taken)]
    rest = STANDARD.sub("", script).lstrip()
    return "\n".join((f'{head}"""', "", *lines, "", "", rest)).encode()


def moments_of(journal: Journal, count: int) -> tuple[list[Moment], str]:
    """All moments up to the entry `count`, and why they end before it; empty if they do not.

    Their scans have no points.
    """
    moments: list[Moment] = []
    try:
        for moment in itertools.islice(replay(journal, cell_of(journal)), count - 1):
            moments.append(_without_points(*moment))
    except JournalError as error:
        return moments, str(error)
    return moments, ""


def _without_points(entry: Entry, state: State) -> Moment:
    """The moment without its scans' points: no report shows them, and they fill the memory."""
    command = entry.command
    if isinstance(command, JobEnded) and isinstance(command.result, Scan):
        result = replace(command.result, **NO_POINTS)
        entry = replace(entry, command=replace(command, result=result))
    elif isinstance(command, UseScan):
        entry = replace(entry, command=replace(command, scan=replace(command.scan, **NO_POINTS)))
    return entry, state if state.scan is None else replace(state, scan=None)


def _check_session(journal: Journal, entries: list[verify.JournalEntry]) -> None:
    if "cell" not in json.loads(entries[0].body):
        raise JournalError(
            f"{journal.folder}: is no session, but perhaps the record of `workbench send`; "
            "`workbench session verify` verifies that"
        )


def _head(journal: Journal, entries: list[verify.JournalEntry], at: float) -> Mapping[str, str]:
    first: Any = json.loads(entries[0].body)
    last: Any = json.loads(entries[-1].body)
    about = {
        "session": journal.folder.name,
        "cell": f"{first['cell']}, {first['cell_digest']}",
        "begun": f"{clock(first['at'])} with workbench {first['workbench']}",
        "last entry": clock(last["at"]),
        "entries": f"{len(entries)}, none of them changed since it was written",
        "head of the chain": entries[-1].hash,
        "this report": f"{clock(at)} by workbench {__version__}",
    }
    if "follows" in first:
        about["after session"] = f"{first['follows']['session']}, {first['follows']['head']}"
    return about


def _manifest(
    session: str,
    entries: list[verify.JournalEntry],
    at: float,
    content: Mapping[str, Path | bytes],
    packed: str,
) -> bytes:
    """The manifest; `packed` is the SHA-256 of all that the zip file has before it."""
    files = {name: _describe(source) for name, source in sorted(content.items())}
    about = {"format": packing.FORMAT, "session": session, "made_at": at, "made_with": __version__}
    about |= {"entries": len(entries), "head": entries[-1].hash, "files": files, "packed": packed}
    return (json.dumps(about, indent=1, sort_keys=True) + "\n").encode()


def _describe(source: Path | bytes) -> Mapping[str, Any]:
    if isinstance(source, bytes):
        return {"size": len(source), "sha256": hashlib.sha256(source).hexdigest()}
    with source.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return {"size": source.stat().st_size, "sha256": digest}
