"""Words one after the other, and expressions made of them."""

from collections.abc import Callable
from typing import Any, NoReturn

from workbench.formats.rapid.problems import UNREADABLE, BadModule, Problem
from workbench.formats.rapid.syntax.tokens import RESERVED, SyntaxTree, Token

MOST_LEVELS = 100
"""Levels of statements and expressions within each other; each term of a sum is one more."""

TOO_DEEP = "is nested too deeply"

RELATIONS = frozenset({"=", "<>", "<", ">", "<=", ">="})
FACTORS = frozenset({"*", "/", "div", "mod"})
SIGNS = frozenset({"+", "-"})


class NoRapid(Exception):
    """A word that cannot stand where it does."""

    def __init__(self, at: Token, what: str) -> None:
        self.at = at
        super().__init__(what)


class TokenReader:
    """The words of a file and how far they are read; what is wrong goes to `problems`."""

    def __init__(self, tokens: list[Token], name: str, problems: list[Problem]) -> None:
        self.tokens, self.name, self.problems = tokens, name, problems
        self._at = self._depth = 0
        self._told = {problem.line for problem in problems}
        self.next = tokens[0]

    def sees(self, type_: str) -> bool:
        """Whether the next word is of that type."""
        return self.next.type == type_

    def take(self) -> Token:
        """The next word; the end of the file stays the next one."""
        taken = self.next
        if taken.type != "END":
            self._at += 1
            self.next = self.tokens[self._at]
        return taken

    def after(self) -> Token:
        """The word after the next one."""
        return self.tokens[min(self._at + 1, len(self.tokens) - 1)]

    def want(self, type_: str) -> Token:
        """Take a word that must come; a semicolon that is missing at the end of a line is noted.

        Raises:
            NoRapid: another one comes.
        """
        if self.next.type == type_:
            return self.take()
        before = self.tokens[self._at - 1]
        if type_ != ";" or before.line == self.next.line or self.sees("END"):
            self.fail(f"'{type_}'")
        self.note(NoRapid(before, f"a ';' is missing behind {str(before)!r}"))
        return before

    def take_name(self, what: str) -> Token:
        """Take a name, or a placeholder for one; a name may be as a placeholder is.

        Raises:
            NoRapid: something else comes.
        """
        if self.next.type not in ("NAME", "PLACE"):
            self.fail(what)
        return self.take()

    @property
    def shown(self) -> str:
        """The next word as a message names it."""
        return "the end of the file" if self.next.type == "END" else repr(str(self.next))

    def fail(self, expected: str = "") -> NoReturn:
        """Say that the next word cannot stand here.

        Raises:
            NoRapid: always.
        """
        hint = ""
        if self.next.type in RESERVED and expected.startswith("a name"):
            hint = f": {self.next.upper()} is a word of the language"
        hint_words = f"; expected was {expected}" if expected and not hint else ""
        raise NoRapid(self.next, f"{self.shown} cannot stand here{hint_words}{hint}")

    def note(self, error: NoRapid) -> None:
        """Keep what is wrong; of one line the first mistake only."""
        at = error.at
        if at.line not in self._told:
            self._told.add(at.line)
            self.problems.append(Problem(self.name, at.line, at.column, str(error)))

    def skip_to(self, types: frozenset[str]) -> None:
        """Leave words out up to one of these types."""
        begin = self._at
        while self.next.type not in types and not self.sees("END"):
            self.take()
        if self._at == begin and not self.sees("endmodule"):
            self.take()

    def take_list(self, read: Callable[[], Any], end: str) -> list[Any]:
        """What is between commas, up to a sign."""
        found = [read()]
        while self.sees(","):
            self.take()
            found.append(read())
        self.want(end)
        return found

    def deeper(self, at: Token) -> None:
        """One level more.

        Raises:
            BadModule: there are too many.
        """
        self._depth += 1
        if self._depth > MOST_LEVELS:
            self.refuse(at, TOO_DEEP)

    def refuse(self, at: Token | SyntaxTree, what: str) -> NoReturn:
        """Give the whole file up.

        Raises:
            BadModule: always.
        """
        raise BadModule([Problem(self.name, at.line, at.column, what, UNREADABLE)])

    def place(self) -> SyntaxTree:
        """A placeholder."""
        at = self.take()
        return SyntaxTree("place", [at], at.line, at.column)


