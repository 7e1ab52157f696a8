r"""How `abb-socket/2` goes over the wire: frames of 80 characters, numbered, with a check sum.

A RAPID string holds 80 characters, so every message is exactly that: 75 characters of text,
filled up with blanks, the CRC of these as 4 hexadecimal digits, and a line feed.  The controller
takes each with one `SocketReceive \Str \ReadNoOfBytes:=80`, and TCP may split and join the bytes
as it likes.  The text begins with a number of four digits, one more than that of the frame before
in the same direction (1 after 9999).  So whatever is lost, doubled or out of order is
noticed.

The check sum is CRC-16/CCITT-FALSE (polynomial 0x1021, first value 0xFFFF).
"""

import binascii
import re
from collections.abc import Iterator
from dataclasses import dataclass

from workbench.model.errors import InputError, ProtocolError

SIZE = 80
"""Bytes of a frame: as many as a RAPID string holds characters."""

TEXT = 75
"""Characters of its text, blanks included."""

LAST_NUMBER = 9999
"""Reports of the state use them up in some eleven minutes; then numbers begin again with 1."""

FIRST_CRC = 0xFFFF

NUMBERED = re.compile(r"(\d{4}) ([a-z]+)(?: (.*))?")


@dataclass(frozen=True, slots=True)
class MessageFrame:
    """A message: its number, its word, the rest, and the check sum it travelled with."""

    number: int
    word: str
    rest: str
    crc: str

    @property
    def text(self) -> str:
        """Number, word and rest, without the blanks at the end."""
        return f"{self.number:04d} {self.word} {self.rest}".rstrip()

    @property
    def words(self) -> list[str]:
        """The rest, split at blanks."""
        return self.rest.split()


def crc_of(text: str, before: int = FIRST_CRC) -> int:
    """The check sum of a text, or of what came `before` and this text."""
    return binascii.crc_hqx(text.encode("ascii"), before)


def number_after(number: int) -> int:
    """The number of the frame that follows; 0 stands for none before."""
    return number % LAST_NUMBER + 1


def make_frame(number: int, text: str) -> bytes:
    """A frame, ready to be sent.

    Raises:
        InputError: the text is too long or not printable ASCII, or the number is none.
    """
    body = f"{number:04d} {text}"
    if not 1 <= number <= LAST_NUMBER:
        raise InputError(f"frames are numbered from 1 to {LAST_NUMBER}, not {number}")
    if len(body) > TEXT or not (body.isascii() and body.isprintable()):
        raise InputError(f"{text!r} does not fit a frame: {TEXT - 5} printable characters")
    padded = body.ljust(TEXT)
    return f"{padded}{crc_of(padded):04X}\n".encode("ascii")


class Frames:
    """Bytes that arrive in any pieces, as frames in order.

    Lifetime: one direction of one connection.
    """

    def __init__(self) -> None:
        self._heard = b""
        self._number = 0

    @property
    def number(self) -> int:
        """That of the last frame."""
        return self._number

    def hear(self, data: bytes) -> Iterator[MessageFrame]:
        """Take what arrived; the frames that are complete with it, one by one.

        Raises:
            ProtocolError: this is no frame, a damaged one, or not the next one.
        """
        self._heard += data
        while len(self._heard) >= SIZE:
            piece, self._heard = self._heard[:SIZE], self._heard[SIZE:]
            yield self._frame(piece)
        # What cannot become a frame is not waited for.
        if self._heard and not re.match(rb"\d{1,4}\Z|\d{4} ", self._heard):
            raise ProtocolError(f"{self._heard[:40]!r} does not begin like a frame")

    def _frame(self, piece: bytes) -> MessageFrame:
        try:
            text, crc, end = (
                piece[:TEXT].decode("ascii"),
                piece[TEXT:-1].decode("ascii"),
                piece[-1:],
            )
        except UnicodeDecodeError:
            raise ProtocolError(f"{piece[:40]!r} is not text") from None
        found = NUMBERED.fullmatch(text.rstrip(" "))
        if end != b"\n" or found is None or not text.isprintable():
            raise ProtocolError(f"{piece[:40]!r} is no frame")
        if crc != f"{crc_of(text):04X}":
            raise ProtocolError(
                f"{text.rstrip()!r} came with check sum {crc}, it has {crc_of(text):04X}"
            )
        self._number = number_after(self._number)
        if int(found[1]) != self._number:
            raise ProtocolError(f"frame {found[1]} came where {self._number:04d} was expected")
        return MessageFrame(self._number, found[2], found[3] or "", crc)
