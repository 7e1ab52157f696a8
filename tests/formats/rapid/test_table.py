"""The tables of RobotWare, and what of them is executed."""

from workbench.formats.rapid.loading import read_source
from workbench.formats.rapid.prelude import constants, prelude
from workbench.formats.rapid.robotware.table import parameters, robotware
from workbench.formats.rapid.symbols import Routine, Variable, parts, words
from workbench.formats.rapid.values import Kind

TABLE = robotware()
NONE = Kind("")
SOURCES = [read_source("x", text) for text in (prelude(), constants())]


def routines():
    for source in SOURCES:
        for node in source.tree.children[1:]:
            if node.data in ("proc", "func"):
                yield node


def test_every_type_that_the_tables_name_is_in_them():
    named = {
        one.kind.name
        for routine in TABLE.names.values() if isinstance(routine, Routine)
        for given in routine.parameters for one in (given, *given.others)
    }  # fmt: skip
    named |= {one.kind.name for one in TABLE.names.values() if isinstance(one, Variable)}
    named |= {part for record in TABLE.types.records.values() for part in record.values()}
    named |= set(TABLE.types.aliases.values())
    assert sorted(name for name in named - {""} if not TABLE.types.exists(name)) == []


def test_what_is_executed_stands_in_the_tables_with_the_same_types():
    for node in routines():
        *kind, name = (one for one in parts(node) if isinstance(one, str))
        known = TABLE.names[name.lower()]
        assert TABLE.types.base(known.kind or NONE) == TABLE.types.base(Kind("".join(kind).lower()))
        by_name = {one.name: one for one in known.parameters}
        for child in next(
            one for one in node.children if getattr(one, "data", "") == "params"
        ).children:
            for one in child.children if child.data == "optional" else [child]:
                type_, argument, stars = parts(one)
                table = by_name[argument.lower()]
                kinds = {TABLE.types.base(one.kind).name for one in (table, *table.others)}
                taken = TABLE.types.base(Kind(type_.lower())).name
                assert taken in kinds or "" in kinds, (name, argument)
                assert table.is_optional == (child.data == "optional"), (name, argument)
                assert table.kind.dims == (len(stars.children) if stars else 0), (name, argument)
                # A place is handed over, or a value: that must not differ.
                by_place = bool(words(one) & {"var", "pers", "inout"})
                assert (table.mode != "value") == by_place, (name, argument)


def test_a_line_of_the_tables_gives_its_parameters():
    line = r"\Conc, robtarget P \identno ID, num A | dnum B \num V | \num T, "
    line += r"VAR byte D{*,*} \On | \Off"
    found = [
        (
            one.name,
            str(one.kind),
            one.mode,
            one.is_optional,
            one.group,
            [o.name for o in one.others],
        )
        for one in list(parameters(line))
    ]
    assert found == [
        ("conc", "switch", "value", True, 0, []),
        ("p", "robtarget", "value", False, 0, []),
        ("id", "identno", "value", True, 0, []),
        ("a", "num", "value", False, 0, ["b"]),
        ("v", "num", "value", True, 1, []),
        ("t", "num", "value", True, 1, []),
        ("d", "byte{*,*}", "inout", False, 0, []),
        ("on", "switch", "value", True, 2, []),
        ("off", "switch", "value", True, 2, []),
    ]


def test_data_come_in_rows():
    assert {"ltapp__apm_p1", "ltapp__apm_p10", "usbdisk10"} <= set(TABLE.names)
