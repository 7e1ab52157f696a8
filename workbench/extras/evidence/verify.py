"""Looks whether a bundle of evidence is as it was signed.  Needs Python 3.11 or later, alone.

    python verify.py BUNDLE.zip --key PUBLIC_KEY [--anchors FILE]

The public key (64 hexadecimal digits, or a file with them) has to come from whoever signs, not from
the bundle: anybody can sign with a key of their own.  For the same reason run a copy of this file
that you had before, or have compared: the one in a bundle may have been exchanged with it.
FILE holds anchors, heads of the journal that were kept elsewhere, one JSON object a line.

Exit code 0: whole, and signed with that key.  1: something was changed.  2: nothing shows a
change, but no key was given or the bundle is not signed, so anybody may have made it.
"""

import argparse
import hashlib
import json
import re
import sqlite3
import sys
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any, NamedTuple

from workbench.extras.evidence.ed25519 import is_signed
from workbench.extras.evidence.packing import (
    SIGNATURE,
    PackedFiles,
    VerificationError,
    file_problems,
    manifest_of,
    packing_problems,
    signed_message,
)
from workbench.extras.evidence.steps import approval_problems, step_problems
from workbench.journal.anchors import anchor_problems, anchors_from

JOURNAL, FILES = "session/journal.sqlite", "session/files"

FIRST_HASH = "0" * 64
SIGNED_BY = re.compile(rb"([0-9a-f]{64})\n([0-9a-f]{128})\n")
"""Public key and signature; nothing else may stand beside them, since nothing signs that file."""

KNOWN = {
    *(("table", name) for name in ("entries", "files", "entry_files", "sqlite_sequence")),
    *(("trigger", name) for name in ("entries_stay", "entries_remain")),
}
"""What a journal's database has; a view could stand in the place of a table."""

BACK = 1.0
"""[s] By so much a clock may be set back without a word."""

MOST_PROBLEMS = 50


class JournalEntry(NamedTuple):
    """An entry of the journal; `body` is what was written."""

    number: int
    kind: str
    body: bytes
    files: tuple[str, ...]
    previous: str
    hash: str


# The chain


def hash_of(previous: str, number: int, kind: str, body: bytes, files: Iterable[str]) -> str:
    """The hash of an entry: each field enters with its length."""
    chain = hashlib.sha256()
    for field in (body, *(text.encode() for text in (previous, str(number), kind, *files))):
        chain.update(len(field).to_bytes(8, "big"))
        chain.update(field)
    return chain.hexdigest()


def entries_of(database: Path) -> list[JournalEntry]:
    """The entries of a journal, in order; Problem when it is none."""
    try:
        with closing(
            sqlite3.connect(f"{database.as_uri()}?mode=ro&immutable=1", uri=True)
        ) as open_:
            found = set(open_.execute("SELECT type, name FROM sqlite_master WHERE sql IS NOT NULL"))
            if not found <= KNOWN:
                raise VerificationError(
                    "the journal has tables, views or triggers that no journal has"
                )
            files: dict[int, list[str]] = {}
            for number, digest in open_.execute("SELECT entry, digest FROM entry_files"):
                files.setdefault(number, []).append(digest)
            rows = open_.execute(
                "SELECT number, kind, body, previous, hash FROM entries ORDER BY number"
            )
            entries = [
                JournalEntry(
                    number, kind, body, tuple(sorted(files.pop(number, ()))), previous, chained
                )
                for number, kind, body, previous, chained in rows
            ]
            if files:
                raise VerificationError(
                    f"files are named for entry {min(files)}, which is not there"
                )
            highest = open_.execute("SELECT seq FROM sqlite_sequence WHERE name = 'entries'")
            last = next((seq for (seq,) in highest), 0)
            if entries and last > entries[-1].number:
                raise VerificationError(f"the entries up to {last} are missing at the end")
            return entries
    except (sqlite3.Error, TypeError, UnicodeDecodeError) as error:
        raise VerificationError(f"the journal cannot be read: {error}") from None


