"""Calls of RAPID, with their arguments checked against the parameters."""

from typing import Any

from lark import Tree

from workbench.formats.rapid.expressions import Ex, Expressions
from workbench.formats.rapid.symbols import (
    Frame,
    Node,
    Parameter,
    Routine,
    Run,
    Variable,
    parts,
)
from workbench.formats.rapid.values import BOOL, NUM, UNKNOWN, copy


class Calls(Expressions):
    """Compiles calls of functions and procedures."""

    def _function(self, node: Node) -> Ex:
        name, args = node.children
        routine = self.symbol(str(name))
        special = str(name).lower()
        if special in ("present", "dim") and isinstance(args, Tree):
            return self._of_argument(node, special, args)
        if not isinstance(routine, Routine) or routine.kind is None:
            what = "is no function" if routine is not None else "is not declared or not known here"
            return self.wrong(name, f"{name} {what}")
        return Ex(routine.kind, self.bound(routine, args, node))

    def _of_argument(self, node: Node, name: str, args: Node) -> Ex:
        given = parts(args)
        if len(given) != (1 if name == "present" else 2):
            return self.wrong(node, f"this is not how many arguments {name} has")
        found = self.expression(given[0])
        if found.variable is None or (name == "dim" and not found.kind.dims):
            what = "an argument" if name == "present" else "an array"
            return self.wrong(node, f"{name} wants {what}")
        if name == "present":
            slot = found.variable.slot
            return Ex(BOOL, lambda frame: frame[slot] is not None)
        which, run = self.value(given[1], NUM).run, found.run

        def size(frame: Frame) -> float:
            array = run(frame)
            for _ in range(int(which(frame)) - 1):
                array = array[0]
            return float(len(array))

        return Ex(NUM, size)

    def bound(self, routine: Routine, args: Node | None, node: Any) -> Run:
        """A call with its arguments, checked against the parameters."""
        by_name = {one.name: one for one in routine.parameters}
        given: dict[str, Any] = {}
        required = [one for one in routine.parameters if not one.is_optional]
        for item in args.children if args is not None else ():
            if isinstance(item, Tree) and item.data in ("named", "passed_on"):
                one = by_name.get(str(item.children[0]).lower())
                if one is None or not one.is_optional or one.name in given:
                    what = f"{routine.name} has no argument \\{item.children[0]}"
                    self.wrong(item.children[0], what if one is None else f"{what} here")
                    continue
                given[one.name] = self._named(item, one)
            elif not required:
                self.wrong(item, f"{routine.name} has no more arguments")
            else:
                one = required.pop(0)
                given[one.name] = self._argument(item, one)
        if required:
            self.wrong(node, f"{routine.name} misses {', '.join(one.name for one in required)}")
        groups = [one.group for one in routine.parameters if one.group and one.name in given]
        if len(groups) != len(set(groups)):
            self.wrong(node, f"{routine.name}: arguments that exclude each other")
        makers = [given.get(one.name) for one in routine.parameters]
        return _call(routine, makers)

    def _named(self, item: Node, one: Parameter) -> Run:
        if item.data == "passed_on":
            found = self.symbol(str(item.children[1]))
            if not isinstance(found, Variable) or not found.is_optional:
                self.wrong(item.children[1], f"{item.children[1]} is no optional argument")
                return lambda frame: None
            slot = found.slot
            return lambda frame: frame[slot]
        value = item.children[1] if len(item.children) > 1 else None
        if one.kind.name == "switch":
            if value is not None:
                self.wrong(item, f"\\{one.name} takes no value")
            return lambda frame: ([True], 0)
        if value is None:
            self.wrong(item, f"\\{one.name} needs a value")
            return lambda frame: None
        return self._argument(value, one)

    def _argument(self, item: Any, one: Parameter) -> Run:
        if one.mode == "lazy":
            run = self.value(item, one.kind).run
            return lambda frame: ([lambda: run(frame)], 0)
        if one.mode == "value":
            run = self.value(item, one.kind).run
            return lambda frame: ([copy(run(frame))], 0)
        found = self.value(item, one.kind)
        variable = found.variable
        if found.kind == UNKNOWN:
            run = found.run
            return lambda frame: ([run(frame)], 0)
        wants_write = one.mode in ("var", "inout")
        if found.place is None or variable is None or (wants_write and not variable.is_writable):
            self.wrong(item, f"{one.name} needs data that can be written")
        elif one.mode == "var" and variable.storage == "pers":
            self.wrong(item, f"{one.name} needs a VAR, {variable.name} is a PERS")
        elif one.mode == "pers" and variable.storage != "pers":
            self.wrong(item, f"{one.name} needs a PERS, {variable.name} is none")
        return found.place or found.run


def _call(routine: Routine, makers: list[Run | None]) -> Run:
    if routine.native is None:
        return lambda frame: routine.call([make(frame) if make else None for make in makers])
    native, modes = routine.native, [one.mode for one in routine.parameters]
    by_value = [mode in ("value", "lazy") for mode in modes]

    def run(frame: Frame) -> Any:
        given: list[Any] = []
        for make, is_value in zip(makers, by_value, strict=False):
            place = make(frame) if make else None
            given.append(place[0][place[1]] if is_value and place is not None else place)
        return native(*given)

    return run
