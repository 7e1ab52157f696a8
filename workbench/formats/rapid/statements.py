"""Statements of RAPID, checked and made callables of Python."""

from collections.abc import Callable
from typing import Any

from workbench.formats.rapid.calls import Calls
from workbench.formats.rapid.expressions import NOTHING, Ex
from workbench.formats.rapid.hosts import (
    LEAVES,
    Host,
    Jump,
    Key,
    act_checked,
    labels_of,
    no_action,
)
from workbench.formats.rapid.problems import Findings, RapidError, RapidStop
from workbench.formats.rapid.symbols import (
    RETRY,
    RETURN,
    TRYNEXT,
    Frame,
    Node,
    Routine,
    Run,
    Variable,
)
from workbench.formats.rapid.values import BOOL, NUM, STRING, Types, copy


class Statements(Calls):
    """Compiles the statements of one routine for a host."""

    def __init__(self, types: Types, module: str, problems: Findings, host: Host) -> None:
        super().__init__(types, module, problems)
        self.host = host
        self.routine: Routine | None = None
        self.keys: set[Key] = set()
        self._in_handler = False
        self._labels: list[set[str]] = []

    def block(self, node: Node) -> Run:
        """Statements one after the other; the first that does not go on ends it."""
        runs: list[Run] = []
        labels = labels_of(node)
        self._labels.append(set(labels))
        for k, child in enumerate(node.children):
            if k and node.children[k - 1].data in LEAVES and child.data != "label":
                self.remark(child, "this is never reached")
            runs.append(getattr(self, f"_{child.data}_statement")(child))
        self._labels.pop()

        def run(frame: Frame) -> Any:
            for statement in runs:
                signal = statement(frame)
                if signal is not None:
                    return signal
            return None

        def run_with_labels(frame: Frame) -> Any:
            at = 0
            while at < len(runs):
                signal = runs[at](frame)
                at += 1
                if type(signal) is Jump and signal.label in labels:
                    at = labels[signal.label]
                elif signal is not None:
                    return signal
            return None

        return run_with_labels if labels else run

    def handler(self, node: Node) -> Run:
        """The statements of ERROR."""
        *numbers, block = node.children
        for number in numbers:
            self.value(number, NUM)
            self.left_out(node, "numbers after ERROR")
        self._in_handler = True
        try:
            return self.block(block)
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
        key = (self.module, node.line, node.column)
        self.keys.add(key)
        routine, host = self.routine, self.host
        assert routine is not None

        def run(frame: Frame) -> tuple[bool, Any]:
            while True:
                host.step(key)
                try:
                    try:
                        return True, act_checked(act, frame)
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
        if target is NOTHING:
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
        if routine is None:
            self.loose(args)
            self.unknown(name, "a procedure")
            return NOTHING.run
        if type(routine) is not Routine or (routine.word != "proc" and not routine.is_loose):
            self.wrong(name, f"{name} is no procedure")
            return NOTHING.run
        run = self.bind(routine, args, node)

        def act(frame: Frame) -> None:
            run(frame)

        return self._simple(node, act)

    def _late_statement(self, node: Node) -> Run:
        """A procedure whose name is computed; only those without arguments."""
        name, args = node.children
        found, find = self.value(name, STRING), self.find
        run = found.run
        if args is not None:
            self.loose(args)
            self.left_out(node, "a late call with arguments")
        if found.is_constant and name.data == "string" and find(run(Frame()).lower()) is None:
            self.remark(name, f"no procedure {run(Frame())} is known here: this call fails")

        def act(frame: Frame) -> None:
            routine = find(run(frame).lower())
            if not isinstance(routine, Routine) or routine.word != "proc" or routine.parameters:
                raise RapidError("ERR_REFUNKPRC")
            routine.call([])

        return self._simple(node, act)

    def _connect_statement(self, node: Node) -> Run:
        var, name = node.children
        place = self.value(var, NUM).place
        trap = self.symbol(str(name))
        if trap is None or place is None:
            if trap is None:
                self.unknown(name, "a trap routine")
            return NOTHING.run
        if type(trap) is not Routine or trap.word != "trap":
            self.wrong(name, f"{name} is no trap routine")
            return NOTHING.run
        connect = self.host.connect
        return self._simple(node, lambda frame: connect(place(frame), trap))

    # -- branches and loops

    def _if__statement(self, node: Node) -> Run:
        children = node.children
        conditions = [self.value(child, BOOL).run for child in children[:-1:2]]
        blocks = [self.block(child) for child in children[1:-1:2]]
        # The last child is the block after ELSE, None when there is none.
        blocks.append(self.block(children[-1]) if children[-1] is not None else lambda frame: None)

        def choose(frame: Frame) -> Run:
            for condition, block in zip(conditions, blocks, strict=False):
                if condition(frame):
                    return block
            return blocks[-1]

        return self._choice(node, choose)

    def _if_compact_statement(self, node: Node) -> Run:
        condition, then = node.children
        run = self.value(condition, BOOL).run
        block: Run = getattr(self, f"_{then.data}_statement")(then)
        return self._choice(node, lambda frame: block if run(frame) else None)

    def _test_statement(self, node: Node) -> Run:
        subject, *cases = node.children
        value = self.expression(subject)
        tries: list[tuple[list[Ex], Run]] = []
        for case in cases[:-1]:
            *labels, body = case.children
            tries.append(([self.value(label, value.kind) for label in labels], self.block(body)))
        default = self.block(cases[-1]) if cases[-1] is not None else None

        def choose(frame: Frame) -> Run | None:
            found = value.run(frame)
            for labels, block in tries:
                if any(label.run(frame) == found for label in labels):
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
        condition, body = node.children
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
        name, *bounds, body = node.children
        runs = [self.value(bound, NUM).run if bound is not None else None for bound in bounds]
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
        routine, given = self.routine, node.children[0]
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
        given = node.children[0]
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
        label = str(node.children[0]).lower()
        if not any(label in labels for labels in self._labels):
            assert self.routine is not None and self.routine.node is not None
            within = (
                labels_of(descendant)
                for descendant in self.routine.node.walk()
                if descendant.data == "block"
            )
            if any(label in labels for labels in within):
                self.left_out(node, "GOTO into a block")
            else:
                self.wrong(node, f"{self.routine.name} has no label {node.children[0]}")
        jump = Jump(label)
        return self._simple(node, lambda frame: jump)

    def _label_statement(self, node: Node) -> Run:
        return no_action

    def _place_statement(self, node: Node) -> Run:
        self.left_out(node, str(node.children[0]))
        return no_action
