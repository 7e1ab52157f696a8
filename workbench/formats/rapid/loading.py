"""Modules loaded into a task: everything declared, checked and compiled before anything runs."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from lark import Token, Tree

from workbench.formats.rapid.grammar import parse
from workbench.formats.rapid.prelude import constants, prelude
from workbench.formats.rapid.problems import BadModule, Problem, RapidError
from workbench.formats.rapid.statements import Host, Key, Statements
from workbench.formats.rapid.symbols import (
    Frame,
    Node,
    Parameter,
    Routine,
    Run,
    Variable,
    only,
    parts,
    words,
)  # fmt: skip
from workbench.formats.rapid.values import NUM, UNKNOWN, Kind, Types, copy

MOST_VALUES = 200_000
"""Numbers, strings and the like in one array: a controller has no memory for more."""

MOST_COMPONENTS = 10_000
"""The same of a record, with the components of its components."""

MAY_FAIL = {"call", "late", "function", "index", "raise_", "connect"}
"""What an error can come of, beside computing."""


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


def read_source(path: str, text: str) -> Source:
    """A module.

    Raises:
        BadModule: it is no RAPID.
    """
    return Source(path, parse(text, path), text)


@cache
def _prelude() -> tuple[Source, ...]:
    return (read_source("predefined", prelude()), read_source("predefined", constants()))


class Loaded:
    """The modules of one task.

    `keys` are all statements; `problems` whatever is wrong; `find` gives a name's meaning.
    """

    def __init__(
        self,
        sources: Sequence[Source],
        host: Host,
        *,
        natives: Mapping[str, Callable[..., Any]],
        makers: Mapping[str, Callable[[str], Any]],
        shared: dict[str, list[Any]],
        signals: Sequence[str] = (),
        told: Callable[[RapidError], None] = lambda error: None,
    ) -> None:
        """Load them.

        Args:
            sources: the modules, first those that others need.
            host: runs the statements.
            natives: what the controller does, by small name.
            makers: data of types that have no value, by small name of the type.
            shared: the persistents of all tasks by small name; those that are new are added.
            signals: names of the outputs.
            told: called with an error before its handler runs.
        """
        self.types = Types(makers=dict(makers))
        self.globals: dict[str, Any] = {}
        self.problems: list[Problem] = []
        self.keys: set[Key] = set()
        self._host, self._natives, self._shared, self._told = host, natives, shared, told
        self._calls: list[Frame] = []
        self._native = True
        for source in _prelude():
            self._declare([source])
        self._native = False
        for signal in signals:
            kind = Kind("signaldo")
            self.globals[signal.lower()] = Variable(signal, kind, (), ([signal], 0), -1, "const")
        self._declare(sources)
        self._check_main(sources)

    def find(self, name: str) -> Any:
        """What a global name stands for."""
        return self.globals.get(name)

    def check(self) -> None:
        """Refuse what cannot run.

        Raises:
            BadModule: with all problems.
        """
        if self.problems:
            raise BadModule(sorted(self.problems))

    def _check_main(self, sources: Sequence[Source]) -> None:
        main = self.find("main")
        if not isinstance(main, Routine) or main.word != "proc":
            modules = ", ".join(one.path for one in sources)
            self.problems.append(Problem(modules, 1, 1, "no module of the task has a PROC main"))
        elif main.parameters and main.node is not None:
            at = main.node.meta
            what = "main cannot have parameters"
            self.problems.append(Problem(main.module, at.line, at.column, what))

    def _declare(self, sources: Sequence[Source]) -> None:
        scopes = [(source, self._scope(source)) for source in sources]
        for source, scope in scopes:
            self._types(source, scope)
        bodies: list[tuple[_Scope, Routine]] = []
        data: list[tuple[_Scope, Node]] = []
        for source, scope in scopes:
            for node in source.tree.children:
                if not isinstance(node, Tree):
                    continue
                if node.data in ("proc", "func", "trap"):
                    routine = self._routine(scope, node)
                    own = self._scope(source, scope.own)
                    bodies.append((own, routine))
                elif node.data == "data":
                    data.append((scope, node))
        self._data(data)
        for own, routine in bodies:
            self._body(own, routine)

    def _scope(self, source: Source, own: dict[str, Any] | None = None) -> "_Scope":
        scope = _Scope(self.types, source.path, self.problems, self._host)
        scope.own = {} if own is None else own
        scope.find = lambda name: scope.own.get(name) or self.globals.get(name)
        scope.keys = self.keys
        return scope

    def _new(self, scope: "_Scope", node: Any, name: Token, symbol: Any) -> None:
        table = scope.own if "local" in words(node) else self.globals
        if name.lower() in scope.own or (name.lower() in table and not self._native):
            scope.wrong(name, f"{name} is declared already")
        table[name.lower()] = symbol

    def _types(self, source: Source, scope: "_Scope") -> None:
        for node in source.tree.children:
            if isinstance(node, Tree) and node.data == "record":
                *_, name = (one for one in parts(node) if isinstance(one, Token))
                rows = [parts(one) for one in parts(node) if isinstance(one, Tree)]
                # It has no name yet: a record cannot contain itself.
                known = [(kind, part) for kind, part in rows if self._kind(scope, kind) != UNKNOWN]
                size = sum(self.types.atoms(Kind(kind.lower())) for kind, _ in known)
                if size > MOST_COMPONENTS:
                    scope.wrong(name, f"{name} has more than {MOST_COMPONENTS:,} components in all")
                elif self._is_new_type(scope, name):
                    fields = {part.lower(): kind.lower() for kind, part in known}
                    self.types.records[name.lower()] = fields
            elif isinstance(node, Tree) and node.data == "alias":
                of, name = parts(node)[-2:]
                if self._kind(scope, of) != UNKNOWN and self._is_new_type(scope, name):
                    self.types.aliases[name.lower()] = of.lower()

    def _is_new_type(self, scope: Statements, name: Token) -> bool:
        if self.types.exists(name.lower()):
            scope.wrong(name, f"the type {name} is declared already")
            return False
        return True

    def _kind(self, scope: Statements, name: Token, dims: int = 0) -> Kind:
        if not self.types.exists(name.lower()):
            scope.wrong(name, f"there is no type {name}")
            return UNKNOWN
        return Kind(name.lower(), dims)

    # -- data

    def _data(self, waiting: list[tuple["_Scope", Node]]) -> None:
        """Declare data; values may need constants that come later, so rounds are made."""
        while waiting:
            left: list[tuple[_Scope, Node]] = []
            for scope, node in waiting:
                before = len(self.problems)
                variable = self._variable(scope, node)
                if len(self.problems) > before and len(waiting) > 1:
                    left.append((scope, node))
                    del self.problems[before:]
                else:
                    self._new(scope, node, parts(node)[-3], variable)
            if len(left) == len(waiting):
                for scope, node in waiting:
                    self._new(scope, node, parts(node)[-3], self._variable(scope, node))
                return
            waiting = left

    def _variable(self, scope: "_Scope", node: Node) -> Variable:
        before = len(self.problems)
        type_, name, dims, value = parts(node)[-4:]
        storage = next(word for word in ("const", "var", "pers") if word in words(node))
        sizes = self._sizes(scope, dims)
        kind = self._kind(scope, type_, len(sizes))
        if math.prod(sizes) * self.types.atoms(kind) > MOST_VALUES:
            scope.wrong(name, f"{name} has more than {MOST_VALUES:,} values")
            sizes = (1,) * len(sizes)
        variable = Variable(str(name), kind, sizes, None, -1, storage)
        is_shared = storage == "pers" and not words(node) & {"local", "task"}
        if is_shared and name.lower() in self._shared and not self._native:
            cell = self._shared[name.lower()]
            if isinstance(cell, Persistent) and cell.shape != (self.types.shape(kind), sizes):
                scope.wrong(name, f"the PERS {name} has another type or size in another task")
            variable.place = (cell, 0)
            return variable
        content = self.types.default(kind, sizes, name.lower())
        if value is not None:
            found = scope.value(value, kind)
            if sizes and found.sizes and found.sizes != sizes:
                scope.wrong(value, f"{name} has {sizes} elements, not {found.sizes}")
            if not found.is_constant and found.kind != UNKNOWN:
                scope.wrong(value, "this is not known before the program runs")
            elif found.kind != UNKNOWN:
                known = scope.known(value, found)
                content = content if known is None else known
        elif storage == "const":
            scope.wrong(name, f"the constant {name} has no value")
        cell = Persistent([content])
        cell.shape = (self.types.shape(kind), sizes)
        variable.place = (cell, 0)
        if is_shared and len(self.problems) == before:
            self._shared[name.lower()] = cell
        return variable

    def _sizes(self, scope: Statements, dims: Node | None) -> tuple[int, ...]:
        sizes: list[int] = []
        for one in parts(dims) if dims is not None else ():
            found = scope.value(one, NUM)
            size = scope.known(one, found) if found.is_constant else 0.0
            if size is not None and (size < 1 or size != int(size)):
                scope.wrong(one, "an array has a constant whole number of elements")
                size = None
            sizes.append(int(size or 1))
        return tuple(sizes)

    # -- routines

    def _routine(self, scope: "_Scope", node: Node) -> Routine:
        heads = [one for one in parts(node) if isinstance(one, Token)]
        word, name = str(node.data), heads[-1]
        kind = self._kind(scope, heads[0]) if word == "func" else None
        params = only(node, "params")
        parameters = list(self._parameters(scope, params)) if params is not None else []
        native = self._natives.get(name.lower()) if self._native else None
        routine = Routine(str(name), word, kind, parameters, scope.module, node, native)
        routine.told, routine.calls = self._told, self._calls
        if native is not None and name.lower() == "waituntil":
            next(one for one in parameters if one.name == "cond").mode = "lazy"
        self._new(scope, node, name, routine)
        return routine

    def _parameters(self, scope: Statements, params: Node):
        group = 0
        for child in parts(params):
            if child is None:
                continue
            inner = parts(child) if child.data == "optional" else [child]
            group += 1
            for one in inner:
                type_, name, stars = parts(one)[-3:]
                mode = next(iter(words(one) & {"var", "pers", "inout"}), "value")
                kind = self._kind(scope, type_, len(stars.children) if stars is not None else 0)
                is_optional = child.data == "optional"
                shared = group if len(inner) > 1 else 0
                yield Parameter(name.lower(), kind, mode, is_optional, shared)

    def _body(self, own: "_Scope", routine: Routine) -> None:
        node = routine.node
        if self._native or node is None:
            return
        own.routine = routine
        for one in routine.parameters:
            storage = "argument" if one.mode == "value" else one.mode
            own.new_slot(Variable(one.name, one.kind, (), None, -1, storage, one.is_optional))
        for declared in parts(only(node, "locals") or node):
            variable = self._variable(own, declared)
            if variable.name.lower() in own.locals:
                own.wrong(declared, f"{variable.name} is declared already")
            if variable.storage == "pers":
                own.wrong(declared, "a PERS cannot be declared in a routine")
            holder, at = variable.place or ([0.0], 0)
            routine.locals.append(
                (routine.slots, _fresh(holder[at], self.types, variable)),
            )
            variable.place = None
            own.new_slot(variable)
        block = only(node, "block")
        assert block is not None
        routine.body = own.block(block)
        error, undo = only(node, "error"), only(node, "undo")
        if error is not None:
            routine.handler = own.handler(error)
            if not any(_may_fail(one) for one in block.iter_subtrees()):
                own.wrong(error, f"nothing in {routine.name} can get here")
        if undo is not None:
            routine.undo = own.block(parts(undo)[-1])


class Persistent(list[Any]):
    """Where the value of a persistent is, for all tasks, and of what type and sizes it is."""

    shape: Any = None


class _Scope(Statements):
    """Names that one module has for itself, and then all others."""

    own: dict[str, Any]


def _fresh(content: Any, types: Types, variable: Variable) -> Run:
    if types.base(Kind(variable.kind.name)).name in types.makers:
        return lambda frame: types.default(variable.kind, variable.sizes, variable.name.lower())
    return lambda frame: copy(content)


def _may_fail(node: Node) -> bool:
    signs = {"/", "div", "mod", "+"}
    return node.data in MAY_FAIL or (
        node.data == "binary" and str(node.children[1]).lower() in signs
    )
