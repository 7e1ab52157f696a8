"""Statements of RAPID, checked and made callables of Python."""

from collections.abc import Callable
from typing import Any, Protocol

from workbench.formats.rapid.calls import Calls
from workbench.formats.rapid.expressions import Ex
from workbench.formats.rapid.problems import Problem, RapidError, RapidStop
from workbench.formats.rapid.symbols import (
    RETRY,
    RETURN,
    TRYNEXT,
    Frame,
    Node,
    Routine,
    Run,
    Variable,
    parts,
)  # fmt: skip
from workbench.formats.rapid.values import BOOL, NUM, STRING, UNKNOWN, Types, copy

Key = tuple[str, int, int]
"""Module, line and column of a statement."""

LEAVES = ("return_", "raise_", "retry", "trynext", "exit", "goto")
"""After these nothing is reached in the same block."""


class Host(Protocol):
    """What runs the statements: told of each, and of what only it can do."""

    def step(self, key: Key) -> None:
        """A statement begins."""
        ...

    def hold(self, why: RapidStop) -> None:
        """The program cannot go on, and stays where it is until it is started again."""
        ...

    def exit(self) -> None:
        """EXIT: the program ends."""
        ...

    def connect(self, place: Any, trap: Routine) -> None:
        """CONNECT: an interrupt gets its trap routine."""
        ...


def _acted(act: Run, frame: Frame) -> Any:
    try:
        return act(frame)
    except OverflowError:
        raise RapidError("ERR_NUM_OVERFLOW") from None
    except RecursionError:
        raise RapidStop("routines call each other without end") from None
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        raise RapidStop(f"an argument makes no sense: {error}") from error


