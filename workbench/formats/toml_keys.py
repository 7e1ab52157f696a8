"""Strict reading of TOML: every key known, every value of its kind, every error with its place."""

import difflib
import math
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from workbench.model.errors import FileError
from workbench.model.geometry import Floats

LARGEST_FILE = 4 * 1024 * 1024
"""[bytes] Nobody writes a longer cell or grasp file by hand."""

MISSING: Any = object()


class Table:
    """One table of a TOML file; each key is asked for once, `finish` refuses those left over.

    Lifetime: while one file is read.
    """

    def __init__(self, path: Path, values: dict[str, Any], place: str = ""):
        self.path = path
        self._values = values
        self._place = place
        self._asked: set[str] = set()

    def error(self, key: str, problem: str) -> FileError:
        """An error that names the file and the key."""
        return FileError(self.path, f"key {self._place}{key}: {problem}")

    def has(self, key: str) -> bool:
        """Whether the key is given."""
        self._asked.add(key)
        return key in self._values

    def text(self, key: str, default: Any = MISSING, *, among: tuple[str, ...] = ()) -> str:
        """A text, when `among` is given one of those."""
        value = self._value(key, str, "a text", default)
        if among and value not in among:
            raise self.error(key, f"{value!r} is not one of {', '.join(among)}")
        return value

    def flag(self, key: str, default: Any = MISSING) -> bool:
        """True or false."""
        return self._value(key, bool, "true or false", default)

    def whole(self, key: str, default: Any = MISSING, *, low: int, high: int) -> int:
        """A whole number, low <= value <= high."""
        value = self._value(key, int, "a whole number", default)
        if isinstance(value, bool) or not low <= value <= high:
            raise self.error(key, f"{value!r} is not a whole number from {low} to {high}")
        return value

    def number(
        self, key: str, default: Any = MISSING, *, low: float = -math.inf, high: float = math.inf
    ) -> float:
        """A finite number, low <= value <= high."""
        value = self._value(key, (int, float), "a number", default)
        return self._checked(key, value, low, high)

    def numbers(
        self,
        key: str,
        count: int | None,
        default: Any = MISSING,
        *,
        low: float = -math.inf,
        high: float = math.inf,
    ) -> Floats:
        """A list of finite numbers, shape (count,); count None: any number of them."""
        value = self._value(key, (list, np.ndarray), "a list of numbers", default)
        if count is not None and len(value) != count:
            raise self.error(key, f"{count} numbers are expected, {len(value)} are given")
        return np.array([self._checked(key, item, low, high) for item in value])

    def texts(self, key: str, default: Any = MISSING) -> tuple[str, ...]:
        """A list of texts."""
        value = self._value(key, (list, tuple), "a list of texts", default)
        for item in value:
            if not isinstance(item, str):
                raise self.error(key, f"a list of texts is expected, {item!r} is in it")
        return tuple(value)

    def table(self, key: str) -> "Table":
        """A table within this one."""
        value = self._value(key, dict, "a table", MISSING)
        return Table(self.path, value, f"{self._place}{key}.")

    def tables(self, key: str) -> Iterator["Table"]:
        """The tables of an array `[[key]]`; none when it is not given."""
        value = self._value(key, list, "an array of tables", [])
        for number, item in enumerate(value, start=1):
            if not isinstance(item, dict):
                raise self.error(key, f"an array of tables is expected, entry {number} is {item!r}")
            yield Table(self.path, item, f"{self._place}{key}[{number}].")

    def finish(self) -> None:
        """Refuse keys that nobody asked for.

        Raises:
            FileError: names the key, one that is spelled like it, and those there are.
        """
        for key in self._values:
            if key not in self._asked:
                near = difflib.get_close_matches(key, self._asked, 1)
                hint = f"; did you mean {near[0]!r}?" if near else ""
                known = ", ".join(sorted(self._asked))
                raise self.error(key, f"is not known here{hint} (known: {known})")

    def _value(self, key: str, kinds: Any, expected: str, default: Any) -> Any:
        self._asked.add(key)
        if key not in self._values:
            if default is MISSING:
                raise self.error(key, f"is missing; {expected} is expected")
            return default
        value = self._values[key]
        if not isinstance(value, kinds) or (isinstance(value, bool) and kinds is not bool):
            raise self.error(key, f"{expected} is expected, {value!r} is given")
        return value

    def _checked(self, key: str, value: Any, low: float, high: float) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float | np.floating):
            raise self.error(key, f"a number is expected, {value!r} is given")
        if not math.isfinite(value):
            raise self.error(key, f"a finite number is expected, {value} is given")
        if not low <= value <= high:
            raise self.error(key, f"{value:g} is not between {low:g} and {high:g}")
        return float(value)


def read_toml(path: Path) -> Table:
    """The top table of a TOML file.

    Raises:
        FileError: the file is not there, too long, not text, or not TOML (with the line).
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise FileError(path, f"is longer than {LARGEST_FILE // 1024 // 1024} MB")
        return Table(path, tomllib.loads(path.read_text(encoding="utf-8")))
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be read") from None
    except UnicodeDecodeError:
        raise FileError(path, "is not a text file in UTF-8") from None
    except tomllib.TOMLDecodeError as error:
        raise FileError(path, f"is not valid TOML: {error}") from None
    except RecursionError:
        raise FileError(path, "is nested too deeply") from None
