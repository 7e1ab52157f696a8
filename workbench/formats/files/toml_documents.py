"""TOML files that people wrote, to be changed in place: comments and all else stay as they are."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import tomlkit
from tomlkit.exceptions import TOMLKitError

from workbench.formats.files.toml_keys import LARGEST_FILE
from workbench.formats.files.whole_files import read_whole
from workbench.model.errors import FileError
from workbench.model.messages.files import FileProblem


def read_document(path: Path) -> Any:
    """A TOML file as a tomlkit document.

    Raises:
        FileError: it cannot be read, or is not TOML.
    """
    try:
        return tomlkit.parse(read_whole(path, LARGEST_FILE).decode("utf-8-sig"))
    except (TOMLKitError, UnicodeDecodeError) as error:
        raise FileError(path, FileProblem.NOT_VALID(kind="TOML", detail=str(error))) from None


def short(value: float, digits: int = 4) -> float | int:
    """A number as people write it: no -0, and whole numbers without a point."""
    rounded = round(float(value), digits) + 0.0
    return int(rounded) if rounded.is_integer() else rounded


def number(value: float, digits: int = 6) -> str:
    """A number as a line of a file has it that a program writes."""
    return f"{round(float(value), digits) + 0.0:.10g}"


def numbers(values: Iterable[float], digits: int = 6) -> str:
    """Several numbers, as such a line has them."""
    return f"[{', '.join(number(value, digits) for value in values)}]"


def text(value: object) -> str:
    """A text or a number as TOML has it; JSON writes them alike."""
    return json.dumps(value, ensure_ascii=False)


def shorts(values: Iterable[float], digits: int = 4) -> list[float | int]:
    """Several numbers as people write them."""
    return [short(value, digits) for value in values]


def millimetres(lengths: Iterable[float]) -> list[float | int]:
    """Lengths [m] as people write them, in millimetres."""
    return shorts(float(length) * 1000 for length in lengths)
