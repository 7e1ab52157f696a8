"""The last step before a browser: all texts of viser's messages in its language.

Widgets hold English, here and in all code that reads them.  Of a choice the browser sends back what
it was shown, which is English again before a widget hears it.
"""

# pyright: reportPrivateUsage=false

import copy
import dataclasses
from collections.abc import Callable, Mapping
from typing import Any

import viser
from viser import _messages as messages

from workbench.words.words import ENGLISH, Words

Say = Callable[[Any], Any]


def speak(client: viser.ClientHandle, words: Words) -> None:
    """Translate all texts for a browser from now on; called before any widget is created."""
    if words.language == ENGLISH:
        return
    connection = client._websock_connection
    queue = connection.queue_message
    choices: dict[str, dict[str, str]] = {}
    said = _by_field(words)

    def queue_said(message: Any) -> None:
        queue(_translate(message, said, words, choices))

    async def take_update(client_id: Any, message: Any) -> None:
        english = choices.get(getattr(message, "uuid", ""))
        if english is not None and isinstance(message, messages.GuiUpdateMessage):
            value = message.updates.get("value")
            if isinstance(value, str):
                message = dataclasses.replace(message, updates={"value": english.get(value, value)})
        await hear(client_id, message)

    connection.queue_message = queue_said
    # In English before it is compared with what a widget offers.
    hear = connection._handle_incoming_message
    connection._handle_incoming_message = take_update


def _by_field(words: Words) -> Mapping[str, Say]:
    """How the text of each field of viser's messages is put in another language."""

    def each(texts: tuple[str, ...]) -> tuple[str, ...]:
        return tuple(map(words.say, texts))

    def lines(text: str) -> str:
        return "\n".join(map(words.say, text.split("\n")))

    return {
        "label": words.say,
        "hint": words.say,
        "title": words.say,
        "body": words.say,
        "description": words.say,
        "text": lines,
        "content": words.html,
        "_markdown": words.markdown,
        "_tab_labels": each,
    }


def _translate(
    message: Any,
    said: Mapping[str, Say],
    words: Words,
    choices: dict[str, dict[str, str]],
) -> Any:
    """A message with its texts in another language; the widget that it is of keeps its own."""
    updates: dict[str, Any] | None = getattr(message, "updates", None)
    if updates is not None:
        message = copy.copy(message)
        new = _fields(updates, said)
        uuid: str = getattr(message, "uuid", "")
        if uuid in choices:
            if "options" in updates:
                choices[uuid] = _choices(updates["options"], words)
            _choose(new, choices[uuid])
        message.updates = new
        return message
    props: Any = getattr(message, "props", None)
    if props is None:
        return _with(message, _fields(vars(message), said))
    new = _fields(vars(props), said)
    if isinstance(message, messages.GuiDropdownMessage):
        choices[message.uuid] = _choices(props.options, words)
        chosen: dict[str, Any] = {"options": props.options, "value": message.value}
        _choose(chosen, choices[message.uuid])
        message = _with(message, {"value": chosen["value"]})
        new["options"] = chosen["options"]
    return _with(message, {"props": _with(props, new)})


def _fields(fields: Mapping[str, Any], said: Mapping[str, Say]) -> dict[str, Any]:
    return {
        name: said[name](value) if name in said and value else value
        for name, value in fields.items()
    }


def _with(message: Any, fields: Mapping[str, Any]) -> Any:
    """A copy with other fields: what is queued is not what the widget holds."""
    message = copy.copy(message)
    for name, value in fields.items():
        setattr(message, name, value)
    return message


def _choices(options: tuple[str, ...], words: Words) -> dict[str, str]:
    """What may be chosen, in English by what is shown; what reads alike is shown in English."""
    shown: dict[str, str] = {}
    for option in options:
        text = words.say(option)
        shown[option if text in shown else text] = option
    return shown


def _choose(fields: dict[str, Any], english: Mapping[str, str]) -> None:
    shown = {option: text for text, option in english.items()}
    if "options" in fields:
        fields["options"] = tuple(shown[option] for option in fields["options"])
    if "value" in fields:
        fields["value"] = shown.get(fields["value"], fields["value"])
