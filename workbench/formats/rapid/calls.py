"""Calls of RAPID, with their arguments checked against the parameters."""

from typing import Any

from workbench.formats.rapid.expressions import NOTHING, Ex, Expressions
from workbench.formats.rapid.symbols import Frame, Node, Parameter, Routine, Run, Variable
from workbench.formats.rapid.values import BOOL, NUM, UNKNOWN, copy


class Calls(Expressions):
    """Compiles calls of functions and procedures."""

    def _function(self, node: Node, wanted: Any) -> Ex:
        name, args = node.children
        routine = self.symbol(str(name))
        special = str(name).lower()
        if special in ("present", "dim") and args is not None:
            return self._of_argument(node, special, args)
        if routine is None:
            self.loose(args)
            return self.unknown(name, "a function")
        if type(routine) is not Routine or (routine.kind is None and not routine.is_loose):
            return self.wrong(name, f"{name} is no function")
        run = self.bind(routine, args, node)
        return Ex(routine.kind or UNKNOWN, run)

    def _of_argument(self, node: Node, name: str, args: Node) -> Ex:
        given = args.children
        if len(given) != (1 if name == "present" else 2):
            return self.wrong(node, f"this is not how many arguments {name} has")
        found = self.expression(given[0])
        which = self.value(given[1], NUM).run if name == "dim" else None
        if found.kind.is_unknown:
            return Ex(BOOL if which is None else NUM, NOTHING.run)
        if found.variable is None or (name == "dim" and not found.kind.dims):
            what = "an argument" if name == "present" else "an array"
            return self.wrong(node, f"{name} wants {what}")
        if which is None:
            slot = found.variable.slot
            return Ex(BOOL, lambda frame: frame[slot] is not None)
        run = found.run

        def size(frame: Frame) -> float:
            array = run(frame)
            for _ in range(int(which(frame)) - 1):
                array = array[0]
            return float(len(array))

        return Ex(NUM, size)

    def loose(self, args: Node | None) -> None:
        """Look at arguments of which nothing is known."""
        for item in args.children if args is not None else ():
            if item.data in ("named", "by_name"):
                for child in item.children[1:]:
                    self.expression(child, UNKNOWN)
            elif item.data != "passed_on":
                self.expression(item, UNKNOWN)

    def bind(self, routine: Routine, args: Node | None, node: Node) -> Run:
        """A call with its arguments, checked against the parameters."""
        if not routine.is_executed:
            self.left_out(node, routine.name)
        if routine.is_loose:
            self.loose(args)
            return NOTHING.run
        given = self._bind_arguments(routine, args, node)
        groups = [
            parameter.group
            for parameter in routine.parameters
            if parameter.group and parameter.name in given
        ]
        if len(groups) != len(set(groups)):
            self.wrong(node, f"{routine.name}: arguments that exclude each other")
        if routine.native is None:
            makers = [given.get(parameter.name) for parameter in routine.parameters]
            return lambda frame: routine.call([make(frame) if make else None for make in makers])
        return _native(routine, given)

    def _bind_arguments(self, routine: Routine, args: Node | None, node: Node) -> dict[str, Run]:
        by_name = {parameter.name: parameter for parameter in routine.parameters}
        given: dict[str, Run] = {}
        required = [parameter for parameter in routine.parameters if not parameter.is_optional]
        for item in args.children if args is not None else ():
            if item.data in ("named", "passed_on"):
                parameter = by_name.get(str(item.children[0]).lower())
                if parameter is None or not parameter.is_optional or parameter.name in given:
                    what = f"{routine.name} has no argument \\{item.children[0]}"
                    self.wrong(item.children[0], what if parameter is None else f"{what} here")
                    continue
                if routine.takes and parameter.name not in routine.takes:
                    self.left_out(item.children[0], f"{routine.name} \\{item.children[0]}")
                given[parameter.name] = self._bind_named(routine, item, parameter)
            elif not required:
                self.wrong(item, f"{routine.name} has no more arguments")
            elif item.data == "by_name":
                parameter = _find_required(required, str(item.children[0]).lower())
                if parameter is None:
                    what = f"{routine.name} has no argument {item.children[0]} here"
                    self.wrong(item.children[0], what)
                    continue
                required.remove(parameter)
                given[parameter.name] = self._argument(routine, item.children[1], parameter)
            else:
                parameter = required.pop(0)
                given[parameter.name] = self._argument(routine, item, parameter)
        if required:
            self.wrong(
                node, f"{routine.name} misses {', '.join(parameter.name for parameter in required)}"
            )
        return given

    def _bind_named(self, routine: Routine, item: Node, parameter: Parameter) -> Run:
        if item.data == "passed_on":
            name = item.children[1]
            found = self.symbol(str(name))
            if found is None:
                self.unknown(name, "an argument")
                return NOTHING.run
            if type(found) is not Variable or not found.is_optional:
                self.wrong(name, f"{name} is no optional argument")
                return NOTHING.run
            slot = found.slot
            return lambda frame: frame[slot]
        value = item.children[1] if len(item.children) > 1 else None
        if parameter.kind.name == "switch":
            if value is not None:
                self.wrong(item, f"\\{parameter.name} takes no value")
            return lambda frame: ([True], 0)
        if value is None:
            self.wrong(item, f"\\{parameter.name} needs a value")
            return NOTHING.run
        return self._argument(routine, value, parameter)

    def _fitting(self, item: Node, parameter: Parameter) -> Parameter:
        """Which of the alternatives for one place an argument is."""
        if not parameter.others:
            return parameter
        kind = self.read(item, self.expression(item, parameter.kind)).kind
        options = (parameter, *parameter.others)
        return next((option for option in options if self.types.fit(kind, option.kind)), parameter)

    def _argument(self, routine: Routine, item: Node, parameter: Parameter) -> Run:
        parameter = self._fitting(item, parameter)
        found = self.value(item, parameter.kind)
        if routine.native is not None and not found.kind.is_unknown:
            is_left_out = parameter.is_optional and parameter.name not in routine.takes
            fits = parameter.executed_as is not None and self.types.fit(
                found.kind, parameter.executed_as
            )
            if not is_left_out and not fits:
                self.left_out(item, f"{routine.name} of a {found.kind}")
        if parameter.mode == "lazy":
            run = found.run
            return lambda frame: ([lambda: run(frame)], 0)
        if parameter.mode == "value":
            run = found.run
            return lambda frame: ([copy(run(frame))], 0)
        variable = found.variable
        if found is NOTHING:
            return lambda frame: ([0.0], 0)
        wants_write = parameter.mode in ("var", "inout")
        if found.place is None or variable is None or (wants_write and not variable.is_writable):
            self.wrong(item, f"{parameter.name} needs data that can be written")
        elif parameter.mode == "var" and variable.storage == "pers":
            self.wrong(item, f"{parameter.name} needs a VAR, {variable.name} is a PERS")
        elif parameter.mode == "pers" and variable.storage not in ("pers", "inout"):
            self.wrong(item, f"{parameter.name} needs a PERS, {variable.name} is none")
        return found.place or found.run


def _find_required(required: list[Parameter], name: str) -> Parameter | None:
    for parameter in required:
        if name in (parameter.name, *(other.name for other in parameter.others)):
            return parameter
    return None


def _native(routine: Routine, given: dict[str, Run]) -> Run:
    native = routine.native
    assert native is not None
    modes = {parameter.name: parameter.mode for parameter in routine.parameters}
    makers = [(given.get(name), modes[name] in ("value", "lazy")) for name in routine.takes]

    def run(frame: Frame) -> Any:
        values: list[Any] = []
        for make, is_value in makers:
            place = make(frame) if make else None
            values.append(place[0][place[1]] if is_value and place is not None else place)
        return native(*values)

    return run
