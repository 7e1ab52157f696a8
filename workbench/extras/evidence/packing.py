"""The files of a bundle: the zip file has nothing but them, and each is as the manifest says.

`verify.py` carries it along, so it imports nothing but Python's own and what goes along, too.
"""

import hashlib
import json
from collections.abc import Iterator
from typing import IO, Any

from workbench.formats.files.zip_frame import CHUNK_BYTES, STORED, Member, blocks_of, members_of

FORMAT = "workbench-evidence/1"
MANIFEST, SIGNATURE = "manifest.json", "manifest.sig"

LARGEST_MANIFEST = 64 * 2**20


class VerificationError(Exception):
    """What ends the verification, as a sentence."""


class PackedFiles:
    """The files in the zip file of a bundle, by name; ValueError when anything else is in it."""

    def __init__(self, file: IO[bytes]) -> None:
        self.file = file
        self.members: dict[str, Member] = {member.name: member for member in members_of(file)}

    def blocks(self, name: str) -> Iterator[bytes]:
        """The content of a file, in pieces."""
        return blocks_of(self.file, self.members[name])

    def read(self, name: str, most: int) -> bytes:
        """The content of a file that is not longer than `most` bytes; empty when it is."""
        return b"".join(self.blocks(name)) if self.members[name].size <= most else b""


def manifest_of(bundle: PackedFiles) -> tuple[bytes, dict[str, Any]]:
    """The manifest as bytes and as values."""
    try:
        content = bundle.read(MANIFEST, LARGEST_MANIFEST)
        manifest = json.loads(content)
        if manifest["format"] != FORMAT:
            raise VerificationError(f"the format is {manifest['format']!r}, expected {FORMAT!r}")
        if not all({"size", "sha256"} <= set(about) for about in manifest["files"].values()):
            raise KeyError("size or sha256")
        return content, manifest
    except (KeyError, TypeError, ValueError, AttributeError, RecursionError):
        raise VerificationError("there is no manifest, or it cannot be read") from None


def packing_problems(bundle: PackedFiles, manifest: dict[str, Any]) -> Iterator[str]:
    """Where the zip file is not, byte for byte, the one whose packing was signed.

    The manifest says what all bytes before it are; what comes after it follows from what it says.
    Bundles of workbench 0.2.0 and before do not say it.
    """
    if "packed" not in manifest:
        return
    end = [bundle.members[name] for name in (MANIFEST, SIGNATURE) if name in bundle.members]
    whole, left = hashlib.sha256(), end[0].start - 30 - len(MANIFEST)
    bundle.file.seek(0)
    while left and (block := bundle.file.read(min(left, CHUNK_BYTES))):
        whole.update(block)
        left -= len(block)
    if whole.hexdigest() != manifest["packed"] or any(member.method != STORED for member in end):
        yield "the files are not packed as they were when they were signed"


def file_problems(bundle: PackedFiles, manifest: dict[str, Any]) -> Iterator[str]:
    """Files that are not as the manifest has them, are missing, or that it does not name."""
    there = set(bundle.members) - {MANIFEST, SIGNATURE}
    for name in sorted(set(manifest["files"]) - there):
        yield f"{name} is missing"
    for name in sorted(there - set(manifest["files"])):
        yield f"{name} is not in the manifest"
    for name in sorted(there & set(manifest["files"])):
        about = manifest["files"][name]
        if bundle.members[name].size != about["size"]:
            yield f"{name} has another length than the manifest says"
            continue
        whole = hashlib.sha256()
        try:
            for block in bundle.blocks(name):
                whole.update(block)
        except ValueError as error:
            yield str(error)
            continue
        if whole.hexdigest() != about["sha256"]:
            yield f"{name} is not the file that was signed"


def signed_message(manifest: bytes) -> bytes:
    """What is signed: the manifest, and what it is, so that no other signature passes for it."""
    return FORMAT.encode() + b"\n" + manifest
