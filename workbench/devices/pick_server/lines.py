"""Lines of the pick server: their form, requests read from bytes, and answers as bytes."""

import re
from dataclasses import dataclass
from typing import Final, Literal

from workbench.model.errors import InputError, ProtocolError

Separator = Literal["space", "comma", "semicolon"]
End = Literal["lf", "crlf", "cr"]
Unit = Literal["deg", "rad"]

SEPARATORS: Final = {"space": " ", "comma": ",", "semicolon": ";"}
ENDS: Final = {"lf": b"\n", "crlf": b"\r\n", "cr": b"\r"}

JOBS: Final = ("hello", "scan", "find", "next", "leg", "point", "done", "picked") + (
    "failed",
    "placed",
    "stop",
    "recipe",
    "bin",
    "view",
    "state",
    "pose",
    "kit",
    "new-bin",
    "home",
)
"""Jobs by name; the place of each is its number."""

ANSWERS: Final = ("OK", "WAIT", "NO", "STOP", "ERR", "PLAN", "LEG", "TO", "PICK", "POSE")
"""Words of answers; the place of each is its number."""

LAST: Final = 9999
"""Numbers of requests go from 1 to this one, and begin at 1 again."""

PRIME, FACTOR = 65521, 31
"""Of the check: what a controller computes whose numbers are exact up to 2^23."""

DECIMAL_NUMBER = re.compile(r"-?[0-9]{1,6}(\.[0-9]{1,9})?")
WHOLE_NUMBER = re.compile(r"[0-9]{1,6}")
WORD = re.compile(r"[A-Za-z0-9_/.-]{1,40}")


class BadLine(ProtocolError):
    """A line that cannot be taken; `word` is that of the answer."""

    def __init__(self, word: str):
        super().__init__(word)
        self.word = word


@dataclass(frozen=True, slots=True)
class Form:
    """How lines are written; every line that is sent or taken has at most `longest` bytes.

    `longest` counts the line's end.  `check`: whether each line closes with its check.  `is_coded`:
    whether answers have numbers instead of words.  `unit` and `digits` are those of turning axes.
    """

    separator: Separator = "space"
    end: End = "lf"
    longest: int = 80
    check: bool = True
    is_coded: bool = False
    unit: Unit = "deg"
    digits: int = 2


@dataclass(frozen=True, slots=True)
class Request:
    """What a robot program asks: the job by its name, and the words after it."""

    number: int
    job: str
    words: tuple[str, ...]


def _check_of(text: str) -> int:
    """The check of a text: 0 to 65,520."""
    value = 0
    for code in text.encode("ascii"):
        value = (value * FACTOR + code) % PRIME
    return value


def line_bytes(form: Form, *words: str) -> bytes:
    """Words as a line with its check and its end.

    Raises:
        InputError: it is longer than the form allows.
    """
    separator = SEPARATORS[form.separator]
    text = separator.join(words)
    if form.check:
        text = f"{text}{separator}{_check_of(text):05d}"
    data = text.encode("ascii") + ENDS[form.end]
    if len(data) > form.longest:
        raise InputError(f"the line {text[:40]!r} has {len(data)} bytes, over {form.longest}")
    return data


def words_of(form: Form, line: bytes) -> tuple[str, ...]:
    """The words of a line without its end, once its check is right.

    Raises:
        BadLine: it is no ASCII text, too long, or damaged.
    """
    if len(line) + len(ENDS[form.end]) > form.longest:
        raise BadLine("long")
    if not line.isascii() or any(code < 32 or code > 126 for code in line):
        raise BadLine("text")
    text, separator = line.decode("ascii"), SEPARATORS[form.separator]
    if form.check:
        text, _, last = text.rpartition(separator)
        if last != f"{_check_of(text):05d}":
            raise BadLine("check")
    words = tuple(word.strip(" ") for word in text.split(separator))
    if not all(WORD.fullmatch(word) for word in words):
        raise BadLine("text")
    return words


def read_request(form: Form, line: bytes) -> Request:
    """A request from a line without its end.

    Raises:
        BadLine: one of these, or no job of the protocol.
    """
    words = words_of(form, line)
    if len(words) < 2 or not WHOLE_NUMBER.fullmatch(words[0]) or int(words[0]) > LAST:
        raise BadLine("number")
    job = words[1].lower()
    if WHOLE_NUMBER.fullmatch(job) and int(job) < len(JOBS):
        job = JOBS[int(job)]
    if job not in JOBS or (job == "hello") != (int(words[0]) == 0):
        raise BadLine("job")
    return Request(int(words[0]), job, words[2:])


def answer_bytes(form: Form, number: int, *words: str) -> bytes:
    """An answer, whose first word is one of `ANSWERS`."""
    first, *rest = words
    said = str(ANSWERS.index(first)) if form.is_coded else first
    return line_bytes(form, str(number), said, *rest)


def number_after(number: int) -> int:
    """The number of the request that follows."""
    return number % LAST + 1


def read_number(word: str) -> float:
    """A decimal number.

    Raises:
        BadLine: it is none.
    """
    if not DECIMAL_NUMBER.fullmatch(word):
        raise BadLine("value")
    return float(word)


def read_whole(word: str, most: int) -> int:
    """A whole number from 0 to `most`.

    Raises:
        BadLine: it is none.
    """
    if not WHOLE_NUMBER.fullmatch(word) or int(word) > most:
        raise BadLine("value")
    return int(word)


class LineBuffer:
    """Cuts what arrives into lines, however it was split.

    Lifetime: one connection.
    """

    def __init__(self, form: Form) -> None:
        self._end, self._longest = ENDS[form.end], form.longest
        self._rest = b""

    def split(self, data: bytes) -> list[bytes]:
        """Whole lines without their ends; empty ones are left out.

        What is longer than a line may be comes cut, so that it is refused as one.
        """
        *lines, self._rest = (self._rest + data).split(self._end)
        if len(self._rest) > self._longest:
            self._rest = self._rest[: self._longest]
        return [line[: self._longest] for line in lines if line.strip()]
