"""Catalogs of messages: files in gettext's form (.po), one a language, read as they are.

A message with an id has that as its context (`msgctxt`), beside the English template (`msgid`).  Of
texts that have no id yet the English sentence is the key.  What stands in braces is a place, named
alike in both.  A message that has no translation yet is shown in English.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

LANGUAGES: Mapping[str, str] = {
    "en": "English",
    "de": "Deutsch",
    "it": "Italiano",
    "fr": "Français",
    "es": "Español",
    "zh": "中文",
}
"""By their codes (ISO 639-1) as they call themselves."""

CATALOGS = Path(__file__).parent / "catalogs"

_LINE = re.compile(r'(?:(msgctxt|msgid|msgstr) )?"((?:[^"\\]|\\.)*)"')
_ESCAPES = {"\\": "\\", '"': '"', "n": "\n", "t": "\t"}


@dataclass(frozen=True, slots=True)
class Catalog:
    """One language's messages.

    Attributes:
        head: what stands above the messages: the glossary as comments, and gettext's own entry.
        by_id: English template and translation by the id of a message.
        messages: translation by English message; empty where there is none yet.
        places: files that a message is from, for translators.
    """

    head: str
    by_id: Mapping[str, tuple[str, str]]
    messages: Mapping[str, str]
    places: Mapping[str, tuple[str, ...]]

    @classmethod
    def read(cls, path: Path) -> "Catalog":
        """Read a catalog.

        Raises:
            OSError: it cannot be read.
            ValueError: a line is none of a catalog.
        """
        head, _, body = path.read_text(encoding="utf-8").partition("\n\n")
        by_id: dict[str, tuple[str, str]] = {}
        messages: dict[str, str] = {}
        places: dict[str, tuple[str, ...]] = {}
        for entry in filter(str.strip, body.split("\n\n")):
            texts, where = _entry(path, entry)
            id, key, said = texts["msgctxt"], texts["msgid"], texts["msgstr"]
            if (id or key) in (by_id if id else messages):
                raise ValueError(f"{path} has the message {id or key!r} twice")
            if id:
                by_id[id] = key, said
            else:
                messages[key], places[key] = said, where
        return cls(head, by_id, messages, places)

    def brought_to(
        self, templates: Mapping[str, str], wanted: Mapping[str, tuple[str, ...]]
    ) -> "Catalog":
        """With these messages; translations that are known stay.

        Args:
            templates: English by id; where it is another than before, the translation is empty.
            wanted: files by English message without an id.
        """
        by_id = {id: (english, "") for id, english in templates.items()}
        by_id |= {id: pair for id, pair in self.by_id.items() if templates.get(id) == pair[0]}
        known = self.messages
        return Catalog(self.head, by_id, {key: known.get(key, "") for key in wanted}, wanted)

    def write(self, path: Path) -> None:
        """Write it as `read` reads it."""
        entries = [
            f"msgctxt {_quote(id)}\nmsgid {_quote(english)}\nmsgstr {_quote(said)}"
            for id, (english, said) in self.by_id.items()
        ]
        entries += [
            f"#: {' '.join(self.places[key])}\nmsgid {_quote(key)}\nmsgstr {_quote(said)}"
            for key, said in self.messages.items()
        ]
        path.write_text("\n\n".join([self.head.rstrip("\n"), *entries]) + "\n", encoding="utf-8")


def _entry(path: Path, entry: str) -> tuple[dict[str, str], tuple[str, ...]]:
    texts, now, where = {"msgctxt": "", "msgid": "", "msgstr": ""}, "", list[str]()
    for line in entry.splitlines():
        if line.startswith("#"):
            where += line.removeprefix("#:").split() if line.startswith("#:") else ()
            continue
        found = _LINE.fullmatch(line.strip())
        now = (found[1] or now) if found else ""
        if found is None or not now:
            raise ValueError(f"{path}: {line!r} is no line of a catalog")
        texts[now] += re.sub(r"\\(.)", lambda match: _ESCAPES.get(match[1], match[1]), found[2])
    if not texts["msgid"]:
        raise ValueError(f"{path}: an entry has no message: {entry[:60]!r}")
    return texts, tuple(where)


def _quote(text: str) -> str:
    said = text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n").replace("\t", "\\t")
    return f'"{said}"'
