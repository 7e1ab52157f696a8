"""In which line of a xacro file something stands: xacro itself counts none."""

import contextlib
import re
from collections.abc import Generator, Iterable
from pathlib import Path
from typing import Any

import xacro

from workbench.formats.files.whole_files import read_whole
from workbench.formats.files.xml_elements import LARGEST_FILE, LINE, start_lines

EXPRESSION = re.compile(r"evaluating expression '(.+)'|unknown macro name: (\S+)", re.DOTALL)
COMMENT = re.compile(r"<!--.*?-->", re.DOTALL)
QUOTE = re.compile(r"[\"']")
COMPUTED = re.compile(r"\$[({].*[)}]")
"""What xacro replaces in a name."""


@contextlib.contextmanager
def marking_meshes(path: Path) -> Generator[None]:
    """Let xacro record with each mesh the line in which it stands.

    Args:
        path: of the file that is expanded; lines of others are recorded with the file's name.
    """
    parse = xacro.parse

    def parse_marked(inp: Any, filename: Any = None) -> Any:
        document: Any = parse(inp, filename)
        file = Path(filename)
        where = "" if file.resolve() == path.resolve() else f", in {file.name}"
        elements = document.getElementsByTagName("*")
        content = read_whole(file, LARGEST_FILE)
        for element, line in zip(elements, start_lines(content), strict=True):
            if element.tagName == "mesh":
                element.setAttribute(LINE, f"{where}, line {line}".replace("$", "$$"))
        return document

    xacro.parse = parse_marked
    try:
        yield
    finally:
        xacro.parse = parse


def line_of_error(file: Path, error: BaseException, causes: Iterable[BaseException]) -> str:
    """In which line of a file the expression or the macro stands that an error speaks of."""
    named = EXPRESSION.search(str(error))
    if named is not None:
        return _first(file, re.escape(next(filter(None, named.groups()))))
    called = [macro for cause in causes for macro in getattr(cause, "macros", ())]
    return line_of_call(file, called[0].body.getAttribute("name")) if called else ""


def line_of_call(file: Path, macro: str) -> str:
    """In which line of a file a macro is called first."""
    return _first(file, rf"<xacro:{re.escape(macro)}(?![\w.-])")


def line_of_name(file: Path, named: Path) -> str:
    """In which line of a file another one is named, by an include or to be loaded.

    Of several lines that may do so the one with the most letters of the name counts.
    """
    most, found = 0, ""
    for number, line in enumerate(_lines(file), start=1):
        for words in QUOTE.split(line):
            letters = COMPUTED.split(words.rsplit("/", 1)[-1])
            matches = re.fullmatch(".*".join(map(re.escape, letters)), named.name)
            if matches and len("".join(letters)) > most:
                most, found = len("".join(letters)), f", line {number}"
    return found


def _first(file: Path, wanted: str) -> str:
    lines = enumerate(_lines(file), start=1)
    numbers = (number for number, line in lines if re.search(wanted, line))
    number = next(numbers, None)
    return "" if number is None else f", line {number}"


def _lines(file: Path) -> list[str]:
    """The lines of a file without what stands in comments."""
    text = read_whole(file, LARGEST_FILE).decode(errors="replace")
    return COMMENT.sub(lambda comment: "\n" * comment[0].count("\n"), text).splitlines()
