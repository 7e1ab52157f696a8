"""All texts by their ids, and the way back from JSON to a message."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, cast

from workbench.model.messages import (
    calibration,
    cells,
    changes,
    commands,
    devices,
    files,
    grasps,
    message,
    parts,
    plans,
    proofs,
    refusals,
    states,
    verdicts,
    work,
)
from workbench.model.messages.message import GROUPED, UNITS, FoundPart, Message, Text, plain

FILES = (
    message,
    verdicts,
    plans,
    proofs,
    states,
    refusals,
    changes,
    calibration,
    cells,
    commands,
    grasps,
    parts,
    files,
    work,
    devices,
)

SUBJECTS: tuple[type[Text], ...] = tuple(
    kind
    for file in FILES
    for kind in vars(file).values()
    if isinstance(kind, type) and issubclass(kind, Text) and kind.__module__ == file.__name__
    if kind is not Text
)

TEXTS: Mapping[str, Text] = MappingProxyType(
    {text.id: text for subject in SUBJECTS for text in subject}
)


MOST_LEVELS = 12
"""Messages within messages that are read."""


def message_of(form: Any, depth: int = MOST_LEVELS) -> Message:
    """The message whose JSON this is: a text without an id, or one with its arguments.

    One whose id or arguments this version does not know reads as both.

    Raises:
        KeyError, TypeError, ValueError: it is no form of a message.
    """
    if isinstance(form, str):
        return plain(form)
    if depth == 0:
        raise ValueError("messages lie too deep in each other")
    args = {str(name): _arg(arg, depth) for name, arg in dict(form["args"]).items()}
    text = TEXTS.get(form["id"])
    if text is None or not _fits(text, args):
        shown = ", ".join(f"{name} {arg}" for name, arg in args.items())
        return plain(f"{form['id']}: {shown}" if shown else str(form["id"]))
    return Message(text, args)


def _fits(text: Text, args: Mapping[str, Any]) -> bool:
    """Whether arguments are those of a text, with numbers where it shows numbers."""
    is_number = {name: isinstance(arg, int | float) for name, arg in args.items()}
    return args.keys() == text.places.keys() and all(
        is_number[name] or not how & {*UNITS, GROUPED, "|"} for name, how in text.places.items()
    )


def _arg(form: Any, depth: int) -> Any:
    match form:
        case {"part": int(index)}:
            return FoundPart(index)
        case {"id": _}:
            return message_of(form, depth - 1)
        case list():
            return tuple(_arg(item, depth - 1) for item in cast(list[Any], form))
        case str() | int() | float():
            return form
        case _:
            raise TypeError(f"{form!r:.60} is no argument of a message")
