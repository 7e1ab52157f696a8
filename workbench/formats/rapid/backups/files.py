"""Files of modules: their text in whatever encoding an editor or a controller has left."""

from collections.abc import Sequence
from pathlib import Path

from workbench.formats.files.whole_files import PointerError, read_whole
from workbench.formats.rapid.declaring import Source
from workbench.formats.rapid.problems import UNKNOWN_NAME, UNREADABLE, BadModule, Problem
from workbench.formats.rapid.syntax.grammar import parse_all

LARGEST_MODULE = 16 << 20
"""[bytes]"""

SUFFIXES = frozenset({".mod", ".sys", ".prg", ".modx", ".sysx"})
"""Files of modules; those that end with x come from controllers with RobotWare 7."""

MARKS = ((b"\xef\xbb\xbf", "utf-8-sig"), (b"\xff\xfe", "utf-16"), (b"\xfe\xff", "utf-16"))
CONTROL = bytes(code for code in range(32) if code not in b"\t\n\f\r\x1a")
ENCODED = "an encoded module: what it declares is not known here"


def _text_of(data: bytes) -> str:
    """The text of a file: Unicode where it is that, else the code page of Western Windows."""
    for mark, encoding in MARKS:
        if data.startswith(mark):
            return data.decode(encoding, "replace")
    try:
        text = data.decode("utf-8")
    except UnicodeDecodeError:
        text = "".join(_western(data))
    return text.rstrip("\x00\x1a")


def _western(data: bytes) -> Sequence[str]:
    # Five codes have no letter in cp1252; editors keep them as they are.
    text = data.decode("cp1252", "replace")
    return [
        letter if letter != "\ufffd" else chr(code) for letter, code in zip(text, data, strict=True)
    ]


def lines_of(data: bytes) -> str:
    """The text of a file with line feeds alone between its lines."""
    return _text_of(data).replace("\r\n", "\n").replace("\r", "\n").replace("\x0c", "\n")


def _is_encoded(data: bytes) -> bool:
    """Whether a controller has encoded a module, so that nobody reads it."""
    if any(data.startswith(mark) for mark, _ in MARKS):
        return False
    head = data[:4096]
    return len(head) - len(head.translate(None, CONTROL)) > len(head) // 50


def read_modules(path: Path, shown: str) -> tuple[list[Source], list[Problem]]:
    """The modules of a file, and what is wrong with their syntax.

    Args:
        path: of the file.
        shown: how messages name it.

    Raises:
        FileError: there is no such file, or it is too large.
        BadModule: it has no module, or ends in the middle of one.
    """
    try:
        data = read_whole(path, LARGEST_MODULE)
    except PointerError:
        # The other files of a backup are read all the same.
        what = "a pointer of git-lfs: fetch the file (git lfs pull)"
        raise BadModule([Problem(shown, 1, 1, what, UNREADABLE)]) from None
    if _is_encoded(data):
        raise BadModule([Problem(shown, 1, 1, ENCODED, UNKNOWN_NAME, path.name)])
    text = lines_of(data)
    if not text.strip():
        raise BadModule([Problem(shown, 1, 1, "the file is empty", UNREADABLE)])
    trees, problems = parse_all(text, shown)
    return [Source(shown, tree, text) for tree in trees], problems
