"""Types of RAPID and what data of them hold.

A `num` is a float of single precision, as in the controller, a `dnum` one of double precision, a
string and a bool are Python's;
records and arrays are lists of what they consist of.  A place that can be written is a pair of a
list and an index in it; whether it belongs to a variable, an array or a record.
"""

import math
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from workbench.formats.rapid.problems import RapidError

Place = tuple[list[Any], int]

EXACT = float(2**24)
"""Whole numbers up to here have an exact single."""


class Kind(NamedTuple):
    """A type: its name in small letters, and how many dimensions it has as an array."""

    name: str
    dims: int = 0

    @property
    def is_unknown(self) -> bool:
        """Whether nothing is known of it, so that it fits everything."""
        return not self.name

    def __str__(self) -> str:
        # Behind the sign is the module that has the type for itself.
        return (self.name.partition("@")[0] or "?") + (
            f"{{{','.join('*' * self.dims)}}}" if self.dims else ""
        )


NUM, DNUM, BOOL, STRING = Kind("num"), Kind("dnum"), Kind("bool"), Kind("string")
UNKNOWN = Kind("")
"""Of an expression that is wrong in itself, or not known here: nothing more is said about it."""

ATOMS = ("num", "dnum", "bool", "string")
"""Types with values that are not made of others."""

SIGNALS = ("signaldi", "signaldo", "signalai", "signalao", "signalgi", "signalgo")
"""Types of signals; in an expression each is the number that the signal has."""

RANGES = {"byte": (0.0, 255.0)}
"""Aliases of num that hold whole numbers in a range."""


def single(value: float) -> float:
    """A number as a `num` holds it.

    Raises:
        RapidError: it is too large.
    """
    if math.isinf(value):
        raise RapidError("ERR_NUM_OVERFLOW")
    if -EXACT <= value <= EXACT and value == int(value):
        return value
    try:
        return struct.unpack("<f", struct.pack("<f", value))[0]
    except OverflowError:
        raise RapidError("ERR_NUM_OVERFLOW") from None


def copy(value: Any) -> Any:
    """A copy of a value: records and arrays are copied when they are assigned."""
    return [copy(item) for item in value] if type(value) is list else value


@dataclass
class Types:
    """The types of a task: atoms, aliases, and records with their components in order.

    Data of `atoms_known` have no value that can be assigned; of `opaque` records the components are
    not known here.
    """

    atoms_known: set[str] = field(default_factory=set[str])
    opaque: set[str] = field(default_factory=set[str])
    records: dict[str, dict[str, str]] = field(default_factory=dict[str, dict[str, str]])
    aliases: dict[str, str] = field(default_factory=dict[str, str])
    makers: dict[str, Callable[[str], Any]] = field(default_factory=dict[str, Callable[[str], Any]])

    def exists(self, name: str) -> bool:
        """Whether there is a type of that name (small letters)."""
        tables = (ATOMS, self.records, self.aliases, self.atoms_known, self.opaque)
        return any(name in table for table in tables)

    def copy(self) -> "Types":
        """Types of another task that begin with these."""
        return Types(
            atoms_known=set(self.atoms_known),
            opaque=set(self.opaque),
            records=dict(self.records),
            aliases=dict(self.aliases),
            makers=dict(self.makers),
        )

    def forget(self, name: str) -> None:
        """Let a type be declared anew."""
        self.atoms_known.discard(name)
        self.opaque.discard(name)
        self.records.pop(name, None)
        self.aliases.pop(name, None)

    def base(self, kind: Kind) -> Kind:
        """The type that an alias stands for."""
        name = kind.name
        if name not in self.aliases:
            return kind
        while name in self.aliases:
            name = self.aliases[name]
        return Kind(name, kind.dims)

    def shape(self, kind: Kind) -> Any:
        """What a type consists of, however it and its components are called."""
        base = self.base(kind)
        record = self.records.get(base.name)
        inner = [self.shape(Kind(part)) for part in record.values()] if record else base.name
        return inner, base.dims

    def atoms(self, kind: Kind) -> int:
        """Of how many values one element of a type consists."""
        record = self.records.get(self.base(Kind(kind.name)).name, {})
        return sum(self.atoms(Kind(part)) for part in record.values()) or 1

    def fit(self, kind: Kind, other: Kind) -> bool:
        """Whether a value of one type can be used as the other."""
        if kind == other or not kind.name or not other.name:
            return True
        return self.base(kind) == self.base(other)

    def default(self, kind: Kind, sizes: tuple[int, ...], name: str = "") -> Any:
        """What data hold that were not given a value; `name` is that of the data."""
        if sizes:
            return [self.default(kind, sizes[1:], name) for _ in range(sizes[0])]
        base = self.base(Kind(kind.name)).name
        if base in self.records:
            return [self.default(Kind(part), ()) for part in self.records[base].values()]
        if base in self.makers:
            return self.makers[base](name)
        return {"bool": False, "string": ""}.get(base, 0.0)
