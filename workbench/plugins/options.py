"""The keys that a plug-in has of its own in a cell file: a frozen dataclass says which.

Each field is a `float`, `int`, `str` or `bool` with a default, or without one where the key has to
be given; `option` adds limits and words.  Values are checked when the file is read, again when the
plug-in is made, and `cell.schema.json` shows them.
"""

import dataclasses
import math
from collections.abc import Mapping
from typing import Any, get_type_hints

from workbench.model.errors import InputError
from workbench.model.scan import Option

Options = Mapping[str, Option]
"""Checked keys and values; empty where nothing was given."""

OPTION_TYPES: dict[type, tuple[str, str]] = {
    bool: ("boolean", "true or false"),
    int: ("integer", "a whole number"),
    float: ("number", "a number"),
    str: ("string", "a text"),
}


class NoOptions:
    """Of a plug-in that has no keys of its own."""


def option(
    default: Any = dataclasses.MISSING,
    *,
    low: float = -math.inf,
    high: float = math.inf,
    among: tuple[str, ...] = (),
    says: str = "",
) -> Any:
    """A field of an options dataclass with limits, choices, and what it means in a few words."""
    metadata = {"low": low, "high": high, "among": among, "says": says}
    return dataclasses.field(default=default, metadata=metadata)


def options_of(kind: type, given: Options) -> Any:
    """The options dataclass `kind` with what was given.

    Raises:
        InputError: a key is unknown or missing, or a value is not what its field expects.
    """
    if not dataclasses.is_dataclass(kind):
        if given:
            raise InputError(f"{next(iter(given))} is not known here; there are no such keys")
        return kind()
    fields = {field.name: field for field in dataclasses.fields(kind)}
    hints = get_type_hints(kind)
    for key in given:
        if key not in fields:
            raise InputError(f"{key} is not known here (known: {', '.join(fields)})")
    for name, field in fields.items():
        if name not in given and field.default is dataclasses.MISSING:
            raise InputError(f"{name} is missing; {OPTION_TYPES[hints[name]][1]} is expected")
    checked = {key: _check(fields[key], hints[key], value) for key, value in given.items()}
    return kind(**checked)


def schema_of(kind: type) -> dict[str, Any]:
    """The JSON Schema of an options dataclass."""
    properties: dict[str, Any] = {}
    required: list[str] = []
    if dataclasses.is_dataclass(kind):
        hints = get_type_hints(kind)
        for field in dataclasses.fields(kind):
            form: dict[str, Any] = {"type": OPTION_TYPES[hints[field.name]][0]}
            low, high = _limits(field)
            form |= {"minimum": low} if math.isfinite(low) else {}
            form |= {"maximum": high} if math.isfinite(high) else {}
            if among := field.metadata.get("among"):
                form["enum"] = list(among)
            if says := field.metadata.get("says"):
                form["description"] = says
            if field.default is dataclasses.MISSING:
                required.append(field.name)
            else:
                form["default"] = field.default
            properties[field.name] = form
    return {
        "type": "object",
        "properties": properties,
        "required": required,
        "additionalProperties": False,
    }


def _limits(field: "dataclasses.Field[Any]") -> tuple[float, float]:
    return field.metadata.get("low", -math.inf), field.metadata.get("high", math.inf)


def _is_finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:  # a whole number beyond all others
        return False


def _check(field: "dataclasses.Field[Any]", kind: type, value: Any) -> Any:
    expected = OPTION_TYPES[kind][1]
    is_right = isinstance(value, (int, float) if kind is float else kind)
    if not is_right or (isinstance(value, bool) and kind is not bool):
        raise InputError(f"{field.name}: {expected} is expected, {value!r} is given")
    if kind in (int, float):
        low, high = _limits(field)
        if not (_is_finite(value) and low <= value <= high):
            raise InputError(f"{field.name}: {value!r} is not between {low:g} and {high:g}")
    among = field.metadata.get("among", ())
    if among and value not in among:
        raise InputError(f"{field.name}: {value!r} is not one of {', '.join(among)}")
    return float(value) if kind is float else value
