"""What a request may carry: each field with its JSON Schema, which is also what is checked."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.formats.files.json_keys import parse_object
from workbench.formats.files.toml_keys import quote
from workbench.model.errors import InputError

LARGEST_BODY = 64 * 1024
"""[bytes]"""

REQUIRED: Any = object()

BODY = Path("the body")
"""What messages call it."""


@dataclass(frozen=True, slots=True)
class Field:
    """One key of a body.

    `schema` uses `type` (one of integer, number, string, boolean), `minimum`, `maximum`,
    `maxLength`, `pattern` and `enum`, nothing else; without a `default` the key must be given.
    Where there are `items`, an array of up to `most` of them is taken, too: `+` joins them.
    """

    name: str
    says: str
    schema: Mapping[str, Any]
    default: Any = REQUIRED
    items: Mapping[str, Any] | None = None
    most: int = 100

    @property
    def is_required(self) -> bool:
        """Whether it must be given."""
        return self.default is REQUIRED


def number_schema(low: float, high: float) -> Mapping[str, Any]:
    """The schema of a number between two others."""
    return {"type": "number", "minimum": low, "maximum": high}


def whole_schema(low: int, high: int) -> Mapping[str, Any]:
    """The schema of a whole number between two others."""
    return {"type": "integer", "minimum": low, "maximum": high}


def text_schema(longest: int) -> Mapping[str, Any]:
    """The schema of a text that has no more than `longest` characters."""
    return {"type": "string", "maxLength": longest}


def body_of(content: bytes, fields: Sequence[Field]) -> dict[str, Any]:
    """The values of a body: those given, and the defaults of the others.

    Args:
        content: as it came; nothing at all is an empty object.
        fields: that may be in it.

    Raises:
        InputError: not a JSON object, a key that is not known, missing or there twice, or a value
            that its schema does not admit.
    """
    given = parse_object(BODY, content) if content.strip() else {}
    known = {field.name for field in fields}
    for name in given:
        if name not in known:
            there = ", ".join(sorted(known)) or "none"
            raise InputError(f"the key {quote(name)} is not known; there are {there}")
    return {field.name: _value(field, given) for field in fields}


def _value(field: Field, given: Mapping[str, Any]) -> Any:
    if field.name in given:
        value = given[field.name]
        if field.items is not None and isinstance(value, list):
            return _joined(field, field.items, value)
        return _check(field.name, value, field.schema)
    if field.is_required:
        raise InputError(f"the key {field.name} is missing: {field.says}")
    return field.default


def _joined(field: Field, items: Mapping[str, Any], values: list[Any]) -> str:
    if len(values) > field.most:
        raise InputError(f"{field.name} may have {field.most} entries, not {len(values)}")
    joined = "+".join(_check(field.name, value, items) for value in values)
    return _check(field.name, joined, field.schema)


def _check(name: str, value: Any, schema: Mapping[str, Any]) -> Any:
    match schema["type"]:
        case "integer" | "number" as kind:
            return _number(name, value, schema, is_whole=kind == "integer")
        case "boolean":
            if not isinstance(value, bool):
                raise InputError(f"{name} must be true or false, not {quote(value)}")
            return value
        case _:
            return _text(name, value, schema)


def _number(name: str, value: Any, schema: Mapping[str, Any], *, is_whole: bool) -> int | float:
    low, high = schema["minimum"], schema["maximum"]
    words = f"{name} must be a {'whole number' if is_whole else 'number'} from {low} to {high}"
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not low <= value <= high:
        raise InputError(f"{words}, not {quote(value)}")
    if not is_whole:
        return float(value)
    # For JSON, 1.0 is a whole number.
    if value != int(value):
        raise InputError(f"{words}, not {quote(value)}")
    return int(value)


def _text(name: str, value: Any, schema: Mapping[str, Any]) -> str:
    if not isinstance(value, str):
        raise InputError(f"{name} must be a text, not {quote(value)}")
    if "enum" in schema and value not in schema["enum"]:
        raise InputError(f"{name} must be one of {', '.join(schema['enum'])}, not {quote(value)}")
    if len(value) > schema.get("maxLength", LARGEST_BODY):
        raise InputError(f"{name} may have {schema['maxLength']} characters, not {len(value)}")
    if "pattern" in schema and re.fullmatch(schema["pattern"], value) is None:
        raise InputError(f"{name} must look like {schema['pattern']}, not {quote(value)}")
    return value
