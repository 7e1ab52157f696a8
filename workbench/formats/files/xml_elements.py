"""Strict reading of XML elements: every number checked, every error with file and place."""

import math
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from xml.parsers import expat

import numpy as np

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import MB, read_whole
from workbench.model.errors import FileError
from workbench.model.geometry import Floats

LARGEST_FILE = 20 * MB

LINE = "workbench-line"
"""The attribute in which an element carries its line, with the file where that is another one."""


class _Doctype(Exception):
    pass


class _Builder(ElementTree.TreeBuilder):
    """Stops at a document type: entities, of which few lines can unfold to gigabytes, need one."""

    def doctype(self, name: str, pubid: str | None, system: str | None) -> None:
        raise _Doctype


class Element:
    """One XML element with its file and its place in it, for messages."""

    def __init__(self, path: Path, element: ElementTree.Element, place: str):
        self.path = path
        self.place = place
        self.tag = element.tag
        self._element = element

    @property
    def line(self) -> str:
        """Its line in its file, such as ", line 7"; empty where nobody recorded it."""
        return self._element.get(LINE, "")

    def error(self, problem: str) -> FileError:
        """An error that names the file and the element."""
        return FileError(self.path, f"{self.place}: {problem}")

    def with_name(self, name: str) -> "Element":
        """The same element, called by its name in messages."""
        return Element(self.path, self._element, f"{self.tag} {quote(name)}")

    def all(self, tag: str) -> Iterator["Element"]:
        """The children of that tag, in order."""
        for element in self._element.findall(tag):
            yield self._inside(element)

    def one(self, tag: str) -> "Element | None":
        """The child of that tag, None when there is none; two are an error."""
        found = self._element.findall(tag)
        if len(found) > 1:
            raise self.error(f"has {len(found)} <{tag}>, one is expected")
        return self._inside(found[0]) if found else None

    def only(self) -> "Element":
        """The single child, whatever its tag."""
        if len(self._element) != 1:
            raise self.error(f"holds {len(self._element)} elements, one is expected")
        return self._inside(self._element[0])

    def text(self, key: str, default: str | None = None) -> str:
        """A printable attribute; without a default it must be given and not be empty."""
        value = self._element.get(key)
        if not value and default is not None:
            return default
        if value is None:
            raise self.error(f"has no {key}")
        if not value or not value.isprintable():
            raise self.error(f"{key}={quote(value)}: a name is expected")
        return value

    def numbers(self, key: str, count: int, default: tuple[float, ...] | None = None) -> Floats:
        """Finite numbers (count,) in the attribute's unit; without a default it must be given."""
        if default is not None and self._element.get(key) is None:
            return np.array(default, dtype=np.float64)
        value = self.text(key)
        try:
            numbers = [_number(word) for word in value.split()]
        except ValueError:
            numbers = []
        if len(numbers) != count:
            expected = "one number is" if count == 1 else f"{count} numbers are"
            hint = " (expand the file with xacro first)" if "${" in value else ""
            raise self.error(f"{key}={quote(value)}: {expected} expected{hint}")
        return np.array(numbers)

    def number(self, key: str, default: float | None = None) -> float:
        """An attribute of one finite number."""
        return float(self.numbers(key, 1, None if default is None else (default,))[0])

    def _inside(self, element: ElementTree.Element) -> "Element":
        return Element(self.path, element, f"{self.place}, {_tag(element.tag)}")


def read_xml(path: Path, tag: str) -> Element:
    """The root of an XML file that must be of that tag.

    Raises:
        FileError: not there, too long, not XML, with a document type, or of another tag.
    """
    return parse_xml(path, read_whole(path, LARGEST_FILE), tag)


def parse_xml(path: Path, content: bytes, tag: str) -> Element:
    """As `read_xml`, of a text that belongs to `path`.

    Raises:
        FileError: not XML, with a document type, or of another tag.
    """
    try:
        root = ElementTree.fromstring(content, ElementTree.XMLParser(target=_Builder()))
    except _Doctype:
        raise FileError(path, "declares a document type (<!DOCTYPE>), which is not read") from None
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        raise FileError(path, f"is not valid XML: {str(error)[:100]}") from None
    if root.tag != tag:
        raise FileError(path, f"starts with {_tag(root.tag)}, <{tag}> is expected")
    if LINE.encode() not in content:
        for element, line in zip(root.iter(), start_lines(content), strict=True):
            element.set(LINE, f", line {line}")
    return Element(path, root, f"<{tag}>")


def start_lines(content: bytes) -> list[int]:
    """The line in which each element of an XML text starts, in the order of the document.

    Raises:
        ExpatError: it is not XML.
    """
    lines: list[int] = []
    parser = expat.ParserCreate()

    def start(tag: str, attributes: dict[str, str]) -> None:
        lines.append(parser.CurrentLineNumber)

    parser.StartElementHandler = start
    parser.Parse(content, True)
    return lines


def _tag(tag: str) -> str:
    return f"<{tag}>" if tag.isprintable() and len(tag) <= 60 else f"<{quote(tag)}>"


def _number(word: str) -> float:
    value = float(word)
    if not math.isfinite(value) or "_" in word:
        raise ValueError
    return value
