"""One language: messages by their ids, and whole texts of the page by their English."""

import re
from collections.abc import Mapping
from functools import cache
from typing import Any, cast

from workbench.model.messages.catalogue import TEXTS
from workbench.model.messages.cells import CellText
from workbench.model.messages.files import FileProblem, FileText
from workbench.model.messages.message import Message, Others, Text, plain
from workbench.model.messages.plans import ArmText
from workbench.words.catalogs import CATALOGS, LANGUAGES, Catalog
from workbench.words.markup import html_said, markdown_said

ENGLISH = "en"

COMMAS = ("de", "it", "fr", "es")
"""Languages that group digits by a narrow blank."""

NARROW_SPACE = "\u202f"

ARM_TEXTS: Mapping[str, Text] = {text.template: text for text in ArmText}
"""Names of arms that are put in another language, in lower case."""

ARM_PLACES = ("arm", "arms", "carrier")
"""Places of templates that names of arms stand in."""

OF_FILES = (CellText, FileText, FileProblem)
"""Texts about files, where an arm has the name that stands there."""

_THOUSANDS = re.compile(r"(?<=\d),(?=\d{3}(?!\d))")

NO_VALUES: Mapping[str, str] = {}

_ENDS = re.compile(r"([\s,;:·]*)(.*?)([\s,;(]*)", re.DOTALL)


class Words:
    """Puts texts in one language; what has no translation stays as it is.

    Concurrency: immutable; any thread.
    """

    def __init__(
        self, language: str, messages: Mapping[str, str], by_id: Mapping[str, str] = NO_VALUES
    ):
        """The words of a language: by English text, and templates by the ids of messages."""
        self.language = language
        self._by_id = {id: said for id, said in by_id.items() if said}
        # A text of the page may be one that has an id elsewhere.
        whole = {TEXTS[id].template: said for id, said in self._by_id.items() if id in TEXTS}
        self._texts = {key: said for key, said in (whole | dict(messages)).items() if said}
        self._bare = {_bare(key): key for key in self._texts}
        # There a comma stands before decimals, so 280,689 would be less than a thousand.
        self._has_commas = language in COMMAS
        self._stop = "。" if language == "zh" else "."

    def render(self, message: Message | str | None) -> str:
        """A message in this language, by its id; without a message an empty text.

        A text without an id is translated as by `say`.
        """
        if not message:
            return ""
        if isinstance(message, str):
            return self.say(message)
        said = self._said_within(message).render(self._template)
        return _THOUSANDS.sub(NARROW_SPACE, said) if self._has_commas else said

    def arm(self, name: str) -> str:
        """The name of an arm: left and right in this language, others as the cell has them."""
        known = ARM_TEXTS.get(name.lower())
        said = None if known is None else self._by_id.get(known.id)
        if said is None:
            return name
        return said[:1].upper() + said[1:] if name[:1].isupper() else said

    def _template(self, text: Text) -> str:
        return self._by_id.get(text.id, text.template)

    def _said_within(self, message: Message) -> Message:
        """The message with the texts in it that have no id put in this language."""
        if message.text is Others.PLAIN:
            return plain(self.say(str(message)))
        args = {name: self._translate_arg(arg) for name, arg in message.args.items()}
        if type(message.text) not in OF_FILES:
            args |= {name: self._arms(args[name]) for name in ARM_PLACES if name in args}
        return Message(message.text, args)

    def _arms(self, arg: Any) -> Any:
        if isinstance(arg, tuple):
            return tuple(map(self._arms, cast(tuple[Any, ...], arg)))
        return self.arm(arg) if isinstance(arg, str) else arg

    def _translate_arg(self, arg: Any) -> Any:
        if isinstance(arg, tuple):
            return tuple(map(self._translate_arg, cast(tuple[Any, ...], arg)))
        return self._said_within(arg) if isinstance(arg, Message) else arg

    def say(self, text: str) -> str:
        """A whole text in this language; it keeps white space and commas around it.

        A capital at its beginning and a stop at its end are those of the text given.
        """
        before, inner, behind = split_ends(text.replace("\u00a0", " "))
        key = inner if inner in self._texts else self._bare.get(_bare(inner))
        return text if key is None else f"{before}{self._as(inner, key)}{behind}"

    def _as(self, text: str, key: str) -> str:
        """A translation of `key` with capital letter and stop where the text has them."""
        said = self._texts[key]
        if text[:1].isupper() and key[:1].islower():
            said = said[:1].upper() + said[1:]
        bare = said.removesuffix(self._stop)
        if text.endswith("."):
            return bare + self._stop
        return bare if key.endswith(".") else said

    def html(self, text: str) -> str:
        """HTML with its texts, and what its elements say when they are pointed at."""
        return html_said(text, self.say) if self._texts else text

    def markdown(self, text: str) -> str:
        """Markdown with its texts."""
        return markdown_said(text, self.say) if self._texts else text


def split_ends(text: str) -> tuple[str, str, str]:
    """A text between what joins it to others, as a comma, and white space."""
    found = _ENDS.fullmatch(text)
    assert found is not None
    return found[1], found[2], found[3]


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
