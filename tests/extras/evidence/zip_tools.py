"""What programs of others unpack from a zip file."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

COMMANDS = {
    "unzip": ["unzip", "-qq", "-o", "-P", "x", "{zip}", "-d", "{out}"],
    "bsdtar": ["bsdtar", "-x", "--passphrase", "x", "-f", "{zip}", "-C", "{out}"],
    "bsdtar, from the front": ["bsdtar", "-x", "--passphrase", "x", "-f", "-", "-C", "{out}"],
    "7z": ["7z", "x", "-y", "-bd", "-px", "-o{out}", "{zip}"],
    "zipfile": [sys.executable, "-I", "-S", "-m", "zipfile", "-e", "{zip}", "{out}"],
}
"""Each unpacks a file into a folder; that from the front reads it as a stream."""

LONGEST = 120.0
"""[s] That a program may take."""

LARGEST = 2**27
"""[bytes] A file that is looked into: some programs make files as long as is said."""

needs_tools = pytest.mark.skipif(
    not all(shutil.which(name) for name in ("unzip", "bsdtar", "7z")),
    reason="unzip, libarchive-tools or p7zip-full is not installed",
)

Tree = dict[str, bytes | str]
"""The content of a file by its path; of a link, where it leads."""


def unpacked(path: Path, folder: Path) -> dict[str, tuple[bool, Tree]]:
    """By program: whether it ended well, and what it unpacked below `folder`."""
    found: dict[str, tuple[bool, Tree]] = {}
    for name, command in COMMANDS.items():
        # What leads outside, leads to a folder that is looked at, too.
        place = folder / name.replace(", ", "-").replace(" ", "-")
        out = place / "above" / "out"
        out.mkdir(parents=True)
        words = [word.format(zip=path.absolute(), out=out) for word in command]
        ended = subprocess.run(
            words,
            # Through a pipe, in which nobody looks at the end first.
            input=path.read_bytes() if "-" in words else b"",
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            timeout=LONGEST,
            env=os.environ | {"LC_ALL": "C.UTF-8"},
            cwd=out,
            check=False,
        )
        found[name] = (ended.returncode == 0, tree_of(place, out))
        shutil.rmtree(place)
    return found


def tree_of(place: Path, out: Path) -> Tree:
    """All files below a folder, by their paths from `out`."""
    tree: Tree = {}
    for folder, folders, names in os.walk(place, onerror=None):
        for name in (*folders, *names):
            path = Path(folder) / name
            told = os.path.relpath(path, out)
            if path.is_symlink():
                tree[told] = f"-> {os.readlink(path)}"
            elif path.is_file():
                path.chmod(0o600)
                size = path.stat().st_size
                tree[told] = path.read_bytes() if size < LARGEST else f"{size} bytes"
            elif path.is_dir():
                path.chmod(0o700)
            else:
                tree[told] = "something else"
    return tree
