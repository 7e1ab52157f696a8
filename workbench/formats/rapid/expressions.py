"""Expressions of RAPID, checked and made callables of Python."""

import operator
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from lark import Token

from workbench.formats.rapid.grammar import LONGEST_STRING, content_of
from workbench.formats.rapid.problems import Problem, RapidError, RapidStop
from workbench.formats.rapid.symbols import (
    Frame,
    Node,
    Routine,
    Run,
    Variable,
    parts,
)
from workbench.formats.rapid.values import (
    BOOL,
    DNUM,
    NUM,
    RANGES,
    STRING,
    UNKNOWN,
    Kind,
    Place,
    Types,
    copy,
    single,
)  # fmt: skip


@dataclass(slots=True)
class Ex:
    """An expression: its type, what gives its value, and the place of it if it has one."""

    kind: Kind
    run: Run
    place: Callable[[Frame], Place] | None = None
    variable: Variable | None = None
    sizes: tuple[int, ...] = ()
    is_constant: bool = False


WRONG = Ex(UNKNOWN, lambda frame: 0.0)

RELATIONS: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq, "<>": operator.ne, "<": operator.lt, ">": operator.gt,
    "<=": operator.le, ">=": operator.ge,
}  # fmt: skip


def _divide(a: float, b: float) -> float:
    if b == 0:
        raise RapidError("ERR_DIVZERO")
    return a / b


def _whole(name: str, divide: Callable[[int, int], int]) -> Callable[[float, float], float]:
    def run(a: float, b: float) -> float:
        if b == 0:
            raise RapidError("ERR_DIVZERO")
        if a != int(a) or b != int(b):
            raise RapidStop(f"{name} of {a:g} and {b:g}: both must be whole numbers")
        return float(divide(int(a), int(b)))

    return run


