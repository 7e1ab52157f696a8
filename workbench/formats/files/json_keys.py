"""JSON files: read as strictly as TOML, each key once and numbers finite; written for people."""

import json
import re
from pathlib import Path
from typing import Any, NoReturn, cast

from workbench.formats.files.toml_keys import Table, quote
from workbench.formats.files.whole_files import MB, read_whole
from workbench.model.errors import FileError
from workbench.model.messages.files import FileProblem

LARGEST_FILE = 16 * MB
"""[bytes] A plan of two arms takes less than one megabyte."""


def read_json(path: Path, format_name: str) -> Table:
    """The top object of a JSON file whose key `format` is `format_name`.

    Raises:
        FileError: the file is not there or too long, or as `parse_json` has it.
    """
    return parse_json(path, read_whole(path, LARGEST_FILE), format_name)


def parse_json(path: Path, content: bytes, format_name: str) -> Table:
    """The top object of a JSON text whose key `format` is `format_name`.

    Raises:
        FileError: as `parse_object` has it, or another format.
    """
    table = Table(path, parse_object(path, content))
    table.text("format", among=(format_name,))
    return table


def parse_object(path: Path, content: bytes) -> dict[str, Any]:
    """The top object of a JSON text.

    Raises:
        FileError: not JSON (with the line), a key twice, NaN, or not an object; named after
            `path`.
    """
    try:
        values = json.loads(
            content.decode("utf-8-sig"), object_pairs_hook=_each_once, parse_constant=_refuse
        )
    except UnicodeDecodeError:
        raise FileError(path, FileProblem.NOT_TEXT()) from None
    except ValueError as error:
        raise FileError(path, FileProblem.NOT_VALID(kind="JSON", detail=str(error))) from None
    except RecursionError:
        raise FileError(path, "is nested too deeply") from None
    if not isinstance(values, dict):
        raise FileError(path, f"a JSON object is expected, {quote(values)} is given")
    return cast(dict[str, Any], values)


def json_text(path: Path, content: object) -> bytes:
    """JSON for people: indented, but a list of numbers stays on one line.

    Raises:
        FileError: it holds a number that is not finite, for which JSON has no word.
    """
    try:
        text = json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False)
    except ValueError:
        raise FileError(path, "not written: a number in it is not finite") from None
    # A line break is never part of a JSON string, so this finds lists of plain numbers only.
    flat = re.sub(r"\[\n[ ]*([-+.\deE,\s]+?)\n[ ]*\]", _on_one_line, text)
    return (flat + "\n").encode()


def _on_one_line(numbers: re.Match[str]) -> str:
    return f"[{' '.join(numbers[1].split())}]"


def _each_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for name, value in pairs:
        if name in values:
            raise ValueError(f"the key {quote(name)} is there twice")
        values[name] = value
    return values


def _refuse(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is not a JSON number")
