"""Statements read from words."""

from collections.abc import Callable
from typing import Any

from workbench.formats.rapid.problems import Problem
from workbench.formats.rapid.syntax.reading import Expression, NoRapid
from workbench.formats.rapid.syntax.tokens import SyntaxTree, Token

HARD_ENDS = frozenset(
    """
    END endproc endfunc endtrap endmodule proc func trap local task record alias
    """.split()  # noqa: SIM905
)
"""What ends every block; what only a declaration begins with states that an end is missing."""

SOFT_ENDS = frozenset(
    "endif endfor endwhile endtest else elseif case default error undo backward".split()  # noqa: SIM905
)
"""What ends some blocks, and has nothing to end elsewhere."""

BLOCK_ENDS = HARD_ENDS | SOFT_ENDS
IN_ROUTINE = frozenset({"error", "undo", "backward"})
IN_IF = frozenset({"elseif", "else", "endif"})
IN_TEST = frozenset({"case", "default", "endtest"})
BEGINS = BLOCK_ENDS | {"if", "for", "while", "test", "return", "goto", "raise", "exit", "connect"}
PLAIN = {"retry": "retry", "trynext": "trynext", "exit": "exit"}
WITH_VALUE = {"return": "return_", "raise": "raise_"}


class Statement(Expression):
    """Reads statements."""

    def __init__(self, tokens: list[Token], name: str, problems: list[Problem]) -> None:
        super().__init__(tokens, name, problems)
        self._ends: list[frozenset[str]] = []

    def block(self, ends: frozenset[str] = IN_ROUTINE) -> SyntaxTree:
        """Statements up to one of the words that may end them, without those that are wrong."""
        at, children = self.next, list[SyntaxTree]()
        self.deeper(at)
        self._ends.append(ends)
        while self.next.type not in HARD_ENDS:
            if self.next.type in SOFT_ENDS:
                if any(self.next.type in outer for outer in self._ends):
                    break
                self.note(NoRapid(self.next, f"{self.shown} has nothing to end"))
                self.take()
                continue
            depth, within = self._depth, len(self._ends)
            try:
                children.append(self.statement())
            except NoRapid as error:
                self.note(error)
                self._depth = depth
                del self._ends[within:]
                self.skip_statement()
        self._ends.pop()
        self._depth -= 1
        return SyntaxTree("block", list(children), at.line, at.column)

    def skip_statement(self) -> None:
        """Leave out what is wrong, up to the next statement."""
        begin = self._at
        while not self.sees("END"):
            if self.sees(";"):
                self.take()
                return
            if self.next.type in BEGINS and self._at > begin:
                return
            if self.next.type in BLOCK_ENDS:
                return
            self.take()

    def statement(self) -> SyntaxTree:
        """One statement."""
        at = self.next
        if at.type == "NAME":
            return self._named_statement(at)
        read = READ.get(at.type)
        if read is not None:
            return getattr(self, read)(at)
        if at.type in PLAIN:
            self.take()
            return self._end(PLAIN[at.type], [], at)
        if at.type in WITH_VALUE:
            self.take()
            value = None if self.sees(";") else self.expression()
            return self._end(WITH_VALUE[at.type], [value], at)
        self.fail()

    def _end(self, data: str, children: list[Token | SyntaxTree | None], at: Token) -> SyntaxTree:
        self.want(";")
        return SyntaxTree(data, list(children), at.line, at.column)

    def _named_statement(self, at: Token) -> SyntaxTree:
        after = self.after().type
        if after == ":":
            self.take()
            self.take()
            return SyntaxTree("label", [at], at.line, at.column)
        if after in (":=", "{", "."):
            target = self.variable()
            self.want(":=")
            return self._end("assign", [target, self.expression()], at)
        self.take()
        args = None if self.sees(";") else self.arguments(";")
        return self._end("call", [at, args], at)

    def _place(self, at: Token) -> SyntaxTree:
        node = self.place()
        if self.sees(":="):
            self.take()
            self.expression()
        if self.sees(";"):
            self.take()
        return node

    def _late(self, at: Token) -> SyntaxTree:
        self.take()
        name = self.expression()
        self.want("%")
        args = None if self.sees(";") else self.arguments(";")
        return self._end("late", [name, args], at)

    def _goto(self, at: Token) -> SyntaxTree:
        self.take()
        return self._end("goto", [self.take_name("a label")], at)

    def _connect(self, at: Token) -> SyntaxTree:
        self.take()
        target = self.place() if self.sees("PLACE") else self._interrupt()
        self.want("with")
        return self._end("connect", [target, self.take_name("a trap routine")], at)

    def _interrupt(self) -> SyntaxTree:
        if not self.sees("NAME"):
            self.fail("an intnum")
        return self.variable()

    def _head(self, read: Callable[[], list[SyntaxTree | Token | None]], end: str) -> list[Any]:
        """What stands between the first word of a statement and its THEN or DO.

        A mistake in it does not hide the statements that follow.
        """
        try:
            return read()
        except NoRapid as error:
            line, begin = self.next.line, self._at
            while self.next.line == line and self.next.type not in (end, "END"):
                self.take()
            if not self.sees(end):
                self._at, self.next = begin, self.tokens[begin]
                raise
            self.note(error)
            return [SyntaxTree("mistake", [], error.at.line, error.at.column)] * 4

    def _if(self, at: Token) -> SyntaxTree:
        self.take()
        (condition, *_) = self._head(self._condition, "then")
        if not self.sees("then"):
            self.deeper(at)
            then = self.statement()
            self._depth -= 1
            return SyntaxTree("if_compact", [condition, then], at.line, at.column)
        self.take()
        children: list[SyntaxTree | None] = [condition, self.block(IN_IF)]
        while self.sees("elseif"):
            self.take()
            children.append(self.expression())
            self.want("then")
            children.append(self.block(IN_IF))
        if self.sees("else"):
            self.take()
            children.append(self.block(IN_IF))
        else:
            children.append(None)
        return self._close("if_", list(children), at)

    def _condition(self) -> list[SyntaxTree | Token | None]:
        condition = self.expression()
        if self.next.type != "then" and self.next.type not in STATEMENT_STARTS:
            self.fail("THEN or a statement")
        return [condition]

    def _close(self, data: str, children: list[Token | SyntaxTree | None], at: Token) -> SyntaxTree:
        end = f"end{at.type}"
        if self.next.type != end:
            raise NoRapid(
                self.next, f"{end.upper()} of line {at.line} is missing before {self.shown}"
            )
        self.take()
        return SyntaxTree(data, list(children), at.line, at.column)

    def _while(self, at: Token) -> SyntaxTree:
        self.take()
        (condition, *_) = self._head(lambda: [self.expression()], "do")
        self.want("do")
        return self._close("while_", [condition, self.block(frozenset({"endwhile"}))], at)

    def _for(self, at: Token) -> SyntaxTree:
        self.take()
        name = self.take_name("a name")
        begin, end, step, *_ = self._head(self._bounds, "do")
        self.want("do")
        return self._close("for_", [name, begin, end, step, self.block(frozenset({"endfor"}))], at)

    def _bounds(self) -> list[SyntaxTree | Token | None]:
        self.want("from")
        begin = self.expression()
        self.want("to")
        end, step = self.expression(), None
        if self.sees("step"):
            self.take()
            step = self.expression()
        return [begin, end, step]

    def _test(self, at: Token) -> SyntaxTree:
        self.take()
        children: list[Token | SyntaxTree | None] = [self.expression()]
        while self.sees("case") or self.sees("PLACE"):
            if self.sees("PLACE"):
                self.take()
                continue
            begin = self.take()
            labels = self.take_list(self.expression, ":")
            children.append(
                SyntaxTree("case", [*labels, self.block(IN_TEST)], begin.line, begin.column)
            )
        default = None
        if self.sees("default"):
            self.take()
            self.want(":")
            default = self.block(IN_TEST)
        return self._close("test", [*children, default], at)


STATEMENT_STARTS = frozenset(
    {
        "NAME",
        "%",
        "PLACE",
        "return",
        "raise",
        "goto",
        "connect",
        "if",
        "while",
        "for",
        "test",
        *PLAIN,
    }
)

READ = {
    "if": "_if", "while": "_while", "for": "_for", "test": "_test", "goto": "_goto",
    "connect": "_connect", "%": "_late", "PLACE": "_place",
}  # fmt: skip
"""Which method reads a statement that begins with a word of that type."""
