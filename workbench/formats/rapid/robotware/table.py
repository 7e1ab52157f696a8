"""The tables of RobotWare as symbols of the language."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from workbench.formats.rapid.symbols import Parameter, Routine, Variable
from workbench.formats.rapid.values import UNKNOWN, Kind, Types

ROUTINES = ("motion", "signals", "program", "texts", "options")

MODES = {"VAR": "inout", "PERS": "pers", "INOUT": "inout"}
"""Whoever calls an instruction may give a PERS where the manual says VAR: some take it."""

LINE = re.compile(r"(?:(\w+) )?(\w+)\((.*)\)")
UNNUMBERED_ROW = re.compile(r"(?:(\w+) )?\(\.\.\.\) (.+)")
PARAMETER = re.compile(r"(VAR|PERS|INOUT)? *(\w+)(?: +(\w+))?(?:\{([*,]+)\})?")
RECORD = re.compile(r"record (\w+)\((.*)\)")
PIECE = re.compile(r"\| *\\|[,|\\]|[^,|\\{]*[^,|\\{ ][^,|\\{]*(?:\{[*,]+\})?")
NUMBERED_ROW = re.compile(r"(\w+?)(\d+)-(\d+)")


@dataclass
class RobotWareTable:
    """All that RobotWare has, by small name."""

    types: Types = field(default_factory=Types)
    names: dict[str, Routine | Variable] = field(default_factory=dict[str, Routine | Variable])


@cache
def robotware() -> RobotWareTable:
    """The tables, read once; nothing in them is executed as it stands."""
    table = RobotWareTable()
    for line in _lines("types"):
        _type(table.types, line)
    for name in ROUTINES:
        short: dict[str, str] = {}
        for line in _lines(name):
            _routines(table, line, short)
    for line in _lines("data"):
        of, names = line.split(":")
        kind, storage = of.split()
        for name in _row(names):
            _data(table, name, Kind(kind), storage)
    for line in _lines("errors"):
        for name in line.split():
            _data(table, name, Kind("errnum"), "const")
    return table


def _lines(name: str) -> list[str]:
    text = Path(__file__).with_name(f"{name}.txt").read_text(encoding="ascii")
    lines = (line.strip() for line in text.splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def _type(types: Types, line: str) -> None:
    record = RECORD.fullmatch(line)
    if record is None:
        word, name, *of = line.split()
        if word == "alias":
            types.aliases[name] = of[0]
        else:
            types.atoms_known.add(name)
    elif record[2] == "...":
        types.opaque.add(record[1])
    else:
        parts = (part.split() for part in record[2].split(", "))
        types.records[record[1]] = {name: kind for kind, name in parts}


def _row(names: str) -> list[str]:
    found: list[str] = []
    for name in names.split():
        row = NUMBERED_ROW.fullmatch(name)
        found += (
            [name] if row is None else [f"{row[1]}{k}" for k in range(int(row[2]), int(row[3]) + 1)]
        )
    return found


def _data(table: RobotWareTable, name: str, kind: Kind, storage: str) -> None:
    place = ([table.types.default(kind, ())], 0)
    table.names[name.lower()] = Variable(name, kind, (), place, -1, storage, is_executed=False)


def _routines(table: RobotWareTable, line: str, short: dict[str, str]) -> None:
    line = re.sub(r"\$\w+", lambda found: short.get(found[0], found[0]), line)
    if line.startswith("$") and "=" in line:
        name, _, value = line.partition("=")
        short[name.strip()] = value.strip()
        return
    loose = UNNUMBERED_ROW.fullmatch(line)
    if loose is not None:
        for name in loose[2].split():
            table.names[name.lower()] = _routine(name, loose[1], [], is_loose=True)
        return
    found = LINE.fullmatch(line)
    assert found is not None, line
    table.names[found[2].lower()] = _routine(found[2], found[1], list(parameters(found[3])))


def _routine(
    name: str, kind: str | None, given: list[Parameter], *, is_loose: bool = False
) -> Routine:
    return Routine(
        name,
        "func" if kind else "proc",
        Kind(kind) if kind else None,
        given,
        "RobotWare",
        is_executed=False,
        is_loose=is_loose,
    )


def parameters(text: str) -> Iterator[Parameter]:
    """The parameters that a line gives between its brackets."""
    groups, sign = 0, ","
    last: Parameter | None = None
    for part in PIECE.findall(text):
        part = part.strip()
        if part in ("\\", ",", "|") or part[0] == "|":
            sign = part.replace(" ", "")
            continue
        parameter = _parameter(part, sign.endswith("\\"))
        if sign.startswith("|"):
            assert last is not None
            if not parameter.is_optional:
                last.others.append(parameter)
                continue
            if not last.group:
                groups += 1
                last.group = groups
            parameter.group = last.group
        last = parameter
        yield parameter


def _parameter(text: str, is_optional: bool) -> Parameter:
    found = PARAMETER.fullmatch(text)
    assert found is not None, text
    mode, kind, name, stars = found.groups()
    if name is None:
        kind, name = "switch", kind
    dims = stars.count("*") if stars else 0
    of = UNKNOWN if kind == "any" else Kind(kind, dims)
    return Parameter(name.lower(), of, MODES.get(mode, "value"), is_optional)
