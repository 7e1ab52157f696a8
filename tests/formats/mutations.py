"""Broken files for readers: random bytes, and valid files with a few bytes changed."""

import random
from collections.abc import Callable
from pathlib import Path

from hypothesis import strategies as st

from workbench.model.errors import FileError

TELLING = (b"", b"\x00", b"\xff", b"-", b"9", b"nan", b"1e999", b"[", b"]", b"{", b'"', b"\n", b" ")


def mutated(valid: bytes) -> st.SearchStrategy[bytes]:
    """Bytes of a file: random ones, or `valid` after some replacements, cuts and doublings."""
    return st.one_of(
        st.binary(max_size=200),
        st.tuples(st.integers(0, 2**32 - 1), st.integers(1, 6)).map(
            lambda drawn: _changed(valid, *drawn)
        ),
    )


def _changed(valid: bytes, seed: int, changes: int) -> bytes:
    draw = random.Random(seed)
    content = valid
    for _ in range(changes):
        at = draw.randrange(len(content) + 1)
        length = draw.choice((0, 1, 1, 2, 8, 60))
        piece = content[at : at + length]
        new = draw.choice((*TELLING, piece + piece, draw.randbytes(length)))
        content = content[:at] + new + content[at + length :]
        if draw.random() < 0.1:
            content = content[: draw.randrange(len(content) + 1)]
    return content


def only_file_errors(path: Path, content: bytes, read: Callable[[Path], object]) -> None:
    """Read a file of that content: it is read, or refused with a message of one line."""
    path.write_bytes(content)
    try:
        read(path)
    except FileError as error:
        message = str(error)
        assert message.startswith(str(path.parent)), "the message does not name the file"
        assert message.isprintable() and len(message) < 1000
