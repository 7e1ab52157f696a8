"""The canonical form of every value, its digest, and its short form for people.

The canonical form is JSON: a dataclass becomes an object of its fields, a pose its 4 x 4 matrix.
An array becomes nested lists, a large array its digest and shape.  The plan file has this form, so
anybody can recompute its digest with a JSON library and SHA-256.
"""

import dataclasses
import enum
import hashlib
import json
import weakref
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from typing import Any, cast

import numpy as np
import pinocchio as pin

from workbench.model.messages.message import Message

LATER = {"later": True}
"""Metadata of a field that came when digests were in use: at its default it does not enter them,
so that they stay as they were."""


def called(name: str) -> dict[str, str]:
    """Metadata of a field that was renamed: it enters digests by its first name, as ever."""
    return {"called": name}


LARGE = 4096
"""Arrays with more elements than this enter by the digest of their bytes."""


class Shared:
    """A value that many others hold, as cells hold a robot: its canonical text is made once."""

    __slots__ = ("__weakref__",)


class FactsRepr:
    """A value with a summary in one line, and as a table in a notebook.

    The dataclass that derives from it is made with `repr=False`: all fields of a cell fill a book.
    """

    __slots__ = ()

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it, by names."""
        return {}

    def __repr__(self) -> str:
        """The facts in a line."""
        facts = ", ".join(f"{name}: {fact}" for name, fact in self.facts.items())
        return f"<{type(self).__name__} {facts}>"

    def _repr_html_(self) -> str:
        """The facts as a table, for notebooks; names may hold anything."""
        rows = "".join(
            f"<tr><th style='text-align:left'>{escape(name)}</th>"
            f"<td style='text-align:left'>{escape(str(fact))}</td></tr>"
            for name, fact in self.facts.items()
        )
        return f"<table><caption>{type(self).__name__}</caption>{rows}</table>"


def canonical(value: Any, *, without: frozenset[str] = frozenset()) -> Any:
    """The JSON-able form of a value.

    Args:
        value: dataclass, mapping, sequence, array, pose, enum, number, text or None.
        without: field names of the outermost dataclass to leave out.  A field named `digest`
            is always left out.

    Raises:
        TypeError: for a type that has no canonical form.
    """
    match value:
        case None | str() | bool() | int():
            return value
        case enum.Enum():
            return value.value
        case float() | np.floating():
            return float(value) + 0.0  # -0.0 and 0.0 are the same number
        case np.integer():
            return int(value)
        case Message():
            return value.form
        case pin.SE3():
            return (value.homogeneous + 0.0).tolist()
        case np.ndarray():
            return _canonical_array(value)
        case Mapping():
            return {str(key): canonical(item) for key, item in value.items()}
        case list() | tuple():
            return [canonical(item) for item in value]
        case frozenset() | set():
            return sorted(canonical(item) for item in value)
        case _ if dataclasses.is_dataclass(value):
            return {name: canonical(item) for name, item in _entering(value, without)}
        case _:
            raise TypeError(f"no canonical form for {type(value).__name__}")


def _entering(value: Any, without: frozenset[str]) -> Iterator[tuple[str, Any]]:
    """The fields of a dataclass that enter its canonical form, by their names there."""
    left_out = without | {"digest"}
    for field in dataclasses.fields(value):
        if field.name not in left_out and not _is_silent(field, value):
            yield field.metadata.get("called", field.name), getattr(value, field.name)


def _is_silent(field: "dataclasses.Field[Any]", owner: Any) -> bool:
    """Whether a field does not enter: what is derived from others, and `LATER` ones not used."""
    if field.metadata.get("derived"):
        return True
    if not field.metadata.get("later"):
        return False
    value, default = getattr(owner, field.name), field.default
    if field.default_factory is not dataclasses.MISSING:
        default = field.default_factory()
    return not isinstance(value, np.ndarray) and bool(value == default)


def digest_of(value: Any, *, without: frozenset[str] = frozenset()) -> str:
    """SHA-256 over the canonical form, as 64 hexadecimal digits."""
    return hashlib.sha256(_text_of(value, without).encode()).hexdigest()


_texts: dict[int, tuple[weakref.ref[Shared], str]] = {}
"""Of shared values by their `id`, as long as they live."""


def _text_of(value: Any, without: frozenset[str] = frozenset()) -> str:
    """The canonical form as JSON, with sorted keys and without blanks."""
    match value:
        case Shared() if not without:
            known = _texts.get(id(value))
            if known is None or known[0]() is not value:
                number, text = id(value), _object_text(value, without)
                known = (weakref.ref(value, lambda _: _texts.pop(number, None)), text)
                _texts[number] = known
            return known[1]
        case list() | tuple():
            return f"[{','.join(_text_of(item) for item in cast(Sequence[Any], value))}]"
        case _ if dataclasses.is_dataclass(value) and not isinstance(value, Message):
            return _object_text(value, without)
        case _:
            return json.dumps(
                canonical(value),
                sort_keys=True,
                separators=(",", ":"),
                ensure_ascii=False,
                allow_nan=True,
            )


def _object_text(value: Any, without: frozenset[str]) -> str:
    texts = sorted((name, _text_of(item)) for name, item in _entering(value, without))
    return "{" + ",".join(f"{json.dumps(name)}:{text}" for name, text in texts) + "}"


def _canonical_array(array: np.ndarray) -> Any:
    if array.size <= LARGE:
        return (array + 0.0 if array.dtype.kind == "f" else array).tolist()
    block = np.ascontiguousarray(array)
    return {
        "shape": list(block.shape),
        "type": block.dtype.str,
        "sha256": hashlib.sha256(block.data).hexdigest(),
    }
