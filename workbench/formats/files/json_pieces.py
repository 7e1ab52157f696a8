"""Large values as JSON, made piece by piece.

Python's own encoder makes all of it in one go, and no other thread of the process runs meanwhile:
for the candidates of a full bin that is a third of a second.
"""

import json
from collections.abc import Callable, Iterator
from typing import Any, cast

MOST_LEVELS = 5
"""Levels of lists and objects that are split; what lies deeper is small."""


def encode_json(value: Any, *, allow_nan: bool = False) -> bytes:
    """A value as JSON without spaces, in UTF-8.

    Args:
        value: what JSON can hold.
        allow_nan: whether numbers may be none, which JSON has no word for.

    Raises:
        ValueError: a number is none, and may not be.
        TypeError: it holds what JSON cannot.
    """
    encode = json.JSONEncoder(ensure_ascii=False, allow_nan=allow_nan, separators=(",", ":")).encode
    return "".join(pieces(value, encode, 0)).encode()


def pieces(value: Any, encode: Callable[[Any], str], depth: int) -> Iterator[str]:
    """The pieces of a value that lies at a depth; plain numbers of a list are one together."""
    is_split = depth < MOST_LEVELS and bool(value)
    if is_split and isinstance(value, dict) and all(type(key) is str for key in cast(Any, value)):
        before = "{"
        for key, item in cast(dict[str, Any], value).items():
            yield f"{before}{encode(key)}:"
            yield from pieces(item, encode, depth + 1)
            before = ","
        yield "}"
    elif is_split and isinstance(value, list | tuple):
        items = cast(list[Any], value)
        if not isinstance(items[0], list | tuple | dict):
            yield encode(items)
            return
        before = "["
        for item in items:
            yield before
            yield from pieces(item, encode, depth + 1)
            before = ","
        yield "]"
    else:
        yield encode(value)
