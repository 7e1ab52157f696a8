"""A message: which text, with what in its places."""

import enum
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any, Self, cast

_PLACE = re.compile(r"\{(\w+)(?::([^{}]*))?\}")
_PART = re.compile(r"part-([1-9]\d{0,5})")

UNITS: Mapping[str, tuple[float, int, str]] = {
    "mm": (1e3, 1, " mm"),
    "mm0": (1e3, 0, " mm"),
    "mm2": (1e3, 2, " mm"),
    "mm/s": (1e3, 0, " mm/s"),
    "deg": (57.29577951308232, 2, " deg"),
    "deg0": (57.29577951308232, 0, " deg"),
    "deg1": (57.29577951308232, 1, " deg"),
    "deg3": (57.29577951308232, 3, " deg"),
    "kg": (1.0, 3, " kg"),
    "g": (1e3, 1, " g"),
    "s": (1.0, 1, " s"),
    "s2": (1.0, 2, " s"),
    "ms": (1e3, 0, " ms"),
    "min": (1 / 60, 0, " min"),
    "%": (100.0, 0, "%"),
    "1": (1.0, 1, ""),
    "2": (1.0, 2, ""),
}
"""How a number is shown: its factor from SI, its digits, and its unit."""

GROUPED = "n"
"""How a count of thousands is shown: `12,345`."""


HELD_BODY = "held_body"
"""The name of the ball in a hand, and the beginning of those of the boxes around fingers."""


@dataclass(frozen=True, slots=True)
class FoundPart:
    """A part of a scan by its index in a list of detections; people read `part-1` for the first."""

    index: int

    def __str__(self) -> str:
        return f"part-{self.index + 1}"


def places_of(template: str) -> Mapping[str, frozenset[str]]:
    """How each place of a template is shown, by its name."""
    found: dict[str, frozenset[str]] = {}
    for name, how in _PLACE.findall(template):
        found[name] = found.get(name, frozenset()) | ({how} if "|" not in how else {"|"})
    return found


class Text(enum.Enum):
    """Texts of one subject: each member is an id with its English template.

    `{far:mm}` is a length in mm with one digit, see `UNITS`; `{count:part|parts}` a word for one
    and one for several; `{arms:or}` a list; everything else is a name, a number or a message.
    A member that is called with its arguments makes a `Message`.
    """

    subject: str
    template: str
    places: Mapping[str, frozenset[str]]

    def __init_subclass__(cls, *, subject: str = "", **others: Any):
        """Texts whose ids begin with the subject."""
        super().__init_subclass__(**others)
        cls.subject = subject

    def __new__(cls, template: str) -> Self:
        """A text by its English template; two texts may read alike."""
        made = object.__new__(cls)
        made._value_ = len(cls.__members__)
        made.template = template
        made.places = places_of(template)
        return made

    @property
    def id(self) -> str:
        """The id, as records and programs have it: `verdict.too-deep`."""
        return f"{self.subject}.{self.name.lower().replace('_', '-')}"

    def __call__(
        self, **args: "float | int | str | FoundPart | Message | Iterable[Any]"
    ) -> "Message":
        """The message with these arguments.

        Raises:
            TypeError: the arguments are not those of the template.
        """
        if args.keys() != self.places.keys():
            raise TypeError(f"{self.id} has the places {sorted(self.places)}, not {sorted(args)}")
        return Message(self, {name: _as_arg(value) for name, value in args.items()})


class Others(Text, subject="other"):
    """A text that is on record without an id, and what joins the elements of a list."""

    PLAIN = "{text}"
    AND = "{first} and {last}"
    OR = "{first} or {last}"
    ALSO = "{first}; {last}"


