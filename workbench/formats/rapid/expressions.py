"""Expressions of RAPID, checked and made callables of Python."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from workbench.formats.rapid.operators import ARITHMETIC, scale, way
from workbench.formats.rapid.problems import (
    LEFT_OUT,
    REMARK,
    UNKNOWN_NAME,
    WRONG,
    Findings,
    Problem,
    RapidError,
    RapidStop,
)
from workbench.formats.rapid.symbols import Frame, Node, Routine, Run, Variable
from workbench.formats.rapid.syntax.tokens import Token, content_of
from workbench.formats.rapid.values import (
    BOOL,
    DNUM,
    NUM,
    RANGES,
    SIGNALS,
    STRING,
    UNKNOWN,
    Kind,
    Place,
    Types,
    copy,
    single,
)


@dataclass(slots=True)
class Ex:
    """An expression: its type, what gives its value, and the place of it if it has one.

    A literal is written out, and may be a num or a dnum.
    """

    kind: Kind
    run: Run
    place: Callable[[Frame], Place] | None = None
    variable: Variable | None = None
    sizes: tuple[int, ...] = ()
    is_constant: bool = False
    is_literal: bool = False


NOTHING = Ex(UNKNOWN, lambda frame: 0.0)
"""An expression of unknown type, so that a mistake is reported only once."""


class Expressions:
    """Compiles expressions in one scope; what is found is collected in `problems`."""

    def __init__(self, types: Types, module: str, problems: Findings) -> None:
        self.types, self.module, self.problems = types, module, problems
        self.locals: dict[str, Variable] = {}
        self.find: Callable[[str], Any] = lambda name: None

    # -- what is found

    def wrong(self, at: Token | Node, what: str) -> Ex:
        """Note a mistake."""
        return self._note(at, what, WRONG)

    def remark(self, at: Token | Node, what: str) -> Ex:
        """Note what a controller takes, though it should not be so."""
        return self._note(at, what, REMARK)

    def unknown(self, name: Token, use: str) -> Ex:
        """Note a name that is declared nowhere here; `use` says what it is used as."""
        self.problems.use(name, use)
        return self._note(name, f"{name} is not known here", UNKNOWN_NAME, str(name))

    def left_out(self, at: Token | Node, name: str) -> Ex:
        """Note what RobotWare has and the interpreter does not execute."""
        return self._note(at, f"{name} is not executed here", LEFT_OUT, name)

    def _note(self, at: Token | Node, what: str, kind: str, name: str = "") -> Ex:
        self.problems.add(Problem(self.module, at.line, at.column, what, kind, name))
        return NOTHING

    # -- names and values

    def symbol(self, name: str) -> Any:
        """What a name stands for here, None for nothing."""
        found = self.locals.get(name.lower()) or self.find(name.lower())
        if type(found) is Variable and found.settle is not None:
            found.settle()
        return found

    def value(self, node: Any, wanted: Kind) -> Ex:
        """An expression that must have a type; aggregates take theirs from it."""
        found = self.expression(node, wanted)
        if found.kind == wanted:
            return found
        if found.kind.name in SIGNALS and self.types.base(wanted) == NUM:
            found = self.read(node, found)
        if not self.types.fit(found.kind, wanted):
            return self.wrong(node, f"a {found.kind} stands where a {wanted} is needed")
        low_high = RANGES.get(wanted.name)
        if low_high is not None and not wanted.dims and found.kind.name != wanted.name:
            return replace(found, run=_in_range(found.run, *low_high, wanted.name), place=None)
        return found

    def read(self, node: Any, found: Ex) -> Ex:
        """The number that a signal has, which an expression may ask for by its name."""
        if found.kind.name not in SIGNALS or found.kind.dims:
            return found
        self.left_out(node, "a signal read by its name")
        return Ex(NUM, found.run)

    def expression(self, node: Any, wanted: Kind | None = None) -> Ex:
        """An expression of any type; `wanted` is the one that would fit."""
        return getattr(self, f"_{node.data}")(node, wanted)

    def evaluate_constant(self, node: Any, found: Ex) -> Any:
        """The value of a constant expression; None where it has none, which is noted."""
        try:
            return found.run(Frame())
        except (RapidError, RapidStop) as error:
            self.wrong(node, str(error))
            return None

    # -- literals

    def _number(self, node: Node, wanted: Kind | None) -> Ex:
        text = str(node.children[0]).lower()
        is_dnum = wanted is not None and self.types.base(wanted) == DNUM
        try:
            value = float(int(text, 0) if text[:2] in ("0x", "0b", "0o") else text)
            value = value if is_dnum else single(value)
        except (RapidError, OverflowError):
            return self.wrong(node, f"{text} is larger than a num can be")
        kind = DNUM if is_dnum else NUM
        return Ex(kind, lambda frame: value, is_constant=True, is_literal=True)

    def _string(self, node: Node, wanted: Kind | None) -> Ex:
        text = content_of(str(node.children[0]))
        return Ex(STRING, lambda frame: text, is_constant=True)

    def _bool(self, node: Node, wanted: Kind | None) -> Ex:
        value = str(node.children[0]).lower() == "true"
        return Ex(BOOL, lambda frame: value, is_constant=True)

    def _place(self, node: Node, wanted: Kind | None) -> Ex:
        return self.left_out(node, str(node.children[0]))

    def _mistake(self, node: Node, wanted: Kind | None) -> Ex:
        return NOTHING

    def _aggregate(self, node: Node, wanted: Kind | None) -> Ex:
        items = node.children
        base = self.types.base(Kind(wanted.name)).name if wanted is not None else ""
        if wanted is None or wanted.is_unknown or (base in self.types.opaque and not wanted.dims):
            for item in items:
                self.expression(item, UNKNOWN)
            if wanted is None:
                self.left_out(node, "[...] whose type nothing says")
            return Ex(wanted or UNKNOWN, lambda frame: 0.0, is_constant=True)
        record = self.types.records.get(base)
        if wanted.dims:
            kinds = [Kind(wanted.name, wanted.dims - 1)] * len(items)
        elif record is not None:
            kinds = [Kind(name) for name in record.values()]
        else:
            return self.wrong(node, f"[...] is no {wanted}")
        if len(kinds) != len(items):
            return self.wrong(node, f"{wanted} has {len(kinds)} components, not {len(items)}")
        found = [self.value(item, kind) for item, kind in zip(items, kinds, strict=True)]
        if any(ex.kind.is_unknown for ex in found):
            return NOTHING
        runs = [ex.run for ex in found]
        sizes = (len(items), *found[0].sizes) if wanted.dims else ()
        if wanted.dims and any(ex.sizes != found[0].sizes for ex in found):
            return self.wrong(node, "the rows of an array differ in length")
        is_constant = all(ex.is_constant for ex in found)
        return Ex(
            wanted,
            lambda frame: [copy(run(frame)) for run in runs],
            sizes=sizes,
            is_constant=is_constant,
        )

    # -- operators

    def _binary(self, node: Node, wanted: Kind | None) -> Ex:
        left, sign, right = node.children
        word = str(sign).lower()
        hint = wanted if word in ARITHMETIC else None
        ex = self.read(left, self.expression(left, hint))
        other = self.read(right, self.expression(right, hint or ex.kind))
        if ex.is_literal and other.kind == DNUM:
            ex = self.expression(left, DNUM)
        if other.is_literal and self.types.base(ex.kind) in (NUM, DNUM):
            other = self.expression(right, ex.kind)
        if ex.kind.is_unknown or other.kind.is_unknown:
            return NOTHING
        found = way(word, self.types.base(ex.kind), self.types.base(other.kind))
        if found is None:
            return self.wrong(sign, f"{ex.kind} {sign} {other.kind} is no expression")
        kind, act = found
        a, b = ex.run, other.run
        return Ex(
            kind,
            lambda frame: act(a(frame), b(frame)),
            is_constant=ex.is_constant and other.is_constant,
            is_literal=ex.is_literal and other.is_literal and kind in (NUM, DNUM),
        )

    def _not_(self, node: Node, wanted: Kind | None) -> Ex:
        found = self.value(node.children[0], BOOL)
        run = found.run
        return Ex(BOOL, lambda frame: not run(frame), is_constant=found.is_constant)

    def _sign(self, node: Node, wanted: Kind | None) -> Ex:
        sign, rest = node.children
        found = self.read(rest, self.expression(rest, wanted))
        base, run = self.types.base(found.kind), found.run
        if base.is_unknown:
            return found
        if base == Kind("pos"):
            sign_of = -1.0 if sign == "-" else 1.0
            return Ex(found.kind, lambda frame: scale(run(frame), sign_of))
        if base not in (NUM, DNUM):
            return self.wrong(rest, f"a {found.kind} stands where a num is needed")
        if sign == "+":
            return replace(found, place=None)
        return replace(found, kind=base, run=_negative(run), place=None, variable=None)

    # -- data

    def _var(self, node: Node, wanted: Kind | None) -> Ex:
        name, index, *components = node.children
        found = self.symbol(str(name))
        if found is None or (type(found) is Routine and found.module == "RobotWare"):
            self._indices(node)
            is_plain = wanted is not None and not wanted.is_unknown and not index and not components
            return self.unknown(name, f"a {wanted}" if is_plain else "data")
        if type(found) is not Variable:
            return self.wrong(name, f"{name} is a routine, not data")
        if not found.is_executed:
            self.left_out(name, found.name)
        ex = _read_variable(found)
        if index is not None:
            ex = self._element(node, ex, index)
        for component in components:
            ex = self._component(component, ex)
        return ex

    def _indices(self, node: Node) -> None:
        """Look at the indices of something that is not known itself."""
        for part in node.children:
            if type(part) is not Token and part is not None:
                for child in part.children if part.data == "index" else ():
                    self.value(child, NUM)
                if part.data == "component":
                    self._indices(part)

    def _element(self, node: Any, ex: Ex, index: Node) -> Ex:
        found = [self.value(child, NUM) for child in index.children]
        if ex.kind.is_unknown:
            return ex
        if len(found) != ex.kind.dims:
            return self.wrong(node, f"{ex.kind} is indexed with {len(found)} numbers")
        for subscript, size in zip(found, ex.sizes, strict=False):
            value = self.evaluate_constant(index, subscript) if subscript.is_constant else 1.0
            if value is None:
                return NOTHING
            if not 1 <= value <= size:
                return self.wrong(index, f"index {value:g} is outside 1 to {size}")
        assert ex.place is not None
        place = _element_place(ex.place, [subscript.run for subscript in found])
        is_constant = ex.is_constant and all(subscript.is_constant for subscript in found)
        return Ex(Kind(ex.kind.name), _read(place), place, ex.variable, (), is_constant)

    def _component(self, node: Node, ex: Ex) -> Ex:
        name, index = node.children
        base = self.types.base(ex.kind).name
        if ex.kind.is_unknown or (base in self.types.opaque and not ex.kind.dims):
            self._indices(node)
            return replace(ex, kind=UNKNOWN)
        record = self.types.records.get(base, {})
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


def _negative(run: Run) -> Run:
    return lambda frame: -run(frame)


def _read_variable(variable: Variable) -> Ex:
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
    return Ex(variable.kind, _read(where), where, variable, variable.sizes, constant)


def _element_place(outer: Callable[[Frame], Place], runs: list[Run]) -> Callable[[Frame], Place]:
    def place(frame: Frame) -> Place:
        holder, at = outer(frame)
        for run in runs:
            holder, at = holder[at], run(frame) - 1
            if not 0 <= at < len(holder) or at != int(at):
                raise RapidError("ERR_OUTOFBND")
            at = int(at)
        return holder, at

    return place


def _read(place: Callable[[Frame], Place]) -> Run:
    def run(frame: Frame) -> Any:
        holder, at = place(frame)
        return holder[at]

    return run


def _in_range(run: Run, low: float, high: float, name: str) -> Run:
    def run_checked(frame: Frame) -> float:
        value = run(frame)
        if not low <= value <= high or value != int(value):
            raise RapidStop(f"{value:g} is no {name}: whole numbers from {low:g} to {high:g}")
        return value

    return run_checked