class Statements(Calls):
    """Compiles the statements of one routine for a host."""

    def __init__(self, types: Types, module: str, problems: list[Problem], host: Host) -> None:
        super().__init__(types, module, problems)
        self.host = host
        self.routine: Routine | None = None
        self.keys: set[Key] = set()
        self._in_handler = False

    def block(self, node: Node) -> Run:
        """Statements one after the other; the first that does not go on ends it."""
        runs: list[Run] = []
        for k, child in enumerate(node.children):
            if k and node.children[k - 1].data in LEAVES and child.data != "label":
                self.wrong(child, "this is never reached")
            runs.append(getattr(self, f"_{child.data}_statement")(child))

        def run(frame: Frame) -> Any:
            for one in runs:
                signal = one(frame)
                if signal is not None:
                    return signal
            return None

        return run

    def handler(self, node: Node) -> Run:
        """The statements of ERROR."""
        if parts(node)[0] is not None:
            self.wrong(node, "error numbers after ERROR are not executed here")
        self._in_handler = True
        try:
            return self.block(parts(node)[-1])
        finally:
            self._in_handler = False

    def new_slot(self, variable: Variable) -> None:
        """Give local data a place in the frame."""
        assert self.routine is not None
        variable.slot = self.routine.slots
        self.routine.slots += 1
        self.locals[variable.name.lower()] = variable

    def _guard(self, node: Any, act: Run) -> Callable[[Frame], tuple[bool, Any]]:
        """Do something; (True, what came of it), or (False, how to go on after an error)."""
        meta = node.meta
        key = (self.module, meta.line, meta.column)
        self.keys.add(key)
        routine, host = self.routine, self.host
        assert routine is not None

        def run(frame: Frame) -> tuple[bool, Any]:
            while True:
                host.step(key)
                try:
                    try:
                        return True, _acted(act, frame)
                    except RapidError as error:
                        signal = routine.recover(frame, error)
                except RapidStop as why:
                    host.hold(why)
                    continue
                if signal is not RETRY:
                    return False, None if signal is TRYNEXT else signal

        return run

    def _simple(self, node: Any, act: Run) -> Run:
        guarded = self._guard(node, act)
        return lambda frame: guarded(frame)[1]

    # -- data and calls

    def _assign_statement(self, node: Node) -> Run:
        target = self.expression(node.children[0])
        value = self.value(node.children[1], target.kind)
        if target.kind == UNKNOWN:
            return value.run
        place, run = target.place, value.run
        name = str(node.children[0].children[0])
        if place is None or target.variable is None or not target.variable.is_writable:
            self.wrong(node, f"{name} cannot be assigned")
            return run
        if target.kind.dims and target.sizes and value.sizes and target.sizes != value.sizes:
            self.wrong(node, f"{name} is an array of another size")

        def act(frame: Frame) -> None:
            given = copy(run(frame))
            holder, at = place(frame)
            holder[at] = given

        return self._simple(node, act)

    def _call_statement(self, node: Node) -> Run:
        name, args = node.children
        routine = self.symbol(str(name))
        if not isinstance(routine, Routine) or routine.word != "proc":
            known = (
                "is no procedure" if routine is not None else "is not declared or not known here"
            )
            self.wrong(name, f"{name} {known}")
            return lambda frame: None
        run = self.bound(routine, args, node)

        def act(frame: Frame) -> None:
            run(frame)

        return self._simple(node, act)

    def _late_statement(self, node: Node) -> Run:
        """A procedure whose name is computed; only those without arguments."""
        name, args = node.children
        run, find = self.value(name, STRING).run, self.find
        if args is not None:
            self.wrong(node, "a late call with arguments is not executed here")

        def act(frame: Frame) -> None:
            routine = find(run(frame).lower())
            if not isinstance(routine, Routine) or routine.word != "proc" or routine.parameters:
                raise RapidError("ERR_REFUNKPRC")
            routine.call([])

        return self._simple(node, act)

    def _connect_statement(self, node: Node) -> Run:
        var, name = parts(node)
        place = self.value(var, NUM).place
        trap = self.symbol(str(name))
        if not isinstance(trap, Routine) or trap.word != "trap" or place is None:
            self.wrong(name, f"{name} is no trap routine")
            return lambda frame: None
        connect = self.host.connect
        return self._simple(node, lambda frame: connect(place(frame), trap))

    # -- branches and loops

    def _if__statement(self, node: Node) -> Run:
        children = parts(node)
        conditions = [self.value(one, BOOL).run for one in children[:-1:2]]
        blocks = [self.block(one) for one in children[1:-1:2]]
        # The last child is the block after ELSE, None when there is none.
        blocks.append(self.block(children[-1]) if children[-1] is not None else lambda frame: None)

        def choose(frame: Frame) -> Run:
            for condition, block in zip(conditions, blocks, strict=False):
                if condition(frame):
                    return block
            return blocks[-1]

        return self._choice(node, choose)

    def _if_compact_statement(self, node: Node) -> Run:
        condition, then = parts(node)
        run = self.value(condition, BOOL).run
        block: Run = getattr(self, f"_{then.data}_statement")(then)
        return self._choice(node, lambda frame: block if run(frame) else None)

    def _test_statement(self, node: Node) -> Run:
        subject, *cases = parts(node)
        value = self.expression(subject)
        tries: list[tuple[list[Ex], Run]] = []
        for case in cases[:-1]:
            *labels, body = parts(case)
            tries.append(([self.value(one, value.kind) for one in labels], self.block(body)))
        default = self.block(cases[-1]) if cases[-1] is not None else None

        def choose(frame: Frame) -> Run | None:
            found = value.run(frame)
            for labels, block in tries:
                if any(one.run(frame) == found for one in labels):
                    return block
            return default

        return self._choice(node, choose)

    def _choice(self, node: Node, choose: Callable[[Frame], Run | None]) -> Run:
        guarded = self._guard(node, choose)

        def run(frame: Frame) -> Any:
            is_done, chosen = guarded(frame)
            if not is_done:
                return chosen
            return chosen(frame) if chosen is not None else None

        return run

    def _while__statement(self, node: Node) -> Run:
        condition, body = parts(node)
        guarded, block = self._guard(node, self.value(condition, BOOL).run), self.block(body)

        def run(frame: Frame) -> Any:
            while True:
                is_done, value = guarded(frame)
                if not is_done or not value:
                    return None if is_done else value
                signal = block(frame)
                if signal is not None:
                    return signal

        return run

    def _for__statement(self, node: Node) -> Run:
        name, *bounds, body = parts(node)
        runs = [self.value(one, NUM).run if one is not None else None for one in bounds]
        before = self.locals.get(str(name).lower())
        variable = Variable(str(name), NUM, storage="loop")
        self.new_slot(variable)
        block = self.block(body)
        if before is None:
            del self.locals[str(name).lower()]
        else:
            self.locals[str(name).lower()] = before
        slot = variable.slot

        def begin(frame: Frame) -> tuple[float, float, float]:
            given: list[Any] = [run(frame) if run is not None else None for run in runs]
            value, last, step = given
            if step is None:
                step = 1.0 if last >= value else -1.0
            if step == 0:
                raise RapidStop("STEP 0 never ends")
            return value, last, step

        guarded = self._guard(node, begin)

        def run(frame: Frame) -> Any:
            is_done, found = guarded(frame)
            if not is_done:
                return found
            value, last, step = found
            while value <= last if step > 0 else value >= last:
                frame[slot] = ([value], 0)
                signal = block(frame)
                if signal is not None:
                    return signal
                value += step
            return None

        return run

    # -- leaving

    def _return__statement(self, node: Node) -> Run:
        routine, given = self.routine, parts(node)[0]
        assert routine is not None
        if (routine.kind is None) != (given is None):
            self.wrong(node, "RETURN has a value in a FUNC, and in nothing else")
        run = self.value(given, routine.kind or NUM).run if given is not None else None

        def act(frame: Frame) -> str:
            if run is not None:
                frame.result = copy(run(frame))
            return RETURN

        return self._simple(node, act)

    def _raise__statement(self, node: Node) -> Run:
        given = parts(node)[0]
        run = self.value(given, NUM).run if given is not None else None
        if run is None and not self._in_handler:
            self.wrong(node, "RAISE without a number stands in an ERROR handler only")

        def act(frame: Frame) -> None:
            if run is None:
                assert frame.error is not None
                raise frame.error
            raise RapidError("", run(frame))

        return self._simple(node, act)

    def _retry_statement(self, node: Node) -> Run:
        return self._in_a_handler(node, RETRY)

    def _trynext_statement(self, node: Node) -> Run:
        return self._in_a_handler(node, TRYNEXT)

    def _in_a_handler(self, node: Node, signal: str) -> Run:
        if not self._in_handler:
            self.wrong(node, f"{signal} stands in an ERROR handler only")
        return self._simple(node, lambda frame: signal)

    def _exit_statement(self, node: Node) -> Run:
        exit = self.host.exit
        return self._simple(node, lambda frame: exit())

    def _goto_statement(self, node: Node) -> Run:
        self.wrong(node, "GOTO is not executed here")
        return lambda frame: None

    def _label_statement(self, node: Node) -> Run:
        return lambda frame: None