def _quotient(a: int, b: int) -> int:
    return -(-a // b) if (a < 0) != (b < 0) else a // b


ARITHMETIC: dict[str, Callable[[float, float], float]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": _divide,
    "div": _whole("DIV", _quotient),
    "mod": _whole("MOD", lambda a, b: a - b * _quotient(a, b)),
}  # fmt: skip


def _joined(a: str, b: str) -> str:
    if len(a) + len(b) > LONGEST_STRING:
        raise RapidError("ERR_STRTOOLNG")
    return a + b


class Expressions:
    """Compiles expressions in one scope; what is wrong is collected in `problems`."""

    def __init__(self, types: Types, module: str, problems: list[Problem]) -> None:
        self.types, self.module, self.problems = types, module, problems
        self.locals: dict[str, Variable] = {}
        self.find: Callable[[str], Any] = lambda name: None

    def wrong(self, node: Any, what: str) -> Ex:
        """Note a problem at a node; an expression of no type, so that one mistake is told once."""
        at = node if isinstance(node, Token) else node.meta
        found = Problem(self.module, getattr(at, "line", 1), getattr(at, "column", 1), what)
        if found not in self.problems:
            self.problems.append(found)
        return WRONG

    def symbol(self, name: str) -> Any:
        """What a name stands for here, None for nothing."""
        return self.locals.get(name.lower()) or self.find(name.lower())

    def value(self, node: Any, wanted: Kind) -> Ex:
        """An expression that must have a type; aggregates take theirs from it."""
        found = self._literal(node, self.expression(node, wanted), wanted)
        if not self.types.fit(found.kind, wanted):
            return self.wrong(node, f"a {found.kind} stands where a {wanted} is needed")
        low_high = RANGES.get(wanted.name)
        if low_high is not None and not wanted.dims and found.kind.name != wanted.name:
            return replace(found, run=_in_range(found.run, *low_high, wanted.name), place=None)
        return found

    def _literal(self, node: Any, found: Ex, wanted: Kind) -> Ex:
        """A number that is written out is a dnum where one is needed."""
        is_one = getattr(node, "data", "") == "number" and self.types.base(wanted) == DNUM
        if not is_one or found.kind != NUM:
            return found
        text = str(node.children[0]).lower()
        value = float(int(text, 0) if text[:2] in ("0x", "0b") else text)
        return Ex(DNUM, lambda frame: value, is_constant=True)

    def expression(self, node: Any, wanted: Kind | None = None) -> Ex:
        """An expression of any type."""
        if node.data == "aggregate":
            return self._aggregate(node, wanted)
        return getattr(self, f"_{node.data}")(node)

    def known(self, node: Any, found: Ex) -> Any:
        """The value of a constant expression; None where it has none, which is noted."""
        try:
            return found.run(Frame())
        except (RapidError, RapidStop) as error:
            self.wrong(node, str(error))
            return None

    # -- literals

    def _number(self, node: Node) -> Ex:
        text = str(node.children[0]).lower()
        try:
            value = single(float(int(text, 0) if text[:2] in ("0x", "0b") else text))
        except (RapidError, OverflowError):
            return self.wrong(node, f"{text} is larger than a num can be")
        return Ex(NUM, lambda frame: value, is_constant=True)

    def _string(self, node: Node) -> Ex:
        text = content_of(str(node.children[0]))
        return Ex(STRING, lambda frame: text, is_constant=True)

    def _bool(self, node: Node) -> Ex:
        value = str(node.children[0]).lower() == "true"
        return Ex(BOOL, lambda frame: value, is_constant=True)

    def _aggregate(self, node: Node, wanted: Kind | None) -> Ex:
        items = parts(node)
        if wanted is None or wanted == UNKNOWN:
            return self.wrong(node, "the type of [...] is not known here")
        record = self.types.records.get(self.types.base(Kind(wanted.name)).name)
        if wanted.dims:
            kinds = [Kind(wanted.name, wanted.dims - 1)] * len(items)
        elif record is not None:
            kinds = [Kind(name) for name in record.values()]
        else:
            return self.wrong(node, f"[...] is no {wanted}")
        if len(kinds) != len(items):
            return self.wrong(node, f"{wanted} has {len(kinds)} components, not {len(items)}")
        found = [self.value(item, kind) for item, kind in zip(items, kinds, strict=True)]
        runs = [one.run for one in found]
        sizes = (len(items), *found[0].sizes) if wanted.dims else ()
        if wanted.dims and any(one.sizes != found[0].sizes for one in found):
            return self.wrong(node, "the rows of an array differ in length")
        is_constant = all(one.is_constant for one in found)
        return Ex(
            wanted,
            lambda frame: [copy(run(frame)) for run in runs],
            sizes=sizes,
            is_constant=is_constant,
        )

    # -- operators

    def _binary(self, node: Node) -> Ex:
        left, sign, right = node.children
        word = str(sign).lower()
        one = self.expression(left)
        other = self._literal(right, self.expression(right, one.kind), one.kind)
        one = self._literal(left, one, other.kind)
        both = one.is_constant and other.is_constant
        a, b, bases = one.run, other.run, {self.types.base(one.kind), self.types.base(other.kind)}
        if UNKNOWN in bases:
            return WRONG
        if word in ("and", "or", "xor") and bases == {BOOL}:
            return Ex(BOOL, _LOGIC[word](a, b), is_constant=both)
        if word in RELATIONS and (
            bases in ({NUM}, {DNUM}) or (word in ("=", "<>") and len(bases) == 1)
        ):
            relation = RELATIONS[word]
            return Ex(BOOL, lambda frame: relation(a(frame), b(frame)), is_constant=both)
        if word in ARITHMETIC and bases == {NUM}:
            act = ARITHMETIC[word]
            return Ex(NUM, lambda frame: single(act(a(frame), b(frame))), is_constant=both)
        if word == "+" and bases == {STRING}:
            return Ex(STRING, lambda frame: _joined(a(frame), b(frame)), is_constant=both)
        if word in ("+", "-") and bases == {Kind("pos")}:
            act = ARITHMETIC[word]
            return Ex(
                one.kind, lambda f: [single(act(x, y)) for x, y in zip(a(f), b(f), strict=False)]
            )
        if word == "*" and bases == {Kind("pos"), NUM} and one.kind.name == "pos":
            return Ex(one.kind, lambda f: [single(x * b(f)) for x in a(f)])
        return self.wrong(sign, f"{one.kind} {sign} {other.kind} is no expression")

    def _not_(self, node: Node) -> Ex:
        run = self.value(node.children[1], BOOL).run
        return Ex(BOOL, lambda frame: not run(frame))

    def _and_not(self, node: Node) -> Ex:
        left, right = parts(node)
        a, b = self.value(left, BOOL).run, self.value(right, BOOL).run
        return Ex(BOOL, lambda frame: a(frame) & (not b(frame)))

    def _sign(self, node: Node) -> Ex:
        sign, rest = node.children
        found = self.value(rest, NUM)
        run = found.run
        if sign == "+":
            return replace(found, place=None)
        return Ex(NUM, lambda frame: -run(frame), is_constant=found.is_constant)

    # -- data

    def _var(self, node: Node) -> Ex:
        name, index, *components = node.children
        found = self.symbol(str(name))
        if not isinstance(found, Variable):
            what = "is a routine, not data" if isinstance(found, Routine) else "is not declared"
            return self.wrong(name, f"{name} {what}")
        variable = found
        if variable.place is not None:
            place = variable.place

            def where(frame: Frame) -> Place:
                return place
        else:
            slot = variable.slot

            def where(frame: Frame) -> Place:
                if frame[slot] is None:
                    raise RapidStop(f"the optional argument {variable.name} was not given")
                return frame[slot]

        constant = variable.storage == "const" and variable.place is not None
        ex = Ex(variable.kind, _read(where), where, variable, variable.sizes, constant)
        if index is not None:
            ex = self._element(node, ex, index)
        for component in components:
            ex = self._component(component, ex)
        return ex

    def _element(self, node: Any, ex: Ex, index: Node) -> Ex:
        found = [self.value(one, NUM) for one in parts(index)]
        if ex.kind == UNKNOWN:
            return ex
        if len(found) != ex.kind.dims:
            return self.wrong(node, f"{ex.kind} is indexed with {len(found)} numbers")
        for one, size in zip(found, ex.sizes, strict=False):
            value = self.known(index, one) if one.is_constant else 1.0
            if value is None:
                return WRONG
            if not 1 <= value <= size:
                return self.wrong(index, f"index {value:g} is outside 1 to {size}")
        assert ex.place is not None
        outer, runs, is_constant = ex.place, [one.run for one in found], ex.is_constant

        def place(frame: Frame) -> Place:
            holder, at = outer(frame)
            for run in runs:
                holder, at = holder[at], run(frame) - 1
                if not 0 <= at < len(holder) or at != int(at):
                    raise RapidError("ERR_OUTOFBND")
                at = int(at)
            return holder, at

        is_constant = is_constant and all(one.is_constant for one in found)
        return Ex(Kind(ex.kind.name), _read(place), place, ex.variable, (), is_constant)

    def _component(self, node: Node, ex: Ex) -> Ex:
        name, index = node.children
        if ex.kind == UNKNOWN:
            return ex
        record = self.types.records.get(self.types.base(ex.kind).name, {})
        if ex.kind.dims or str(name).lower() not in record:
            return self.wrong(name, f"{ex.kind} has no component {name}")
        assert ex.place is not None
        outer, at = ex.place, list(record).index(str(name).lower())

        def place(frame: Frame) -> Place:
            holder, k = outer(frame)
            return holder[k], at

        kind = Kind(record[str(name).lower()])
        found = Ex(kind, _read(place), place, ex.variable, (), ex.is_constant)
        return found if index is None else self._element(node, found, index)


_LOGIC: dict[str, Callable[[Run, Run], Run]] = {
    # Both sides are always computed: what runs so runs on a controller that stops early, too.
    "and": lambda a, b: lambda frame: a(frame) & b(frame),
    "or": lambda a, b: lambda frame: a(frame) | b(frame),
    "xor": lambda a, b: lambda frame: a(frame) != b(frame),
}


def _read(place: Callable[[Frame], Place]) -> Run:
    def run(frame: Frame) -> Any:
        holder, at = place(frame)
        return holder[at]

    return run


def _in_range(run: Run, low: float, high: float, name: str) -> Run:
    def checked(frame: Frame) -> float:
        value = run(frame)
        if not low <= value <= high or value != int(value):
            raise RapidStop(f"{value:g} is no {name}: whole numbers from {low:g} to {high:g}")
        return value

    return checked
