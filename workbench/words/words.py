"""One language: messages by their ids, and what is said in English without one."""

import re
import threading
from collections.abc import Mapping
from functools import cache
from typing import Any, cast

from workbench.model.messages.catalogue import TEXTS
from workbench.model.messages.message import Message, Others, Text, plain
from workbench.words.catalogs import CATALOGS, LANGUAGES, Catalog
from workbench.words.markup import html_said, markdown_said
from workbench.words.templates import Template, Templates, filled

ENGLISH = "en"

NO_VALUES: Mapping[str, str] = {}

MOST_KEPT = 20_000
"""Texts that are remembered: most of a page is said again and again."""

DEEPEST = 4
"""A sentence may hold a reason, and that one a name of something; no deeper."""

_ENDS = re.compile(r"([\s,;:·]*)(.*?)([\s,;(]*)", re.DOTALL)

_JOINTS = tuple(
    re.compile(f"({joint})")
    for joint in (
        r"\n",
        r"(?<=[.!?…]) +",
        r"; ",
        r" · ",
        r" \(|\)",
        r" \[|\]",
        r": ",
        r", ",
        r" and ",
        r" at ",
        r" (?=part-\d|in \d)",
        r"(?:(?<=\s)|^)[-+−]?\d[\d.,]*(?:°| %| (?:deg|mm|ms|s)\b)?(?=\s|$)",
        r" ?[▴▾]",
    )
)
"""Where a text that is no message is cut, strongest first: it was put together from several."""


class Words:
    """Puts texts in one language; what has no translation stays as it is.

    Concurrency: any thread.
    """

    def __init__(
        self, language: str, messages: Mapping[str, str], by_id: Mapping[str, str] = NO_VALUES
    ):
        """The words of a language: by English message, and templates by the ids of messages."""
        self.language = language
        self._by_id = {id: said for id, said in by_id.items() if said}
        # Texts that have no id yet hold others that have one: what a task is called.
        whole = {TEXTS[id].template: said for id, said in self._by_id.items() if id in TEXTS}
        whole = {key: said for key, said in whole.items() if "{" not in key}
        self._messages = {key: said for key, said in (whole | dict(messages)).items() if said}
        self._plain = {_bare(key): key for key in self._messages}
        # What reads alike in both would only stand before a message that says more.
        self._templates = Templates(key for key, said in self._messages.items() if key != said)
        self._stop = "。" if language == "zh" else "."
        self._kept: dict[str, str] = {}
        self._rendered: set[str] = set()
        self._lock = threading.Lock()

    def render(self, message: Message | str | None) -> str:
        """A message in this language, by its id; of none an empty text.

        A text without an id is looked for as `say` does.
        """
        if not message:
            return ""
        if isinstance(message, str):
            text = self.say(message)
            is_new = text != message
        else:
            text, is_new = self._said_within(message).rendered(self._template), True
        if self._messages and is_new:
            with self._lock:
                if len(self._rendered) >= MOST_KEPT:
                    self._rendered.clear()
                for end in ("", "."):
                    self._rendered |= {text + end, text[:1].upper() + text[1:] + end}
        return text

    def _template(self, text: Text) -> str:
        return self._by_id.get(text.id, text.template)

    def _said_within(self, message: Message) -> Message:
        """The message with the texts in it that have no id yet put in this language."""
        if message.text is Others.PLAIN:
            return plain(self.say(str(message)))
        args = {name: self._translate_arg(arg) for name, arg in message.args.items()}
        return Message(message.text, args)

    def _translate_arg(self, arg: Any) -> Any:
        if isinstance(arg, tuple):
            return tuple(map(self._translate_arg, cast(tuple[Any, ...], arg)))
        return self._said_within(arg) if isinstance(arg, Message) else arg

    def say(self, text: str) -> str:
        """A text in this language; the white space around it, and names and numbers in it, stay."""
        if not self._messages:
            return text
        kept = self._kept.get(text)
        if kept is None:
            kept = self._found(text.replace("\u00a0", " "), DEEPEST) or text
            with self._lock:
                if len(self._kept) >= MOST_KEPT:
                    self._kept.clear()
                self._kept[text] = kept
        return kept

    def html(self, text: str) -> str:
        """HTML with its texts, and what its elements say when they are pointed at."""
        return html_said(text, self.say) if self._messages else text

    def markdown(self, text: str) -> str:
        """Markdown with its texts."""
        return markdown_said(text, self.say) if self._messages else text

    def _found(self, text: str, depth: int) -> str | None:
        """A text in this language; None where it holds no message."""
        if text in self._rendered:
            return text
        before, text, behind = split_ends(text)
        said = self._said(text, depth) if text else None
        return None if said is None else f"{before}{said}{behind}"

    def _said(self, text: str, depth: int) -> str | None:
        key = text if text in self._messages else self._plain.get(_bare(text))
        if key is not None:
            return self._as(text, key)
        return (
            self._fitted(text, depth, self._templates.clear)
            or self._joined(text, depth)
            or self._fitted(text, depth, self._templates.vague)
        )

    def _fitted(self, text: str, depth: int, templates: tuple[Template, ...]) -> str | None:
        """A sentence by the message that it is of, with what stands at its places."""
        for sentence, end in _with_ends(text):
            for template in templates:
                values = template.fitted(sentence)
                if values is not None:
                    said = {
                        name: (self._found(value, depth - 1) if depth else None) or value
                        for name, value in values.items()
                    }
                    return self._as(sentence, template.message, said) + end.replace(".", self._stop)
        return None

    def _as(self, text: str, message: str, values: Mapping[str, str] = NO_VALUES) -> str:
        """A message in this language; with capital letter and stop where the text has them."""
        said = filled(self._messages[message], values)
        if text[:1].isupper() and message[:1].islower():
            said = said[:1].upper() + said[1:]
        bare = said.removesuffix(self._stop)
        if text.endswith("."):
            return bare + self._stop
        return bare if message.endswith(".") else said

    def _joint(self, text: str) -> str | None:
        """What stands between two pieces: words do, in this language."""
        said = self._messages.get(text.strip())
        return None if said is None else text.replace(text.strip(), said)

    def _joined(self, text: str, depth: int) -> str | None:
        for joint in _JOINTS:
            pieces = joint.split(text)
            if len(pieces) < 2 or not depth:
                continue
            said = [
                self._joint(one) if number % 2 else self._found(one, depth)
                for number, one in enumerate(pieces)
            ]
            if any(one is not None for one in said[::2]):
                return "".join(
                    old if new is None else new for old, new in zip(pieces, said, strict=True)
                )
        return None


