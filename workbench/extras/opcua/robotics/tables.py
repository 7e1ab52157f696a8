"""Types of companion standards as tables in text, and how such a table is read.

A line that is not indented begins a type: its number, its name, `<` and what it is a kind of, and
`abstract` where nothing is of that type itself.  Below it, indented, stand its members, and theirs:

    number name rule kind [data type] [reference]

A name without a prefix is of the Robotics namespace, `di:` and `ua:` those of Devices and of OPC UA
itself.  The rule is M(andatory), O(ptional), or MP and OP for placeholders in angle brackets, which
stand for any number of members of their kind.  The kind is a word of `WORDS` or a type by prefix
and number.  Where no reference is named it is HasProperty for properties and HasComponent for all
else.  `implements` names an interface.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from workbench.extras.opcua.robotics import di_types, robotics_types

Ref = tuple[str, int]
"""A node of a standard: prefix of its namespace, and number."""

URIS = {
    "di": "http://opcfoundation.org/UA/DI/",
    "rob": "http://opcfoundation.org/UA/Robotics/",
}
"""Namespaces by prefix."""

WORDS: dict[str, Ref] = {
    "Object": ("ua", 58),
    "Folder": ("ua", 61),
    "Data": ("ua", 63),
    "Property": ("ua", 68),
    "Analog": ("ua", 17497),
    "Rational": ("ua", 17709),
}
"""Types of OPC UA itself (OPC 10000-5 and -8) by the words of the tables."""

VARIABLES = frozenset(("Data", "Property", "Analog", "Rational"))


@dataclass(frozen=True, slots=True)
class TypeMember:
    """One line of a table: what things of a type have.  `data_type` is empty for objects."""

    number: int
    prefix: str
    name: str
    rule: str
    kind: Ref
    data_type: str
    reference: str
    members: tuple["TypeMember", ...]

    @property
    def is_placeholder(self) -> bool:
        """Whether it stands for any number of others."""
        return self.rule in ("MP", "OP")


@dataclass(frozen=True, slots=True)
class NodeType:
    """A type of objects."""

    ref: Ref
    name: str
    above: Ref
    is_abstract: bool
    interfaces: tuple[Ref, ...]
    members: tuple[TypeMember, ...]


def types() -> dict[Ref, NodeType]:
    """All types, those that others are made from first."""
    found = [*_types("di", di_types.TYPES), *_types("rob", robotics_types.TYPES)]
    return {node_type.ref: node_type for node_type in found}


def _types(prefix: str, table: str) -> Iterator[NodeType]:
    lines = table.strip().splitlines()
    starts = [at for at, line in enumerate(lines) if not line.startswith(" ")]
    for start, end in zip(starts, [*starts[1:], len(lines)], strict=True):
        number, name, _, above, *rest = lines[start].split()
        own = [line for line in lines[start + 1 : end] if "implements" not in line]
        interfaces = [line.split()[1] for line in lines[start + 1 : end] if "implements" in line]
        yield NodeType(
            (prefix, int(number)),
            name,
            _ref(above),
            "abstract" in rest,
            tuple(_ref(interface) for interface in interfaces),
            _members(own, 2),
        )


def _members(lines: list[str], depth: int) -> tuple[TypeMember, ...]:
    """The members whose lines are indented by so much, with theirs."""
    if not lines:
        return ()
    starts = [at for at, line in enumerate(lines) if len(line) - len(line.lstrip()) == depth]
    return tuple(
        _member(lines[start].split(), _members(lines[start + 1 : end], depth + 2))
        for start, end in zip(starts, [*starts[1:], len(lines)], strict=True)
    )


def _member(fields: list[str], members: tuple[TypeMember, ...]) -> TypeMember:
    number, called, rule, kind, *rest = fields
    data_type = rest.pop(0) if kind in VARIABLES else ""
    prefix, _, name = called.rpartition(":")
    usual = "HasProperty" if kind == "Property" else "HasComponent"
    reference = rest[0] if rest else usual
    ref = WORDS[kind] if kind in WORDS else _ref(kind)
    return TypeMember(int(number), prefix or "rob", name, rule, ref, data_type, reference, members)


def _ref(text: str) -> Ref:
    prefix, _, number = text.partition(":")
    return prefix, int(number)
