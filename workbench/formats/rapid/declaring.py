"""Types, data and routines of modules, declared before anything in them is compiled."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

from workbench.formats.rapid.expressions import NOTHING
from workbench.formats.rapid.hosts import Host, Key
from workbench.formats.rapid.problems import Findings
from workbench.formats.rapid.statements import Statements
from workbench.formats.rapid.symbols import Node, Parameter, Routine, Variable, only, parts, words
from workbench.formats.rapid.syntax.tokens import SyntaxTree, Token
from workbench.formats.rapid.values import ATOMS, NUM, UNKNOWN, Kind, Types

_Thing = TypeVar("_Thing")

MOST_VALUES = 200_000
"""Numbers, strings and the like in one array: a controller has no memory for more."""

MOST_COMPONENTS = 10_000
"""The same of a record, with the components of its components."""

MOST_LEVELS = 100
"""Records within each other."""


@dataclass(frozen=True, slots=True)
class Source:
    """A module as it was read: where from, its syntax tree, its text."""

    path: str
    tree: Node
    text: str

    @property
    def name(self) -> str:
        """What stands after MODULE."""
        return str(self.tree.children[0])


class Persistent(list[Any]):
    """Where the value of a persistent is, for all tasks, and of what type and sizes it is."""

    shape: Any = None


class Scope(Statements):
    """Names that one module has for itself, and then all others."""

    own: dict[str, Any]
    types_of_its_own: dict[str, str]


class Declarations:
    """Declares what modules have, for one task; `globals` are the names of all of them."""

    def __init__(self, types: Types, host: Host, shared: dict[str, list[Any]]) -> None:
        self.types = types
        self.globals: dict[str, Any] = {}
        self.problems = Findings()
        self.keys: set[Key] = set()
        self._host, self._shared = host, shared
        self._standing: set[str] = set()
        self._origins: dict[tuple[int, str], str] = {}
        self._declared_types: set[str] = set()
        self._waiting: dict[str, tuple[Scope, Node]] = {}
        self._under_way: set[str] = set()
        self._depths: dict[str, int] = {}

    def scope(self, source: Source, within: Scope | None = None) -> Scope:
        """What sees the names of a module, and those of all."""
        scope = Scope(self.types, source.path, self.problems, self._host)
        scope.own = {} if within is None else within.own
        scope.types_of_its_own = {} if within is None else within.types_of_its_own
        scope.find = lambda name: scope.own.get(name) or self.globals.get(name)
        scope.keys = self.keys
        return scope

    def declare_names(self, scopes: Sequence[tuple[Source, Scope]]) -> list[tuple[Scope, Routine]]:
        """Declare all types, data and routines; the routines are still to be compiled."""
        self._types(scopes)
        routines: list[tuple[Scope, Routine]] = []
        data: list[tuple[Variable, Scope, Node]] = []
        for source, scope in scopes:
            for node in source.tree.children:
                if type(node) is not SyntaxTree:
                    continue
                if node.data in ("proc", "func", "trap"):
                    routine = self.routine(scope, node)
                    routines.append((self.scope(source, scope), routine))
                elif node.data == "data":
                    variable = self.variable(scope, node)
                    self._new(scope, node, parts(node)[1], variable)
                    data.append((variable, scope, node))
                elif node.data == "place":
                    scope.left_out(node, str(node.children[0]))
        known = {id(variable): (scope, node) for variable, scope, node in data}

        def needs(variable: Variable) -> Iterator[Variable]:
            scope, node = known.get(id(variable), (None, None))
            for descendant in node.walk() if node is not None else ():
                found = (
                    scope.find(descendant.children[0].lower())
                    if scope and descendant.data == "var"
                    else None
                )
                if type(found) is Variable and found.settle is not None:
                    yield found

        for variable in _in_order([declared for declared, _, _ in data], needs):
            if variable.settle is not None:
                variable.settle()
        return routines

    def _new(self, scope: Scope, node: Node, name: Token, symbol: Any) -> None:
        small = name.lower()
        table = scope.own if "local" in words(node) else self.globals
        if small in scope.own or (small in table and small not in self._standing):
            where = self._origins.get((id(table), small), "")
            scope.wrong(name, f"{name} is declared already{where}")
        elif table is self.globals:
            # A name of RobotWare: of an option, or of a version, that this controller has not.
            self._standing.discard(small)
        table[small] = symbol
        self._origins.setdefault((id(table), small), f" in {scope.module}:{name.line}")

    # -- types

    def _types(self, scopes: Sequence[tuple[Source, Scope]]) -> None:
        """Declare all types; what they consist of is found when they are first needed."""
        for source, scope in scopes:
            for node in source.tree.children:
                if type(node) is SyntaxTree and node.data in ("record", "alias"):
                    name = parts(node)[0 if node.data == "record" else 1]
                    self._new_type(scope, node, name)

        def needs(full: str) -> Iterator[str]:
            scope, node = self._waiting[full]
            for descendant in node.walk():
                if descendant.data in ("part", "alias"):
                    small = parts(descendant)[0].lower()
                    name = scope.types_of_its_own.get(small, small)
                    if name in self._waiting:
                        yield name

        for full in list(_in_order(list(self._waiting), needs)):
            if full in self._waiting:
                self._complete(full)

    def _new_type(self, scope: Scope, node: Node, name: Token) -> None:
        small = name.lower()
        if small in ATOMS or small in scope.types_of_its_own or small in self._declared_types:
            scope.wrong(name, f"the type {name} is declared already")
            return
        if "local" in words(node):
            full = f"{small}@{scope.module}"
            scope.types_of_its_own[small] = full
        else:
            full = small
            self._declared_types.add(small)
            self.types.forget(small)
        self._waiting[full] = (scope, node)

    def _complete(self, full: str) -> None:
        """Find out what a type that was declared consists of."""
        scope, node = self._waiting.pop(full)
        self._under_way.add(full)
        if node.data == "alias":
            of = self.kind(scope, parts(node)[0])
            if of.is_unknown:
                self.types.opaque.add(full)
            else:
                self.types.aliases[full] = of.name
        else:
            name, *rows = parts(node)
            self._record(scope, full, name, [row.children for row in rows])
        self._under_way.discard(full)

    def _record(
        self, scope: Scope, full: str, name: Token, rows: Sequence[Sequence[Token]]
    ) -> None:
        kinds = {part.lower(): self.kind(scope, kind) for kind, part in rows}
        if any(kind.is_unknown for kind in kinds.values()):
            self.types.opaque.add(full)
            return
        depth = 1 + max((self._depths.get(kind.name, 0) for kind in kinds.values()), default=0)
        self._depths[full] = depth
        if depth > MOST_LEVELS:
            scope.wrong(name, f"{name} is nested too deeply")
            self.types.opaque.add(full)
            self._depths[full] = 0
            return
        if sum(self.types.atoms(kind) for kind in kinds.values()) > MOST_COMPONENTS:
            scope.wrong(name, f"{name} has more than {MOST_COMPONENTS:,} components in all")
            self.types.opaque.add(full)
            return
        self.types.records[full] = {part: kind.name for part, kind in kinds.items()}

    def kind(self, scope: Scope, name: Token, dims: int = 0) -> Kind:
        """The type of that name; unknown, and noted, where there is none."""
        if type(name) is Token and name.type == "PLACE":
            scope.left_out(name, str(name))
            return UNKNOWN
        small = name.lower()
        full = scope.types_of_its_own.get(small, small)
        if full in self._under_way:
            scope.wrong(name, f"the type {name} contains itself")
            return UNKNOWN
        if full in self._waiting:
            self._complete(full)
        if not self.types.exists(full):
            scope.unknown(name, "a type")
            return UNKNOWN
        return Kind(full, dims)

    # -- data

    def variable(self, scope: Scope, node: Node) -> Variable:
        """Data that are declared; type, sizes and value are found when they are first needed."""
        _, name = parts(node)[:2]
        storage = next(word for word in ("const", "var", "pers") if word in words(node))
        variable = Variable(str(name), UNKNOWN, (), None, -1, storage)

        def settle() -> None:
            variable.settle = lambda: self._goes_round(scope, name, variable)
            self._settle(scope, node, variable)
            variable.settle = None

        variable.settle = settle
        return variable

    def _goes_round(self, scope: Scope, name: Token, variable: Variable) -> None:
        variable.settle = None
        variable.place = ([0.0], 0)
        scope.wrong(name, f"the value of {name} needs itself")

    def _settle(self, scope: Scope, node: Node, variable: Variable) -> None:
        before = len(self.problems)
        type_, name, dims, value = parts(node)
        small, marks = name.lower(), words(node)
        sizes = self._sizes(scope, dims)
        kind = self.kind(scope, type_, len(sizes))
        if math.prod(sizes) * self.types.atoms(kind) > MOST_VALUES:
            scope.wrong(name, f"{name} has more than {MOST_VALUES:,} values")
            sizes = (1,) * len(sizes)
        variable.kind, variable.sizes = kind, sizes
        is_shared = variable.storage == "pers" and not marks & {"local", "task"}
        if is_shared and small in self._shared and not kind.is_unknown:
            cell = self._shared[small]
            if isinstance(cell, Persistent) and cell.shape != (self.types.shape(kind), sizes):
                scope.wrong(name, f"the PERS {name} has another type or size in another task")
            variable.place = (cell, 0)
            return
        content = self._content(scope, variable, name, value)
        cell = Persistent([content])
        cell.shape = (self.types.shape(kind), sizes)
        variable.place = (cell, 0)
        if is_shared and not kind.is_unknown and len(self.problems) == before:
            self._shared[small] = cell

    def _content(self, scope: Scope, variable: Variable, name: Token, value: Any) -> Any:
        """The value that data begin with."""
        kind, sizes = variable.kind, variable.sizes
        content = self.types.default(kind, sizes, name.lower())
        if value is None:
            if variable.storage == "const":
                scope.wrong(name, f"the constant {name} has no value")
            return content
        found = scope.value(value, kind)
        if found.kind.is_unknown or kind.is_unknown:
            return content
        if sizes and found.sizes and found.sizes != sizes:
            scope.wrong(value, f"{name} has {sizes} elements, not {found.sizes}")
        if not found.is_constant:
            scope.wrong(value, "this is not known before the program runs")
            return content
        known = scope.evaluate_constant(value, found)
        return content if known is None else known

    def _sizes(self, scope: Scope, dims: Node | None) -> tuple[int, ...]:
        sizes: list[int] = []
        for child in dims.children if dims is not None else ():
            found = scope.value(child, NUM)
            size = scope.evaluate_constant(child, found) if found.is_constant else 0.0
            if found is NOTHING:
                size = None
            if size is not None and (size < 1 or size != int(size)):
                scope.wrong(child, "an array has a constant whole number of elements")
                size = None
            sizes.append(int(size or 1))
        return tuple(sizes)

    # -- routines

    def routine(self, scope: Scope, node: Node) -> Routine:
        """A routine with its parameters, still without what it does."""
        *heads, name = (part for part in parts(node) if type(part) is Token)
        kind = self.kind(scope, heads[0]) if node.data == "func" else None
        params = only(node, "params")
        parameters = list(self._parameters(scope, params)) if params is not None else []
        routine = Routine(str(name), node.data, kind, parameters, scope.module, node)
        self._new(scope, node, name, routine)
        return routine

    def _parameters(self, scope: Scope, params: Node) -> Iterator[Parameter]:
        for group, child in enumerate(params.children, start=1):
            if child.data == "place":
                continue
            is_optional = child.data == "optional"
            inner = child.children if is_optional else [child]
            for node in inner:
                type_, name, stars = parts(node)
                mode = next(iter(words(node) & {"var", "pers", "inout"}), "value")
                kind = self.kind(scope, type_, len(stars.children) if stars is not None else 0)
                shared = group if len(inner) > 1 else 0
                yield Parameter(name.lower(), kind, mode, is_optional, shared)


def _in_order(
    things: Sequence[_Thing], needs: Callable[[_Thing], Iterator[_Thing]]
) -> Iterator[_Thing]:
    """Things with all that they need before them: long chains must not run out of stack."""
    seen = set[Any]()
    for first in things:
        if _key(first) in seen:
            continue
        seen.add(_key(first))
        stack = [(first, needs(first))]
        while stack:
            thing, rest = stack[-1]
            needed = next(
                (needed_thing for needed_thing in rest if _key(needed_thing) not in seen), None
            )
            if needed is None:
                stack.pop()
                yield thing
            else:
                seen.add(_key(needed))
                stack.append((needed, needs(needed)))


def _key(thing: Any) -> Any:
    return thing if isinstance(thing, str) else id(thing)
