r"""Text of a RAPID module to a syntax tree.

Syntax after ABB, "Technical reference manual: RAPID kernel" (3HAC050946), with two differences.
The manual's own table of priorities asks for the first: NOT binds as weakly as OR and XOR, so that
`NOT a AND b` is `NOT (a AND b)`.  The second is that a sign may stand before each factor.  Letters
may be large or small everywhere but in strings.

Reading goes on behind a mistake, at the next statement: each is found in one reading.
"""

from workbench.formats.rapid.problems import BadModule, Problem
from workbench.formats.rapid.syntax.clauses import Statement
from workbench.formats.rapid.syntax.reading import MOST_LEVELS, TOO_DEEP, NoRapid
from workbench.formats.rapid.syntax.tokens import SyntaxTree, Token, tokens_of

STORAGES = ("var", "pers", "const")
DECLARES = frozenset({*STORAGES, "local", "task", "record", "alias", "proc", "func", "trap"})
ENDS = {"proc": "endproc", "func": "endfunc", "trap": "endtrap"}


def parse(text: str, name: str) -> SyntaxTree:
    """The syntax tree of the only module in a text; `name` stands in the messages.

    Raises:
        BadModule: it is no RAPID; the problems name line and column.
    """
    modules, problems = parse_all(text, name)
    if problems:
        raise BadModule(problems)
    return modules[0]


def parse_all(text: str, name: str) -> tuple[list[SyntaxTree], list[Problem]]:
    """All modules of a file, without what is wrong in them, and what that is.

    Files of S4 controllers hold a whole program.

    Raises:
        BadModule: there is no module, or the text ends in the middle of one.
    """
    problems: list[Problem] = []
    reader = Module(tokens_of(text, name, problems), name, problems)
    modules = reader.modules()
    for module in modules:
        _check_depth(reader, module)
    return modules, sorted(problems)