@dataclass(frozen=True, slots=True, repr=False)
class Message:
    """A text with its arguments by name.

    Arguments are lengths [m], angles [rad], times [s], shares, counts, names, parts, messages, and
    tuples of them.  A name is shown as it is; only messages are translated.

    Concurrency: immutable; any thread.
    """

    text: Text
    args: Mapping[str, Any] = field(default_factory=dict[str, Any])

    def __hash__(self) -> int:
        return hash((self.text, tuple(self.args.items())))

    def __str__(self) -> str:
        return self.render(_english)

    def __repr__(self) -> str:
        return f"<{self.id}: {self}>"

    def __reduce__(self) -> tuple[Any, ...]:
        # By its id, for other processes: the places of enumerations may change.
        return Message, (self.text, dict(self.args))

    @property
    def id(self) -> str:
        """The id of its text."""
        return self.text.id

    def render(self, template_of: Callable[[Text], str]) -> str:
        """The text for people.

        Args:
            template_of: the template of each text in the language of who reads it.
        """

        def show(place: re.Match[str]) -> str:
            return _format_arg(self.args[place[1]], place[2] or "", template_of)

        return _PLACE.sub(show, template_of(self.text))

    def renumber(self, number: "Callable[[int], int | Message]") -> "Message":
        """The message with its parts by the indices in another list, or as another message."""
        return Message(self.text, {name: _renumber(a, number) for name, a in self.args.items()})

    def part(self, text: Text) -> "Message | None":
        """The first message of a text in it, which it may be itself; None where there is none."""
        if self.text is text:
            return self
        for arg in self.args.values():
            for item in cast(tuple[Any, ...], arg) if isinstance(arg, tuple) else (arg,):
                found = item.part(text) if isinstance(item, Message) else None
                if found is not None:
                    return found
        return None

    def mentions(self, text: Text) -> bool:
        """Whether it is of this text, or holds a message that is."""
        return self.part(text) is not None

    @property
    def form(self) -> Any:
        """What JSON holds: `id` and `args`; a text without an id is that text."""
        if self.text is Others.PLAIN:
            return self.args["text"]
        return {"id": self.id, "args": {name: _form(arg) for name, arg in self.args.items()}}

    @property
    def program_form(self) -> dict[str, Any]:
        """What programs get: `id`, `args` and the English `text`; both empty without an id."""
        form = {"id": "", "args": {}} if self.text is Others.PLAIN else self.form
        return {**form, "text": str(self)}


def plain(text: str) -> Message:
    """A text that is on record without an id, or was written by somebody else."""
    return Message(Others.PLAIN, {"text": text})


def as_message(said: Message | str) -> Message:
    """A message, or a text that has no id yet as one."""
    return plain(said) if isinstance(said, str) else said


def all_of(messages: Iterable[Message | None]) -> Message | None:
    """Several messages as one, with semicolons between them; None for none."""
    whole: Message | None = None
    for message in messages:
        if message is not None:
            whole = message if whole is None else Others.ALSO(first=whole, last=message)
    return whole


def found_part(label: str) -> FoundPart | str:
    """What a body is called in an argument: a part of the scan by its index, others by name."""
    match = _PART.fullmatch(label)
    return label if match is None else FoundPart(int(match[1]) - 1)


def _as_arg(value: Any) -> Any:
    return value if isinstance(value, str) or not isinstance(value, Iterable) else tuple(value)


def _english(text: Text) -> str:
    return text.template


def _format_arg(arg: Any, how: str, template_of: Callable[[Text], str]) -> str:
    if "|" in how:
        singular, several = how.split("|")
        return singular if arg == 1 else several
    if how in UNITS:
        factor, digits, unit = UNITS[how]
        return f"{arg * factor + 0.0:.{digits}f}{unit}"
    if how == GROUPED:
        return f"{arg:,}"
    if isinstance(arg, tuple):
        return _join_list(cast(tuple[Any, ...], arg), how, template_of)
    return arg.render(template_of) if isinstance(arg, Message) else str(arg)


def _join_list(args: tuple[Any, ...], how: str, template_of: Callable[[Text], str]) -> str:
    shown = [_format_arg(arg, "", template_of) for arg in args]
    joint = {"and": Others.AND, "or": Others.OR}.get(how)
    if joint is None or len(shown) < 2:
        return ", ".join(shown)
    return joint(first=", ".join(shown[:-1]), last=shown[-1]).render(template_of)


def _renumber(arg: Any, number: Callable[[int], int | Message]) -> Any:
    match arg:
        case FoundPart():
            new = number(arg.index)
            return new if isinstance(new, Message) else FoundPart(new)
        case Message():
            return arg.renumber(number)
        case tuple():
            return tuple(_renumber(item, number) for item in cast(tuple[Any, ...], arg))
        case _:
            return arg


def _form(arg: Any) -> Any:
    match arg:
        case FoundPart():
            return {"part": arg.index}
        case Message():
            return arg.form
        case tuple():
            return [_form(item) for item in cast(tuple[Any, ...], arg)]
        case str():
            return arg
        case float():
            return float(arg) + 0.0
        case _:
            return int(arg)
