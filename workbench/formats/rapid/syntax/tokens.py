"""Text of RAPID to words, numbers, strings and signs.

Source: ABB, "Technical reference manual: RAPID kernel" (3HAC050946), "Lexical elements".
"""

import re
from collections.abc import Iterator
from typing import Any

from workbench.formats.rapid.problems import Problem

LONGEST_STRING = 80
"""Characters."""

LONGEST_NAME = 32

RESERVED = frozenset(
    """
    alias and backward case connect const default div do else elseif endfor endfunc endif endmodule
    endproc endrecord endtest endtrap endwhile error exit false for from func goto if inout local
    mod module not or pers proc raise record retry return step task test then to trap true trynext
    undo var while with xor
    """.split()  # noqa: SIM905
)

PLACEHOLDERS = "SMT|EXP|VAR|ID|DDN|RDN|PAR|ALT|ARG|EIT|CSE|TDN|DIM|BDD|TRP"
"""What a FlexPendant writes where a person has still to write something."""

HEAD = re.compile(r"%%%[^%]*%%%")
"""Version and language before the modules of a file."""

TOKEN = re.compile(
    rf"""\s*(?:
    (?P<NAME>[^\W\d_]\w*)
    |(?P<NUMBER>0[xX][0-9A-Fa-f]+|0[bB][01]+|0[oO][0-7]+|(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)
    |(?P<STRING>"(?:[^"]|"")*"(?!"))
    |(?P<COMMENT>!.*)
    |(?P<PLACE><(?:{PLACEHOLDERS})>)
    |(?P<SIGN>:=|<>|<=|>=|[-+*/=<>(){{}}\[\],;:.%\\?|])
    |(?P<OTHER>\S)
    )""",
    re.VERBOSE,
)


class Token(str):
    """A word of a module and where it stands; `type` is NAME, NUMBER, STRING, PLACE or END.

    Reserved words and signs are their own type, in small letters.
    """

    __slots__ = ("column", "line", "type")

    type: str
    line: int
    column: int


class SyntaxTree:
    """A part of a module: what it is, what it consists of, and where it begins."""

    __slots__ = ("children", "column", "data", "line")

    def __init__(self, data: str, children: list[Any], line: int, column: int) -> None:
        self.data, self.children, self.line, self.column = data, children, line, column

    def walk(self) -> Iterator["SyntaxTree"]:
        """This and all that is in it."""
        waiting: list[SyntaxTree] = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting.extend(child for child in node.children if type(child) is SyntaxTree)


def tokens_of(text: str, name: str, problems: list[Problem]) -> list[Token]:
    """The words of a module, in order; the last one is END.

    Args:
        text: of the file.
        name: of the file, for `problems`.
        problems: gets what is not RAPID.
    """
    text = HEAD.sub(lambda found: "\n" * found[0].count("\n"), text)
    found: list[Token] = []
    number = 0
    for number, line in enumerate(text.split("\n"), start=1):
        for match in TOKEN.finditer(line):
            kind = match.lastgroup
            if kind == "COMMENT" or kind is None:
                continue
            token = Token(match[kind])
            token.line, token.column = number, match.start(kind) + 1
            token.type = kind
            if kind == "SIGN":
                token.type = token
            elif kind == "NAME":
                low = token.lower()
                if low in RESERVED:
                    token.type = low
            elif kind == "OTHER":
                rest = line[token.column - 1 :][:20]
                problems.append(Problem(name, number, token.column, _no_rapid(rest)))
                if token != '"':
                    continue
                token.type = "STRING"
                found.append(token)
                break
            if len(token) > LONGEST_NAME and (what := _too_long(token)):
                problems.append(Problem(name, number, token.column, what))
            found.append(token)
    end = Token("")
    end.type, end.line, end.column = "END", number, 1
    found.append(end)
    return found


def _no_rapid(rest: str) -> str:
    if rest.startswith('"'):
        return "a string has no end in its line"
    return f"{rest!r} is no RAPID"


def _too_long(token: Token) -> str:
    if token.type == "NAME":
        return f"the name {token} has more than {LONGEST_NAME} characters"
    if token.type == "STRING" and len(content_of(token)) > LONGEST_STRING:
        return f"a string of {len(content_of(token))} characters; {LONGEST_STRING} fit"
    return ""


def content_of(token: str) -> str:
    r"""A string as it is in memory: `""` is one quote, `\\` one backslash, `\0A` one character."""
    inner = token[1:-1].replace('""', '"')
    return re.sub(
        r"\\(\\|[0-9A-Fa-f]{2})",
        lambda found: "\\" if found[1] == "\\" else chr(int(found[1], 16)),
        inner,
    )