class Expression(TokenReader):
    """Reads expressions."""

    def expression(self) -> SyntaxTree:
        """An expression, its weakest signs first."""
        self.deeper(self.next)
        try:
            left = self._logical()
            while self.next.type in ("or", "xor"):
                left = self._binary(left, self.take(), self._logical())
        finally:
            self._depth -= 1
        return left

    def _binary(self, left: SyntaxTree, sign: Token, right: SyntaxTree) -> SyntaxTree:
        return SyntaxTree("binary", [left, sign, right], left.line, left.column)

    def _logical(self) -> SyntaxTree:
        if self.sees("not"):
            at = self.take()
            self.deeper(at)
            inner = self._logical()
            self._depth -= 1
            return SyntaxTree("not_", [inner], at.line, at.column)
        left = self._relation()
        while self.sees("and"):
            sign = self.take()
            if self.sees("not"):
                return SyntaxTree("binary", [left, sign, self._logical()], left.line, left.column)
            left = self._binary(left, sign, self._relation())
        return left

    def _relation(self) -> SyntaxTree:
        left = self._sum()
        if self.next.type in RELATIONS:
            return self._binary(left, self.take(), self._sum())
        return left

    def _sum(self) -> SyntaxTree:
        if self.next.type in SIGNS:
            at = self.take()
            left = SyntaxTree("sign", [at, self._product()], at.line, at.column)
        else:
            left = self._product()
        while self.next.type in SIGNS:
            left = self._binary(left, self.take(), self._product())
        return left

    def _product(self) -> SyntaxTree:
        left = self._factor()
        while self.next.type in FACTORS:
            left = self._binary(left, self.take(), self._factor())
        return left

    def _factor(self) -> SyntaxTree:
        at = self.next
        kind = at.type
        if kind == "NUMBER":
            return SyntaxTree("number", [self.take()], at.line, at.column)
        if kind == "NAME":
            if self.after().type == "(":
                return self._function()
            return self.variable()
        if kind == "[":
            self.take()
            return SyntaxTree("aggregate", self.take_list(self.expression, "]"), at.line, at.column)
        if kind == "STRING":
            return SyntaxTree("string", [self.take()], at.line, at.column)
        if kind in ("true", "false"):
            return SyntaxTree("bool", [self.take()], at.line, at.column)
        if kind == "(":
            self.take()
            inner = self.expression()
            self.want(")")
            return inner
        if kind in SIGNS:
            return SyntaxTree("sign", [self.take(), self._factor()], at.line, at.column)
        if kind == "PLACE":
            return self.place()
        self.fail("an expression" if kind in RESERVED else "")

    def _function(self) -> SyntaxTree:
        name = self.take()
        self.take()
        args = None if self.sees(")") else self.arguments(")")
        self.want(")")
        return SyntaxTree("function", [name, args], name.line, name.column)

    def variable(self) -> SyntaxTree:
        """Data, an element, a component."""
        name = self.take()
        children: list[Any] = [name, self._index()]
        while self.sees("."):
            self.take()
            at = self.take_name("a component")
            children.append(SyntaxTree("component", [at, self._index()], at.line, at.column))
        return SyntaxTree("var", children, name.line, name.column)

    def _index(self) -> SyntaxTree | None:
        if not self.sees("{"):
            return None
        at = self.take()
        return SyntaxTree("index", self.take_list(self.expression, "}"), at.line, at.column)

    def arguments(self, end: str) -> SyntaxTree:
        """Arguments up to a sign, which stays."""
        at, children = self.next, list[SyntaxTree]()
        while not self.sees(end):
            if children:
                if self.sees(","):
                    self.take()
                elif self.sees("\\"):
                    pass
                elif end == ";" and self.next.line > self.tokens[self._at - 1].line:
                    break
                else:
                    self.fail(f"',' or '{end}'")
            children.append(self._argument())
        return SyntaxTree("args", list(children), at.line, at.column)

    def _argument(self) -> SyntaxTree:
        at = self.next
        if self.sees("NAME") and self.after().type == ":=":
            name = self.take()
            self.take()
            return SyntaxTree("by_name", [name, self.expression()], at.line, at.column)
        if not self.sees("\\"):
            return self.expression()
        self.take()
        name = self.take_name("the name of an argument")
        if self.sees("?"):
            self.take()
            return SyntaxTree(
                "passed_on", [name, self.take_name("an argument")], at.line, at.column
            )
        if self.sees(":="):
            self.take()
            return SyntaxTree("named", [name, self.expression()], at.line, at.column)
        return SyntaxTree("named", [name], at.line, at.column)
