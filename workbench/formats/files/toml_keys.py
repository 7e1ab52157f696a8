"""Strict reading of TOML: every key known, every value of its kind, every error with its place."""

import difflib
import math
import re
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator
from contextvars import ContextVar
from pathlib import Path
from typing import Any, cast

import numpy as np

from workbench.formats.files.whole_files import MB, read_whole
from workbench.model.errors import FileError
from workbench.model.geometry import Floats
from workbench.model.messages.files import FileProblem, FileText
from workbench.model.messages.message import Message
from workbench.model.scan import Option

LARGEST_FILE = 4 * MB
"""[bytes] Nobody writes a longer cell or grasp file by hand."""

MISSING: Any = object()

Notes = dict[str, dict[str, Any]]
"""Place of a key, tables in arrays being called `[]` -> what was asked of it, as JSON Schema."""

NOTES: ContextVar[Notes | None] = ContextVar("NOTES", default=None)
"""Where tables note what they are asked; see `schema`."""


def quote(value: object) -> str:
    """A value from a file as it stands in a message: escaped, and never a page long."""
    try:
        text = repr(value)
    except ValueError:  # Python refuses to write out a whole number of thousands of digits
        return "a number of thousands of digits"
    except RecursionError:
        return "a deeply nested list"
    return text if len(text) <= 60 else f"{text[:57]}..."