def _rehash(entry: JournalEntry) -> str:
    return hash_of(entry.previous, entry.number, entry.kind, entry.body, entry.files)


def chain_problems(entries: list[JournalEntry]) -> Iterator[str]:
    """Where the chain does not hold, or entries contradict one another."""
    if not entries:
        yield "the journal has no entry"
    expected, previous = 1, FIRST_HASH
    for entry in entries:
        if entry.number != expected:
            yield f"entry {entry.number} stands where entry {expected} should"
        if entry.previous != previous:
            yield f"entry {entry.number} does not follow from the one before it"
        if _rehash(entry) != entry.hash:
            yield f"entry {entry.number} was changed after it was written"
        expected, previous = entry.number + 1, entry.hash
    bodies = [(member.number, member.kind, body_of(member)) for member in entries]
    yield from approval_problems(bodies)
    yield from step_problems(bodies)


def clock_remarks(entries: list[JournalEntry]) -> Iterator[str]:
    """Where the clock was set back: no change of the record, but somebody should know."""
    before = 0.0
    for entry in entries:
        at = body_of(entry).get("at")
        if isinstance(at, (int, float)):
            if at < before - BACK:
                yield f"entry {entry.number}: the clock was set back by {before - at:.0f} s"
            before = at


# What is made from the journal


def body_of(entry: JournalEntry) -> dict[str, Any]:
    """The content of an entry."""
    try:
        body = json.loads(entry.body)
    except ValueError:
        body = None
    if not isinstance(body, dict):
        raise VerificationError(f"entry {entry.number} has no content that can be read")
    return body


def derive_files(entries: list[JournalEntry]) -> dict[str, bytes]:
    """The files that are made from the journal alone, so they are made again and compared."""
    log: list[Any] = []
    approvals: list[Any] = []
    wire: list[str] = []
    for entry in entries:
        body = body_of(entry)
        after = body.get("after") or {}
        about = {key: body.get(key) for key in ("at", "actor", "role")}
        about |= {"message": after.get("message", ""), "ran": after.get("ran")}
        log.append({"number": entry.number, "kind": entry.kind, **about, "hash": entry.hash})
        if entry.kind == "Approve":
            approvals.append({"entry": entry.number, "vote_of": body["actor"], **about})
            approvals[-1]["approval"] = body.get("approval")
        if entry.kind == "Sent":
            receipt = body["command"]["receipt"]
            words = (receipt["arm"], receipt["kind"], receipt["sent"], receipt["heard"])
            wire.append(json.dumps([entry.number, receipt["at"], *words], ensure_ascii=False))
    texts = {
        "log.json": json.dumps(log, indent=1, ensure_ascii=False),
        "wire.txt": "\n".join(['["entry", "at", "arm", "kind", "sent", "heard"]', *wire]) + "\n",
        "approvals.json": json.dumps(approvals, indent=1, ensure_ascii=False),
    }
    return {name: text.encode() for name, text in texts.items()}


# The bundle


def journal_problems(
    bundle: PackedFiles, manifest: dict[str, Any], entries: list[JournalEntry]
) -> Iterator[str]:
    """Where journal, manifest and what was made from the journal do not agree."""
    yield from chain_problems(entries)
    head = entries[-1].hash if entries else FIRST_HASH
    if (manifest.get("entries"), manifest.get("head")) != (len(entries), head):
        yield "the journal does not end where the manifest says"
    for entry in entries:
        for digest in entry.files:
            name = f"{FILES}/{digest[:2]}/{digest}"
            if manifest["files"].get(name, {}).get("sha256") != digest:
                yield f"the file {digest[:12]} of entry {entry.number} is missing or another one"
    for name, content in derive_files(entries).items():
        if name not in manifest["files"] or bundle.read(name, len(content)) != content:
            yield f"{name} does not tell what the journal tells"


# All of it


