"""Sentences found again by their messages: what stands in a sentence at the places of a message."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

_PLACE = re.compile(r"\{(\w+)\}")

LEAST_LETTERS = 5
"""A message with a place at an end that says less, and joins nothing, could be anything."""

JOINTS = ",;:·\n"
"""What puts texts together: a place at the beginning does not reach over it."""


@dataclass(frozen=True, slots=True)
class Template:
    """A message with places, and the sentences that may be of it.

    Attributes:
        message: in English.
        fixed: a piece of it that every such sentence has.
        pattern: of these sentences.
        is_vague: whether what is fixed in it says little.
    """

    message: str
    fixed: str
    pattern: re.Pattern[str]
    is_vague: bool

    def fitted(self, sentence: str) -> Mapping[str, str] | None:
        """What stands at the places; None where the sentence is of another message."""
        found = self.pattern.fullmatch(sentence) if self.fixed in sentence else None
        return None if found is None else found.groupdict()


class Templates:
    """Messages with places, the one that says most first; those without places are left alone.

    Attributes:
        clear: what is fixed in these tells them from others.
        vague: these fit much, so anything else is tried before.

    Concurrency: immutable; any thread.
    """

    def __init__(self, messages: Iterable[str]):
        """Of these messages."""
        found = [_template(message) for message in messages if _PLACE.search(message)]
        found.sort(key=lambda one: (*_says(one.message), _places(one.message), one.message))
        self.clear = tuple(one for one in found if not one.is_vague)
        self.vague = tuple(one for one in found if one.is_vague)


def filled(message: str, values: Mapping[str, str]) -> str:
    """A message with values at its places."""
    return _PLACE.sub(lambda place: values[place[1]], message)


def letters(message: str) -> int:
    """How many letters are fixed in a message."""
    return sum(map(str.isalpha, _PLACE.sub("", message)))


def _says(message: str) -> tuple[int, int]:
    """What sorts the message first that says most: by its letters, then by all that is fixed."""
    return -letters(message), -len(_PLACE.sub("", message))


def _places(message: str) -> int:
    return len(_PLACE.findall(message))


def _template(message: str) -> Template:
    pieces = _PLACE.split(message)
    texts = pieces[::2]
    is_open = not (texts[0] and texts[-1]) and not set(JOINTS) & set(message)
    # The first letter may be another one; the rest stands in every sentence as it is.
    fixed = max([texts[0][1:], *texts[1:]], key=len)
    is_vague = (is_open and letters(message) < LEAST_LETTERS) or letters(message) < 2
    return Template(message, fixed, _pattern(pieces), is_vague)


def _pattern(pieces: list[str]) -> re.Pattern[str]:
    """Of a message as `_PLACE` splits it: texts and names of places by turns."""
    texts = "".join(pieces[::2])
    barred = "".join(joint for joint in JOINTS if joint not in texts)
    made = "".join(
        f"(?P<{piece}>.*?)" if number % 2 else re.escape(piece)
        for number, piece in enumerate(pieces)
    )
    if not pieces[0] and barred:
        made = made.replace(">.*?)", f">(?:(?!\\. )(?:[^{barred}]|(?<=\\d),(?=\\d)))*?)", 1)
    first = pieces[0][:1]
    if first.isalpha():
        made = f"[{first.upper()}{first.lower()}]{made[1:]}"
    return re.compile(made, re.DOTALL)