class Table:
    """One table of a TOML file; each key is asked for once, `finish` refuses those left over.

    Lifetime: while one file is read.
    """

    def __init__(self, path: Path, values: dict[str, Any], place: str = ""):
        self.path = path
        self._values = values
        self.place = place
        self._asked: set[str] = set()
        self._notes = NOTES.get()

    def names(self) -> tuple[str, ...]:
        """The keys that are given, for tables in which any printable name may stand."""
        return tuple(self._printable(key, key, False) for key in self._values)

    def error(self, key: str, problem: Message | str) -> FileError:
        """An error that names the file and the key."""
        name = key if key.isprintable() and 0 < len(key) <= 60 else quote(key)
        return FileError(self.path, FileText.KEY(key=f"{self.place}{name}", problem=problem))

    def has(self, key: str) -> bool:
        """Whether the key is given."""
        self._asked.add(key)
        return key in self._values

    def current_name(self, key: str, old: str) -> str:
        """The name to read a text by: `old`, its former one, where a file still has that.

        Raises:
            FileError: both are given.
        """
        says = {"description": f"is called {key} now", "deprecated": True}
        self._note(old, None, {"type": "string"} | says)
        if not self.has(old):
            return key
        if self.has(key):
            raise self.error(old, f"is called {key} now, and {key} is given too")
        return old

    def is_null(self, key: str) -> bool:
        """Whether the key is given as null, which only JSON has."""
        return self.has(key) and self._values[key] is None

    def text(
        self,
        key: str,
        default: Any = MISSING,
        *,
        among: tuple[str, ...] = (),
        like: str = "",
        empty: bool = False,
    ) -> str:
        """A text, when `among` is given one of those, otherwise a printable one.

        That it is `like` a pattern is left to the caller, who can say it in words.
        """
        form = {"enum": list(among)} if among else {"pattern": f"^{like}$"} if like else {}
        self._note(key, default, {"type": "string"} | form)
        value = self._value(key, str, "a text", default)
        if among and value not in among:
            raise self.error(key, f"{quote(value)} is not one of {', '.join(among)}")
        return self._printable(key, value, empty)

    def flag(self, key: str, default: Any = MISSING) -> bool:
        """True or false."""
        self._note(key, default, {"type": "boolean"})
        return self._value(key, bool, "true or false", default)

    def whole(self, key: str, default: Any = MISSING, *, low: int, high: int) -> int:
        """A whole number, low <= value <= high."""
        self._note(key, default, {"type": "integer", "minimum": low, "maximum": high})
        value = self._value(key, int, "a whole number", default)
        if not low <= value <= high:
            raise self.error(key, f"{quote(value)} is not a whole number from {low} to {high}")
        return value

    def number(
        self, key: str, default: Any = MISSING, *, low: float = -math.inf, high: float = math.inf
    ) -> float:
        """A finite number, low <= value <= high."""
        self._note(key, default, _number_form(low, high))
        value = self._value(key, (int, float), "a number", default)
        return self._check(key, value, low, high)

    def numbers(
        self,
        key: str,
        count: int | tuple[int, int] | None,
        default: Any = MISSING,
        *,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> Floats:
        """A list of finite numbers (count,) in the key's unit.

        Two counts: this many or this many; None: any number of them.
        """
        items = {"type": "array", "items": _number_form(low, high)}
        self._note(key, default, items | _count_schema(count))
        value = self._value(key, (list, np.ndarray), "a list of numbers", default)
        counts = (count,) if isinstance(count, int) else count
        if counts is not None and len(value) not in counts:
            expected_counts = " or ".join(map(str, counts))
            raise self.error(key, f"{expected_counts} numbers are expected, {len(value)} are given")
        return np.array([self._check(key, item, low, high) for item in value])

    def wholes(
        self,
        key: str,
        count: int | tuple[int, int],
        default: Any = MISSING,
        *,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> list[int]:
        """A list of this many whole numbers, or of one of two counts, low <= value <= high."""
        items = _number_form(low, high) | {"type": "integer"}
        self._note(key, default, {"type": "array", "items": items} | _count_schema(count))
        values = self.numbers(key, count, default, low=low, high=high)
        for value in values.tolist():
            if value != round(value):
                raise self.error(key, f"{value:g} is not a whole number")
        return [round(value) for value in values.tolist()]

    def rows(self, key: str, columns: int, default: Any = MISSING) -> Floats:
        """A list of lists of `columns` finite numbers each, (n, columns), in the key's unit."""
        row = {"type": "array", "items": {"type": "number"}}
        self._note(key, default, {"type": "array", "items": row})
        rows = self._rows(key, columns, "numbers", default)
        block = np.empty((len(rows), columns))
        for number, (at, row) in enumerate(rows):
            block[number] = [self._check(at, item, -math.inf, math.inf) for item in row]
        return block

    def text_rows(self, key: str, columns: int) -> list[tuple[str, ...]]:
        """A list of lists of `columns` printable texts each."""
        return [
            tuple(self._text_in_list(at, item) for item in row)
            for at, row in self._rows(key, columns, "texts")
        ]

    def texts(self, key: str, default: Any = MISSING) -> tuple[str, ...]:
        """A list of printable texts."""
        self._note(key, default, {"type": "array", "items": {"type": "string"}})
        value = self._value(key, (list, tuple), "a list of texts", default)
        return tuple(self._text_in_list(key, item) for item in value)

    def table(self, key: str) -> "Table":
        """A table within this one."""
        self._note(key, MISSING, {"type": "object"})
        value = self._value(key, dict, "a table", MISSING)
        return Table(self.path, value, f"{self.place}{key}.")

    def plain(self) -> dict[str, Option]:
        """All keys of this table with plain values, for those who know what they mean."""
        return {key: self._plain(key, self._values[key]) for key in self.names()}

    def tables(self, key: str, default: Any = ()) -> Iterator["Table"]:
        """The tables of an array `[[key]]`; none when it is not given."""
        self._note(key, default, {"type": "array", "items": {"type": "object"}})
        value = self._value(key, list, "an array of tables", default)
        for number, item in enumerate(value, start=1):
            if not isinstance(item, dict):
                raise self.error(
                    key, f"an array of tables is expected, entry {number} is {quote(item)}"
                )
            yield Table(self.path, cast(dict[str, Any], item), f"{self.place}{key}[{number}].")

    def is_array(self, key: str) -> bool:
        """Whether it is given as `[[key]]`, or as another list."""
        return isinstance(self._values.get(key), list)

    def forms(self, key: str) -> list[Any]:
        """A list of whatever the file may hold; none when it is not given."""
        self._note(key, (), {"type": "array"})
        return list(self._value(key, list, "a list", []))

    def finish(self) -> None:
        """Refuse keys that nobody asked for.

        Raises:
            FileError: names the key, one that is spelled like it, and those there are.
        """
        for key in self._values:
            if key not in self._asked:
                near = difflib.get_close_matches(key[:60], self._asked, 1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                known = ", ".join(sorted(self._asked))
                raise self.error(key, f"is not known here{hint} (known: {known})")

    def once(self, key: str, names: Iterable[str]) -> None:
        """Refuse a name that is there twice.

        Raises:
            FileError: names it and the key.
        """
        for name, times in Counter(names).items():
            if times > 1:
                raise self.error(key, f"{quote(name)} is there {times} times")

    def _value(self, key: str, kinds: Any, expected: str, default: Any) -> Any:
        self._asked.add(key)
        if key not in self._values:
            if default is MISSING:
                raise self.error(key, f"is missing; {expected} is expected")
            return default
        value = self._values[key]
        if not isinstance(value, kinds) or (isinstance(value, bool) and kinds is not bool):
            raise self.error(key, f"{expected} is expected, {quote(value)} is given")
        return value

    def _note(self, key: str, default: Any, form: dict[str, Any]) -> None:
        if self._notes is not None:
            place = re.sub(r"\[\d+\]", "[]", f"{self.place}{key}")
            usual = _plain_default(default)
            known = self._notes.setdefault(place, {**form, **usual, "required": True})
            # A key that only some kinds of a table have is not required of all.
            known["required"] = known["required"] and default is MISSING

    def _rows(
        self, key: str, columns: int, of: str, default: Any = MISSING
    ) -> list[tuple[str, list[Any]]]:
        """The rows of a list of lists, each with its place."""
        rows: list[tuple[str, list[Any]]] = []
        for number, row in enumerate(self._value(key, list, f"a list of lists of {of}", default)):
            at = f"{key}[{number + 1}]"
            if not isinstance(row, list):
                raise self.error(
                    at, f"a list of {of} is expected, {quote(cast(object, row))} is given"
                )
            row = cast(list[Any], row)
            if len(row) != columns:
                raise self.error(at, f"{columns} {of} are expected, {len(row)} are given")
            rows.append((at, row))
        return rows

    def _plain(self, key: str, value: Any) -> Option:
        self._asked.add(key)
        if isinstance(value, str):
            return self._printable(key, value, True)
        if not isinstance(value, bool | int | float):
            raise self.error(
                key, f"a text, a number or a flag is expected, {quote(value)} is given"
            )
        return value

    def _text_in_list(self, key: str, value: Any) -> str:
        if not isinstance(value, str):
            raise self.error(key, f"a list of texts is expected, {quote(value)} is in it")
        return self._printable(key, value, False)

    def _printable(self, key: str, value: str, empty: bool) -> str:
        # Names travel into file names, tables and digests; a lone surrogate has no encoding.
        if not value and not empty:
            raise self.error(key, "is an empty text")
        if not value.isprintable():
            raise self.error(key, f"{quote(value)} holds a character that cannot be printed")
        return value

    def _check(self, key: str, value: Any, low: float, high: float) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(key, f"a number is expected, {quote(value)} is given")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        if not math.isfinite(number):
            raise self.error(key, f"a finite number is expected, {quote(value)} is given")
        if not low <= number <= high:
            raise self.error(key, f"{number:g} is not between {low:g} and {high:g}")
        return number


def _plain_default(default: Any) -> dict[str, Any]:
    """What a key is when it is not given, in a schema; nothing where it has to be given."""
    if default is MISSING or default is None:
        return {}
    plain = default.tolist() if isinstance(default, np.ndarray) else default
    if isinstance(plain, float):
        plain = float(f"{plain:.12g}")  # no digits that come from another unit
    return {"default": list(plain) if isinstance(plain, tuple) else plain}


def _count_schema(count: int | tuple[int, int] | None) -> dict[str, int]:
    """How long a list has to be, in a schema."""
    if count is None:
        return {}
    low, high = (count, count) if isinstance(count, int) else count
    return {"minItems": low, "maxItems": high}


def _number_form(low: float, high: float) -> dict[str, Any]:
    form: dict[str, Any] = {"type": "number"}
    if math.isfinite(low):
        form["minimum"] = low
    if math.isfinite(high):
        form["maximum"] = high
    return form


def read_toml(path: Path) -> Table:
    """The top table of a TOML file.

    Raises:
        FileError: the file is not there, too long, not text, or not TOML (with the line).
    """
    content = read_whole(path, LARGEST_FILE)
    try:
        return Table(path, tomllib.loads(content.decode("utf-8-sig")))
    except UnicodeDecodeError:
        raise FileError(path, FileProblem.NOT_TEXT()) from None
    except ValueError as error:  # also of a number with more digits than Python will read
        raise FileError(path, FileProblem.NOT_VALID(kind="TOML", detail=str(error))) from None
    except RecursionError:
        raise FileError(path, "is nested too deeply") from None
