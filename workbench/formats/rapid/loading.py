"""Modules loaded into a task: everything declared, checked and compiled before anything runs."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

from workbench.formats.rapid.declaring import Declarations, Scope, Source
from workbench.formats.rapid.hosts import Host
from workbench.formats.rapid.prelude import constants, prelude
from workbench.formats.rapid.problems import (
    REMARK,
    UNKNOWN_NAME,
    BadModule,
    Problem,
    RapidError,
    RapidStop,
)
from workbench.formats.rapid.robotware.table import robotware
from workbench.formats.rapid.symbols import Frame, Node, Routine, Run, Variable, only
from workbench.formats.rapid.syntax.grammar import parse
from workbench.formats.rapid.values import Kind, Types, copy

MAY_FAIL = {"call", "late", "function", "index", "raise_", "connect"}
"""Sources of an error other than computing."""


def read_source(path: str, text: str) -> Source:
    """A module.

    Raises:
        BadModule: it is no RAPID.
    """
    return Source(path, parse(text, path), text)


@cache
def _prelude() -> tuple[Source, ...]:
    return (read_source("predefined", prelude()), read_source("predefined", constants()))


class Loaded(Declarations):
    """The modules of one task.

    `keys` are all statements; `problems` whatever was found; `find` gives a name's meaning.
    """

    def __init__(
        self,
        sources: Sequence[Source],
        host: Host,
        *,
        natives: Mapping[str, Callable[..., Any]],
        makers: Mapping[str, Callable[[str], Any]],
        shared: dict[str, list[Any]],
        signals: Mapping[str, str] | None = None,
        entry: str = "main",
        on_error: Callable[[RapidError], None] = lambda error: None,
    ) -> None:
        """Load them.

        Args:
            sources: the modules, first those that others need.
            host: runs the statements.
            natives: what the controller does, by small name.
            makers: data of types that have no value, by small name of the type.
            shared: the persistents of all tasks by small name; those that are new are added.
            signals: type of each signal, by its name.
            entry: the routine that the task begins with; empty where that is not known.
            on_error: called with an error before its handler runs.
        """
        table = robotware()
        types = table.types.copy()
        types.makers = dict(makers)
        super().__init__(types, host, shared)
        self.globals.update(table.names)
        self._natives, self._on_error = natives, on_error
        self._calls: list[Frame] = []
        self._standing = set(self.globals)
        for source in _prelude():
            self._predefine(source)
        self._standing = set(self.globals)
        for signal, kind in (signals or {}).items():
            # They stand for what is outside: nothing can be assigned to them, VAR takes them.
            known = Variable(signal, Kind(kind), (), ([signal], 0), -1, "var")
            self.globals[signal.lower()] = known
            self._standing.discard(signal.lower())
        self._declare(sources)
        if entry:
            self._check_entry(sources, entry)

    def find(self, name: str) -> Any:
        """What a global name stands for."""
        return self.globals.get(name)

    def check(self) -> None:
        """Refuse what cannot run.

        Raises:
            BadModule: with all problems.
        """
        problems = [problem for problem in self.problems if problem.kind != REMARK]
        if problems:
            raise BadModule(sorted(problems))

    def _predefine(self, source: Source) -> None:
        """Data that RobotWare has, and how far its routines are executed."""
        scope = self.scope(source)
        for node in source.tree.children[1:]:
            if node.data == "data":
                variable = self.variable(scope, node)
                if variable.settle is not None:
                    variable.settle()
                self.globals[variable.name.lower()] = variable
                continue
            taken = self.routine(scope, node)
            known = robotware().names[taken.name.lower()]
            assert type(known) is Routine
            self.globals[taken.name.lower()] = _make_executable(known, taken, self._natives)
        self.problems.clear()

    def _check_entry(self, sources: Sequence[Source], entry: str) -> None:
        main = self.find(entry.lower())
        if not isinstance(main, Routine) or main.word != "proc":
            modules = ", ".join(source.path for source in sources)
            what = f"no module of the task has a PROC {entry}"
            self.problems.add(Problem(modules, 1, 1, what, UNKNOWN_NAME, entry))
        elif main.parameters and main.node is not None:
            at = main.node
            what = f"{entry} cannot have parameters"
            self.problems.add(Problem(main.module, at.line, at.column, what))

    def _declare(self, sources: Sequence[Source]) -> None:
        scopes = [(source, self.scope(source)) for source in sources]
        for own, routine in self.declare_names(scopes):
            routine.on_error, routine.calls = self._on_error, self._calls
            self._body(own, routine)

    def _body(self, own: Scope, routine: Routine) -> None:
        node = routine.node
        assert node is not None
        own.routine = routine
        for parameter in routine.parameters:
            storage = "argument" if parameter.mode == "value" else parameter.mode
            own.new_slot(
                Variable(
                    parameter.name, parameter.kind, (), None, -1, storage, parameter.is_optional
                )
            )
        self._locals(own, routine, node)
        block = only(node, "block")
        assert block is not None
        routine.body = own.block(block)
        for handler in node.children:
            data = getattr(handler, "data", "")
            if data == "error":
                routine.handler = own.handler(handler)
                if not any(_may_fail(descendant) for descendant in block.walk()):
                    own.remark(handler, f"nothing in {routine.name} can get here")
            elif data == "undo":
                routine.undo = own.block(handler.children[-1])
            elif data == "backward":
                own.left_out(handler, "BACKWARD")
                own.block(handler.children[-1])

    def _locals(self, own: Scope, routine: Routine, node: Node) -> None:
        for declared in (only(node, "locals") or node).children:
            if declared.data == "place":
                own.left_out(declared, str(declared.children[0]))
                continue
            variable = self.variable(own, declared)
            if variable.settle is not None:
                variable.settle()
            if variable.name.lower() in own.locals:
                own.wrong(declared, f"{variable.name} is declared already")
            if variable.storage == "pers":
                own.wrong(declared, "a PERS cannot be declared in a routine")
            holder, at = variable.place or ([0.0], 0)
            routine.locals.append((routine.slots, _fresh(holder[at], self.types, variable)))
            variable.place = None
            own.new_slot(variable)


def _make_executable(
    known: Routine, taken: Routine, natives: Mapping[str, Callable[..., Any]]
) -> Routine:
    """A routine of RobotWare with what is executed of it."""
    takes = {parameter.name: parameter for parameter in taken.parameters}
    given: list[Any] = []
    for parameter in known.parameters:
        mine = takes.get(parameter.name)
        others = [
            replace(other, executed_as=_kind_taken(takes, other.name)) for other in parameter.others
        ]
        mode = mine.mode if mine is not None else parameter.mode
        if known.name.lower() == "waituntil" and parameter.name == "cond":
            mode = "lazy"
        executed_as = mine.kind if mine is not None else None
        given.append(replace(parameter, mode=mode, others=others, executed_as=executed_as))
    native = natives.get(taken.name.lower()) or _missing(taken.name)
    return replace(
        known, parameters=given, native=native, takes=list(takes), is_executed=True, calls=[]
    )


def _kind_taken(takes: Mapping[str, Any], name: str) -> Kind | None:
    return takes[name].kind if name in takes else None


def _missing(name: str) -> Callable[..., Any]:
    def run(*_: Any) -> None:
        raise RapidStop(f"{name} is not executed here")

    return run


def _fresh(content: Any, types: Types, variable: Variable) -> Run:
    if types.base(Kind(variable.kind.name)).name in types.makers:
        return lambda frame: types.default(variable.kind, variable.sizes, variable.name.lower())
    return lambda frame: copy(content)


def _may_fail(node: Node) -> bool:
    signs = {"/", "div", "mod", "+"}
    return node.data in MAY_FAIL or (
        node.data == "binary" and str(node.children[1]).lower() in signs
    )