class Module(Statement):
    """Reads modules, their declarations and routines."""

    def modules(self) -> list[SyntaxTree]:
        """Everything up to the end of the file.

        Raises:
            BadModule: there is no module, or it is cut off.
        """
        found: list[SyntaxTree] = []
        while not self.sees("END"):
            if not self.sees("module"):
                if not found:
                    self.refuse(self.next, "the file does not begin with MODULE")
                self.note(NoRapid(self.next, "only a MODULE can stand behind ENDMODULE"))
                break
            found.append(self._module())
        if not found:
            self.refuse(self.next, "there is no MODULE in the file")
        return found

    def _module(self) -> SyntaxTree:
        begin = self.take()
        if self.next.type not in ("NAME", "PLACE"):
            self.refuse(self.next, f"MODULE has no name before {self.shown}")
        children: list[Token | SyntaxTree] = [self.take()]
        try:
            self._attributes(children)
        except NoRapid as error:
            self.note(error)
        while not self.sees("endmodule"):
            if self.sees("END"):
                self.refuse(
                    self.next, f"the file ends in the middle: MODULE {children[0]} has no ENDMODULE"
                )
            try:
                self._declaration(children)
            except NoRapid as error:
                self.note(error)
                self._depth = 0
                self._ends.clear()
                self.skip_to(DECLARES | {"endmodule"})
        self.take()
        return SyntaxTree("module", children, begin.line, begin.column)

    def _attributes(self, children: list[Token | SyntaxTree]) -> None:
        if self.sees("("):
            self.take()
            children += self.take_list(lambda: self.take_name("an attribute"), ")")

    def _declaration(self, children: list[Token | SyntaxTree]) -> None:
        if self.sees("PLACE"):
            children.append(self.place())
            return
        begin = self.next
        scope = [self.take()] if begin.type in ("local", "task") else []
        what = self.next.type
        if what in STORAGES:
            children.append(self.data(begin, scope))
        elif what == "record":
            children.append(self._record(begin, scope))
        elif what == "alias":
            self.take()
            names = [self.take_name("a type"), self.take_name("a name")]
            self.want(";")
            children.append(SyntaxTree("alias", [*scope, *names], begin.line, begin.column))
        elif what in ENDS:
            children.append(self._routine(begin, scope, what))
        else:
            self.fail("data or a routine")

    def _record(self, begin: Token, scope: list[Token]) -> SyntaxTree:
        self.take()
        children: list[Token | SyntaxTree] = [*scope, self.take_name("a name")]
        while not self.sees("endrecord"):
            at = self.next
            part: list[Token | SyntaxTree] = [
                self.take_name("a type"),
                self.take_name("a component"),
            ]
            self.want(";")
            children.append(SyntaxTree("part", part, at.line, at.column))
        self.take()
        return SyntaxTree("record", children, begin.line, begin.column)

    # -- routines

    def _routine(self, begin: Token, scope: list[Token], what: str) -> SyntaxTree:
        self.take()
        names = [self.take_name("a type")] if what == "func" else []
        names.append(self.take_name("a name"))
        children: list[Token | SyntaxTree] = [*scope, *names]
        try:
            if what != "trap":
                children.append(self._params())
        except NoRapid as error:
            self.note(error)
            children.append(SyntaxTree("params", [], begin.line, begin.column))
        children += [self._locals(), self.block()]
        while self.next.type in ("backward", "error", "undo"):
            children.append(self._handler())
        end = ENDS[what].upper()
        if self.sees("END"):
            self.refuse(
                self.next, f"the file ends in the middle: {what.upper()} {names[-1]} has no {end}"
            )
        if self.sees(ENDS[what]):
            self.take()
        else:
            missing = f"{end} of {names[-1]} (line {begin.line}) is missing before {self.shown}"
            self.note(NoRapid(self.next, missing))
        return SyntaxTree(what, children, begin.line, begin.column)

    def _handler(self) -> SyntaxTree:
        at = self.take()
        numbers: list[SyntaxTree] = []
        if at.type == "error" and self.sees("("):
            self.take()
            numbers = self.take_list(self.expression, ")")
        return SyntaxTree(at.type, [*numbers, self.block()], at.line, at.column)

    def _params(self) -> SyntaxTree:
        at = self.want("(")
        children: list[SyntaxTree] = []
        while not self.sees(")"):
            if self.sees(","):
                self.take()
            elif children and not self.sees("\\"):
                self.fail("',' or ')'")
            children.append(self._optional() if self.sees("\\") else self._param())
        self.take()
        return SyntaxTree("params", list(children), at.line, at.column)

    def _optional(self) -> SyntaxTree:
        at = self.take()
        children = [self._param()]
        while self.sees("|"):
            self.take()
            children.append(self._param())
        return SyntaxTree("optional", list(children), at.line, at.column)

    def _param(self) -> SyntaxTree:
        if self.sees("PLACE"):
            return self.place()
        at = self.next
        mode = [self.take()] if at.type in ("var", "pers", "inout") else []
        names = [self.take_name("a type"), self.take_name("a name")]
        stars = None
        if self.sees("{"):
            self.take()
            stars = SyntaxTree(
                "stars", self.take_list(lambda: self.want("*"), "}"), at.line, at.column
            )
        return SyntaxTree("param", [*mode, *names, stars], at.line, at.column)

    def _locals(self) -> SyntaxTree:
        children: list[SyntaxTree] = []
        at = self.next
        while self.next.type in STORAGES or (self.sees("PLACE") and self.next == "<DDN>"):
            try:
                children.append(self.place() if self.sees("PLACE") else self.data(self.next, []))
            except NoRapid as error:
                self.note(error)
                self.skip_statement()
        return SyntaxTree("locals", list(children), at.line, at.column)

    def data(self, begin: Token, scope: list[Token]) -> SyntaxTree:
        """One declaration of data."""
        storage = self.take()
        type_, name = self.take_name("a type"), self.take_name("a name")
        dims, value = None, None
        if self.sees("{"):
            at = self.take()
            dims = SyntaxTree("dims", self.take_list(self.expression, "}"), at.line, at.column)
        if self.sees(":="):
            self.take()
            value = self.expression()
        self.want(";")
        children = [*scope, storage, type_, name, dims, value]
        return SyntaxTree("data", children, begin.line, begin.column)


def _check_depth(reader: Module, tree: SyntaxTree) -> None:
    """Refuse what would have everybody who walks through the tree run out of stack."""
    level = [tree]
    for _ in range(MOST_LEVELS):
        level = [child for node in level for child in node.children if type(child) is SyntaxTree]
    if level:
        reader.refuse(level[0], TOO_DEEP)
