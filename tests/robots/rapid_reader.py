"""A small, strict reader of RAPID: enough of the language for what this project ships.

It knows the block structure, declarations and their scopes, and how routines are called, and
refuses everything that it does not know.  Grammar after ABB, "Technical reference manual: RAPID
kernel".
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

LONGEST_STRING = 80
LONGEST_NAME = 32

RESERVED = {
    "alias", "and", "backward", "case", "connect", "const", "default", "div", "do", "else",
    "elseif", "endfor", "endfunc", "endif", "endmodule", "endproc", "endrecord", "endtest",
    "endtrap", "endwhile", "error", "exit", "false", "for", "from", "func", "goto", "if",
    "inout", "local", "mod", "module", "nostepin", "not", "noview", "or", "pers", "proc",
    "raise", "readonly", "record", "retry", "return", "step", "sysmodule", "task", "test",
    "then", "to", "trap", "true", "trynext", "undo", "var", "viewonly", "while", "with", "xor",
}  # fmt: skip
OPERATORS = {"and", "or", "not", "mod", "div", "xor"}

TOKEN = re.compile(
    r'(?P<space>[ \t]+)|(?P<comment>!.*)|(?P<string>"(?:[^"]|"")*")'
    r"|(?P<number>\d+(?:\.\d+)?(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z][A-Za-z0-9_]*)"
    r"|(?P<sign>:=|<>|<=|>=|[-+*/=<>()\[\]{},;:.\\#])"
)


class RapidError(Exception):
    """What is wrong, and where."""


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    line: int

    @property
    def low(self) -> str:
        return self.text.lower()


@dataclass
class Routine:
    """A PROC, FUNC or TRAP: what it declares and what it uses, with the lines."""

    kind: str
    name: str
    parameters: list[str] = field(default_factory=list)
    local: set[str] = field(default_factory=set)
    calls: list[tuple[str, int, int]] = field(default_factory=list)
    functions: list[tuple[str, int]] = field(default_factory=list)
    uses: list[tuple[str, int]] = field(default_factory=list)


@dataclass
class Module:
    name: str
    data: dict[str, tuple[str, str, list[Token]]] = field(default_factory=dict)
    routines: dict[str, Routine] = field(default_factory=dict)


def tokens_of(text: str) -> list[Token]:
    found: list[Token] = []
    for number, line in enumerate(text.splitlines(), start=1):
        at = 0
        while at < len(line):
            match = TOKEN.match(line, at)
            if match is None:
                raise RapidError(f"line {number}: {line[at : at + 20]!r} is not RAPID")
            kind = str(match.lastgroup)
            token = Token(kind, match[0], number)
            at = match.end()
            if kind == "string" and len(content_of(token)) > LONGEST_STRING:
                raise RapidError(f"line {number}: a string of more than {LONGEST_STRING}")
            if kind == "name" and len(token.text) > LONGEST_NAME:
                raise RapidError(f"line {number}: the name {token.text} is too long")
            if kind not in ("space", "comment"):
                found.append(token)
    return found


def content_of(token: Token) -> str:
    """A string as it is in memory: doubled quotes and hexadecimal characters are one."""
    return re.sub(r"\\[0-9A-F]{2}", "?", token.text[1:-1].replace('""', '"'))


class Reader:
    """One module."""

    def __init__(self, text: str):
        self._tokens = tokens_of(text)
        self._at = 0

    def module(self) -> Module:
        self._word("module")
        module = Module(self._name())
        while not self._is("endmodule"):
            if self._is("const", "pers", "task", "var"):
                kind, name, type_, value = self._declaration()
                self._check_new(name, {**module.data, **module.routines})
                module.data[name] = (kind, type_, value)
            elif self._peek().low in ("proc", "func", "trap"):
                routine = self._routine()
                self._check_new(routine.name, {**module.data, **module.routines})
                module.routines[routine.name] = routine
            else:
                self._fail("a declaration or a routine")
        self._word("endmodule")
        if self._at != len(self._tokens):
            self._fail("the end")
        return module

    # -- tokens

    def _peek(self, ahead: int = 0) -> Token:
        if self._at + ahead >= len(self._tokens):
            raise RapidError("the module ends too early")
        return self._tokens[self._at + ahead]

    def _next(self) -> Token:
        token = self._peek()
        self._at += 1
        return token

    def _is(self, *words: str) -> bool:
        return self._peek().low in words and self._peek().kind != "string"

    def _word(self, word: str) -> Token:
        if not self._is(word):
            self._fail(word)
        return self._next()

    def _name(self) -> str:
        token = self._next()
        if token.kind != "name" or token.low in RESERVED:
            raise RapidError(f"line {token.line}: {token.text!r} is no name that can be given")
        return token.low

    def _fail(self, expected: str) -> None:
        token = self._peek()
        raise RapidError(f"line {token.line}: {token.text!r} where {expected} was expected")

    def _check_new(self, name: str, known: Mapping[str, object]) -> None:
        if name in known:
            raise RapidError(f"line {self._peek().line}: {name} is declared twice")

    # -- declarations and routines

    def _declaration(self) -> tuple[str, str, str, list[Token]]:
        is_of_task = self._is("task")
        if is_of_task:
            self._word("task")
        kind, type_, name = self._next().low, self._name(), self._name()
        if is_of_task and kind != "pers":
            raise RapidError(f"{name}: TASK stands before PERS alone")
        start = self._at
        while not self._is(";"):
            self._next()
        value = self._tokens[start : self._at]
        self._word(";")
        if kind == "const" and not any(token.text == ":=" for token in value):
            raise RapidError(f"{name}: a constant without a value")
        return kind, name, type_, value

    def _routine(self) -> Routine:
        kind = self._next().low
        if kind == "func":
            self._name()
        routine = Routine(kind, self._name())
        if kind != "trap":
            self._word("(")
            while not self._is(")"):
                self._name()
                routine.parameters.append(self._name())
                if not self._is(")"):
                    self._word(",")
            self._word(")")
        while self._is("var", "const"):
            _, name, _, _ = self._declaration()
            self._check_new(name, dict.fromkeys((*routine.local, *routine.parameters)))
            routine.local.add(name)
        end = f"end{kind}"
        self._statements(routine, end, "error", "undo")
        for part in ("error", "undo"):
            if self._is(part):
                self._next()
                self._statements(routine, end, "undo")
        self._word(end)
        return routine

    # -- statements

    def _statements(self, routine: Routine, *ends: str) -> None:
        while not self._is(*ends):
            self._statement(routine)

    def _statement(self, routine: Routine) -> None:
        token = self._peek()
        match token.low:
            case "if":
                self._if(routine)
            case "for":
                self._for(routine)
            case "while":
                self._next()
                self._expression(routine, "do")
                self._word("do")
                self._statements(routine, "endwhile")
                self._word("endwhile")
            case "test":
                self._test(routine)
            case "return":
                self._next()
                if not self._is(";"):
                    if routine.kind != "func":
                        self._fail("; since only a function returns a value")
                    self._expression(routine, ";")
                self._word(";")
            case "raise" | "retry" | "trynext":
                self._next()
                self._word(";")
            case _:
                self._call_or_assignment(routine)

    def _if(self, routine: Routine) -> None:
        self._next()
        start = self._at
        self._condition(routine)
        if not self._is("then"):
            if start == self._at:
                self._fail("a condition")
            self._statement(routine)  # the compact form: one statement, no ENDIF
            return
        self._word("then")
        self._statements(routine, "elseif", "else", "endif")
        while self._is("elseif"):
            self._next()
            self._condition(routine)
            self._word("then")
            self._statements(routine, "elseif", "else", "endif")
        if self._is("else"):
            self._next()
            self._statements(routine, "endif")
        self._word("endif")

    def _condition(self, routine: Routine) -> None:
        """An expression that ends where the next word cannot continue it."""
        was_operand, depth, begin = False, 0, self._at
        while True:
            token = self._peek()
            is_value = token.kind in ("string", "number", "name")
            is_operand = is_value and token.low not in OPERATORS
            if depth == 0 and (self._is("then") or (was_operand and is_operand)):
                break
            depth += (token.text in "([{") - (token.text in ")]}")
            was_operand = is_operand or token.text in (")", "]", "}")
            if token.text == ".":
                was_operand = False
            self._next()
        self._use(routine, self._tokens[begin : self._at])

    def _for(self, routine: Routine) -> None:
        self._next()
        name = self._name()
        if name in routine.local:
            self._fail("a new name for the loop")
        routine.local.add(name)  # its scope is the loop; a clash would have been seen
        self._word("from")
        self._expression(routine, "to")
        self._word("to")
        self._expression(routine, "do", "step")
        if self._is("step"):
            self._next()
            self._expression(routine, "do")
        self._word("do")
        self._statements(routine, "endfor")
        self._word("endfor")
        routine.local.discard(name)
        routine.uses = [(one, line) for one, line in routine.uses if one != name]

    def _test(self, routine: Routine) -> None:
        self._next()
        begin = self._at
        while not self._is("case", "default"):
            self._next()
        self._use(routine, self._tokens[begin : self._at])
        while self._is("case"):
            self._next()
            self._expression(routine, ":")
            self._word(":")
            self._statements(routine, "case", "default", "endtest")
        if self._is("default"):
            self._next()
            self._word(":")
            self._statements(routine, "endtest")
        self._word("endtest")

    def _call_or_assignment(self, routine: Routine) -> None:
        first = self._peek()
        name = self._name()
        begin = self._at
        while not self._is(";"):
            if self._peek().low in RESERVED - {
                "and",
                "or",
                "not",
                "mod",
                "div",
                "xor",
                "true",
                "false",
            }:
                self._fail("; at the end of a statement")
            self._next()
        inside = self._tokens[begin : self._at]
        self._word(";")
        if any(token.line != first.line for token in inside):
            raise RapidError(
                f"line {first.line}: a statement stays on its line; is there a ; missing"
            )
        depth, commas, target = 0, 0, True
        is_assignment = False
        for k, token in enumerate(inside):
            depth += (token.text in "([{") - (token.text in ")]}")
            commas += token.text == "," and depth == 0
            if depth == 0 and token.text == ":=" and target:
                is_assignment = True
            is_component = token.kind == "name" and k > 0 and inside[k - 1].text == "."
            if depth == 0 and token.text not in ("}", ".", ":=") and not is_component:
                target = False  # more than a name with an index or a component
        if depth:
            raise RapidError(f"line {first.line}: brackets are not closed")
        self._use(routine, inside)
        if is_assignment:
            routine.uses.append((name, first.line))
        else:
            routine.calls.append((name, commas + bool(inside), first.line))

    def _expression(self, routine: Routine, *ends: str) -> None:
        begin = self._at
        while not self._is(*ends):
            if self._is(";"):
                self._fail(" or ".join(ends))
            self._next()
        if begin == self._at:
            self._fail("an expression")
        self._use(routine, self._tokens[begin : self._at])

    def _use(self, routine: Routine, tokens: list[Token]) -> None:
        for k, token in enumerate(tokens):
            if token.kind != "name" or token.low in RESERVED:
                continue
            before = tokens[k - 1].text if k else ""
            after = tokens[k + 1].text if k + 1 < len(tokens) else ""
            if before in (".", "\\"):
                continue  # a component of a record, or the name of an optional argument
            if after == "(":
                routine.functions.append((token.low, token.line))
            else:
                routine.uses.append((token.low, token.line))


def read(text: str) -> Module:
    """One module; everything in lower case, as RAPID does not tell them apart."""
    return Reader(text).module()


def strings_of(value: list[Token]) -> list[str]:
    return [content_of(token) for token in value if token.kind == "string"]


def unknown_names(
    modules: list[Module], instructions: set[str], functions: set[str], data: set[str]
) -> Iterator[str]:
    """Names that one task uses and nobody declares; every routine that is called has its body."""
    known_data = data | {name for module in modules for name in module.data}
    routines = {name: one for module in modules for name, one in module.routines.items()}
    for module in modules:
        for routine in module.routines.values():
            scope = known_data | routine.local | set(routine.parameters)
            for name, line in routine.uses:
                if name not in scope:
                    yield f"{module.name} line {line}: {name} is not declared"
            for name, count, line in routine.calls:
                one = routines.get(name)
                if one is None and name not in instructions:
                    yield f"{module.name} line {line}: there is no procedure {name}"
                elif one is not None and (one.kind != "proc" or len(one.parameters) != count):
                    yield f"{module.name} line {line}: {name} is not called so"
            for name, line in routine.functions:
                one = routines.get(name)
                if (one is None and name not in functions) or (
                    one is not None and one.kind != "func"
                ):
                    yield f"{module.name} line {line}: there is no function {name}"
