"""Bundles opened, changed and packed again, with as much made good as the one who does it can."""

import hashlib
import json
import sqlite3
import subprocess
import sys
import tempfile
import zipfile
from contextlib import closing
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from workbench.extras.evidence import packing, verify
from workbench.extras.evidence.signing import signature_of
from workbench.formats.files.archives import write_archive

OURS = Ed25519PrivateKey.from_private_bytes(b"o" * 32)
THEIRS = Ed25519PrivateKey.from_private_bytes(b"t" * 32)
PUBLIC = OURS.public_key().public_bytes_raw().hex()
ENDS = (packing.MANIFEST, packing.SIGNATURE)
AT = 1_800_000_000.0

UNCHAINED = "DROP TRIGGER IF EXISTS entries_stay; DROP TRIGGER IF EXISTS entries_remain;"


class Opened:
    """The files of a bundle by name, to be changed."""

    def __init__(self, source: Path | dict[str, bytes]) -> None:
        if isinstance(source, dict):
            self.files = source
            return
        with zipfile.ZipFile(source) as archive:
            self.files = {name: archive.read(name) for name in archive.namelist()}

    @property
    def manifest(self) -> dict:
        return json.loads(self.files[packing.MANIFEST])

    def sql(self, script: str) -> None:
        """Change the journal's database by SQL."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "journal.sqlite"
            path.write_bytes(self.files[verify.JOURNAL])
            with closing(sqlite3.connect(path)) as open_:
                open_.executescript(UNCHAINED + script)
            self.files[verify.JOURNAL] = path.read_bytes()

    @property
    def entries(self) -> list[verify.JournalEntry]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "journal.sqlite"
            path.write_bytes(self.files[verify.JOURNAL])
            return verify.entries_of(path)

    def chain_anew(self, change) -> None:
        """Rewrite every entry's hash after `change(number, body)` has changed bodies."""
        previous, script = verify.FIRST_HASH, []
        for one in self.entries:
            body = change(one.number, one.body)
            chained = verify.hash_of(previous, one.number, one.kind, body, one.files)
            script.append(
                f"UPDATE entries SET body = x'{body.hex()}', previous = '{previous}',"
                f" hash = '{chained}' WHERE number = {one.number};"
            )
            previous = chained
        self.sql("".join(script))

    def stated(self, **changes) -> None:
        """Say something else in the manifest."""
        text = json.dumps(self.manifest | changes, indent=1, sort_keys=True) + "\n"
        self.files[packing.MANIFEST] = text.encode()

    def made_good(self, key=None) -> None:
        """Have everything but the signature agree with the journal; `key` signs anew."""
        entries = self.entries
        self.files |= verify.derive_files(entries)
        files = {
            name: {"size": len(content), "sha256": hashlib.sha256(content).hexdigest()}
            for name, content in self._content().items()
        }
        self.stated(files=files, entries=len(entries), head=entries[-1].hash)
        self.repacked()
        if key is not None:
            self.signed(key)

    def repacked(self) -> None:
        """Have the manifest say how all before it is packed now."""
        with tempfile.TemporaryDirectory() as folder:
            told: list[str] = []
            write_archive(
                Path(folder) / "x.zip", self._content(), lambda one: told.append(one) or {}
            )
        self.stated(packed=told[0])

    def signed(self, key) -> None:
        self.files[packing.SIGNATURE] = signature_of(key, self.files[packing.MANIFEST])

    def as_of_0_2_0(self) -> None:
        """Say nothing of how it is packed, and sign that."""
        about = {key: value for key, value in self.manifest.items() if key != "packed"}
        self.files[packing.MANIFEST] = json.dumps(about, indent=1).encode()
        self.signed(OURS)

    def packed(self, path: Path) -> Path:
        """Write the bundle as the workbench packs it."""
        last = {name: self.files[name] for name in ENDS if name in self.files}
        write_archive(path, self._content(), lambda _: last)
        return path

    def _content(self) -> dict[str, bytes]:
        return {name: content for name, content in self.files.items() if name not in ENDS}


def anchors_of(one: Opened) -> str:
    """The approvals of a bundle as anchors that are kept elsewhere, a line each."""
    approvals = (entry for entry in one.entries if entry.kind == "Approve")
    return "".join(
        json.dumps({"session": "example", "number": entry.number, "hash": entry.hash}) + "\n"
        for entry in approvals
    )


def verified(made, bundle, *words):
    """Exit code and output of the script that came with the bundle, alone in its folder."""
    done = subprocess.run(
        [sys.executable, "-I", "-S", made / "verify.py", bundle, *words],
        cwd=made,
        capture_output=True,
        text=True,
        check=False,
    )
    assert "Traceback" not in done.stderr
    return done.returncode, done.stdout + done.stderr