def problems_of(path: Path, key: bytes | None, anchors: list[Any] | None) -> tuple[list[str], ...]:
    """What shows a change, what people should know, and what is missing for certainty."""
    problems: list[str] = []
    remarks: list[str] = []
    missing: list[str] = []
    try:
        with path.open("rb") as file, tempfile.TemporaryDirectory() as folder:
            try:
                bundle = PackedFiles(file)
            except ValueError as error:
                raise VerificationError(f"the zip file cannot be read: {error}") from None
            content, manifest = manifest_of(bundle)
            problems.extend(_signature_problems(bundle, content, key, missing))
            problems.extend(packing_problems(bundle, manifest))
            problems.extend(file_problems(bundle, manifest))
            if problems:
                return problems, remarks, missing
            database = Path(folder).resolve() / "journal.sqlite"
            with database.open("wb") as copy:
                copy.writelines(bundle.blocks(JOURNAL))
            entries = entries_of(database)
            problems.extend(journal_problems(bundle, manifest, entries))
            remarks.extend(clock_remarks(entries))
            if anchors is not None:
                hashes = {entry.number: entry.hash for entry in entries}
                problems.extend(anchor_problems(hashes, manifest["session"], anchors))
            remarks.append(f"session {manifest['session']}, {len(entries)} entries, head")
            remarks.append(f"  {manifest['head']}")
    except VerificationError as problem:
        problems.append(str(problem))
    except (OSError, LookupError, TypeError, ValueError, RuntimeError) as error:
        problems.append(f"cannot be read: {error}")
    return problems, remarks, missing


def _signature_problems(
    bundle: PackedFiles, content: bytes, key: bytes | None, missing: list[str]
) -> Iterator[str]:
    if SIGNATURE not in bundle.members:
        missing.append("the bundle is not signed: anybody may have made it")
        if key is not None:
            yield "the bundle is not signed, and a key was given"
        return
    words = SIGNED_BY.fullmatch(bundle.read(SIGNATURE, 1000))
    if words is None:
        yield "the signature cannot be read"
        return
    public_key, signature = (bytes.fromhex(word.decode()) for word in words.groups())
    if not is_signed(public_key, signature, signed_message(content)):
        yield "the signature is not that of the manifest"
    elif key is None:
        missing.append(
            f"signed with the key {public_key.hex()}: ask the signer whether it is theirs"
        )
    elif key != public_key:
        yield f"signed with another key: {public_key.hex()}"


def key_from(typed: str) -> bytes:
    """The public key that was typed, or that stands in the file of that name."""
    text = typed
    if len(typed) != 64:
        text = Path(typed).read_text(encoding="ascii")
    return bytes.fromhex(text.strip())


def main(arguments: list[str] | None = None) -> int:
    """Verify the bundle that was typed."""
    parser = argparse.ArgumentParser(description="Look whether evidence is as it was signed.")
    parser.add_argument("bundle", type=Path)
    parser.add_argument("--key", help="public key of the signer, 64 hexadecimal digits, or a file")
    parser.add_argument("--anchors", type=Path, help="file of heads that were kept elsewhere")
    typed = parser.parse_args(arguments)
    try:
        key = None if typed.key is None else key_from(typed.key)
        anchors, torn = None, list[str]()
        if typed.anchors is not None:
            anchors, torn = anchors_from(typed.anchors.read_text(encoding="utf-8"))
    except (OSError, TypeError, ValueError) as error:
        print(f"key or anchors cannot be read: {error}", file=sys.stderr)
        return 1
    problems, remarks, missing = problems_of(typed.bundle, key, anchors)
    for line in (*problems[:MOST_PROBLEMS], *torn, *remarks, *missing):
        # Names in the file may hold anything, also what a terminal obeys.
        print("".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in line))
    if problems:
        print(f"{typed.bundle}: CHANGED, {len(problems)} problem{'s' * (len(problems) > 1)}")
        return 1
    if missing:
        print(f"{typed.bundle}: nothing shows a change, but who made it is not known")
        return 2
    print(f"{typed.bundle}: whole, as it was signed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