def split_ends(text: str) -> tuple[str, str, str]:
    """A text between what joins it to others, as a comma, and white space."""
    found = _ENDS.fullmatch(text)
    assert found is not None
    return found[1], found[2], found[3]


def _with_ends(text: str) -> tuple[tuple[str, str], ...]:
    """A text as it is; and, where it ends with a stop, without: refusals get theirs on the page."""
    return ((text, ""), (text[:-1], ".")) if text.endswith(".") else ((text, ""),)


def _bare(text: str) -> str:
    """A text by which it is found, whether it begins or ends a sentence or not."""
    return text[:1].lower() + text[1:].removesuffix(".")


@cache
def script_messages(language: str) -> Mapping[str, str]:
    """What the scripts of our own pages say, by what they say in English."""
    if language == ENGLISH:
        return {}
    catalog = _catalog(language)
    return {
        key: said
        for key, said in catalog.messages.items()
        if said and any(place.endswith(".js") for place in catalog.places[key])
    }


@cache
def _catalog(language: str) -> Catalog:
    return Catalog.read(CATALOGS / f"{language}.po")


@cache
def words_of(language: str) -> Words:
    """The words of a language; English for one that there is no catalog of."""
    if language == ENGLISH or language not in LANGUAGES:
        return IN_ENGLISH
    catalog = _catalog(language)
    return Words(language, catalog.messages, {id: said for id, (_, said) in catalog.by_id.items()})


IN_ENGLISH = Words(ENGLISH, {})
