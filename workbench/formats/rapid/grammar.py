r"""Text of a RAPID module to a syntax tree.

Syntax after ABB, "Technical reference manual: RAPID kernel" (3HAC050946), with one difference that
the manual's own table of priorities asks for: NOT binds as weakly as OR and XOR, so that
`NOT a AND b` is `NOT (a AND b)`.  Letters may be large or small everywhere but in strings.
"""

import re
from functools import cache

from lark import Lark, Token, Tree
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from workbench.formats.rapid.problems import BadModule, Problem

LONGEST_STRING = 80
"""Characters."""

LONGEST_NAME = 32

DEEPEST = 100
"""Levels of statements and expressions within each other; each term of a sum is one more."""

RESERVED = frozenset(
    """
    alias and backward case connect const default div do else elseif endfor endfunc endif endmodule
    endproc endrecord endtest endtrap endwhile error exit false for from func goto if inout local
    mod module not or pers proc raise record retry return step task test then to trap true trynext
    undo var while with xor
    """.split()  # noqa: SIM905
)

KEPT = frozenset(
    "local task const var pers inout true false or xor and div mod not func".split()  # noqa: SIM905
)
"""Words that stay in the tree, as they say more than where something begins or ends."""

GRAMMAR = r"""
module: MODULE NAME ["(" NAME ("," NAME)* ")"] (data | record | alias | routine)* ENDMODULE
data: [LOCAL | TASK] (CONST | VAR | PERS) NAME NAME [dims] [":=" expr] ";"
dims: "{" expr ("," expr)* "}"
record: [LOCAL] RECORD NAME part+ ENDRECORD
part: NAME NAME ";"
alias: [LOCAL] ALIAS NAME NAME ";"
routine: [LOCAL] PROC NAME params locals block [backward] [error] [undo] ENDPROC -> proc
       | [LOCAL] FUNC NAME NAME params locals block [error] [undo] ENDFUNC -> func
       | [LOCAL] TRAP NAME locals block [error] [undo] ENDTRAP -> trap
params: "(" [group (("," group) | optional)*] ")"
?group: param | optional
optional: "\\" param ("|" param)*
param: [VAR | PERS | INOUT] NAME NAME [stars]
stars: "{" STAR ("," STAR)* "}"
locals: data*
backward: BACKWARD block
error: ERROR ["(" expr ("," expr)* ")"] block
undo: UNDO block
block: _statement*
_statement: simple | if_ | while_ | for_ | test
?simple: assign | call | late | if_compact | return_ | raise_ | retry | trynext | exit | goto
       | label | connect
assign: var ":=" expr ";"
call: NAME [args] ";"
late: "%" expr "%" [args] ";"
if_compact: IF expr simple
if_: IF expr THEN block (ELSEIF expr THEN block)* [ELSE block] ENDIF
while_: WHILE expr DO block ENDWHILE
for_: FOR NAME FROM expr TO expr [STEP expr] DO block ENDFOR
test: TEST expr case* [DEFAULT ":" block] ENDTEST
case: CASE expr ("," expr)* ":" block
return_: RETURN [expr] ";"
raise_: RAISE [expr] ";"
retry: RETRY ";"
trynext: TRYNEXT ";"
exit: EXIT ";"
goto: GOTO NAME ";"
label: NAME ":"
connect: CONNECT var WITH NAME ";"
args: (expr | named) (("," (expr | named)) | named)*
named: "\\" NAME [":=" expr]
     | "\\" NAME "?" NAME -> passed_on
?expr: lterm
     | expr (OR | XOR) lterm -> binary
?lterm: NOT lterm -> not_
      | aterm
      | aterm AND NOT lterm -> and_not
?aterm: relation
      | aterm AND relation -> binary
?relation: sum
         | sum RELATION sum -> binary
?sum: product
    | SIGN product -> sign
    | sum SIGN product -> binary
?product: primary
        | product (STAR | SLASH | DIV | MOD) primary -> binary
?primary: NUMBER -> number
        | STRING -> string
        | (TRUE | FALSE) -> bool
        | var
        | NAME "(" [args] ")" -> function
        | "(" expr ")"
        | "[" expr ("," expr)* "]" -> aggregate
var: NAME [index] component*
component: "." NAME [index]
index: "{" expr ("," expr)* "}"

NAME: /[A-Za-z][A-Za-z0-9_]*/
NUMBER: /0[xX][0-9A-Fa-f]+|0[bB][01]+|\d+(\.\d*)?([eE][+-]?\d+)?|\.\d+([eE][+-]?\d+)?/
STRING: /"([^"\n]|"")*"/
RELATION: /<>|<=|>=|<|>|=/
SIGN: /[+-]/
STAR: "*"
SLASH: "/"
COMMENT: /![^\n]*/
HEAD: /%%%[^%]*%%%/
%ignore COMMENT
%ignore HEAD
%ignore /[ \t\r\n\f]+/
%declare"""

MEANINGS = {
    "$END": "the end of the file", "NAME": "a name", "SEMICOLON": "';'", "COLONEQUAL": "':='",
}  # fmt: skip


def _type_of(word: str) -> str:
    return word.upper() if word.lower() in KEPT else f"_{word.upper()}"


def _reserved(token: Token) -> Token:
    if token.lower() in RESERVED:
        token.type = _type_of(token)
    return token


@cache
def _parser() -> Lark:
    words = "|".join(sorted(word.upper() for word in RESERVED))
    grammar = re.sub(rf"\b({words})\b", lambda found: _type_of(found[0]), GRAMMAR)
    return Lark(
        f"{grammar} {' '.join(sorted(map(_type_of, RESERVED)))}",
        start="module",
        parser="lalr",
        lexer="basic",
        lexer_callbacks={"NAME": _reserved},
        propagate_positions=True,
        maybe_placeholders=True,
    )


def parse(text: str, name: str) -> Tree[Token]:
    """The syntax tree of a module; `name` stands in the messages.

    Raises:
        BadModule: it is no RAPID; the problem names line and column.
    """
    try:
        tree = _parser().parse(text)
    except UnexpectedInput as error:
        raise BadModule([_problem(error, text, name)]) from None
    problems = list(_too_deep(tree, name)) or list(_lengths(tree, name))
    if problems:
        raise BadModule(problems)
    return tree


def _problem(error: UnexpectedInput, text: str, name: str) -> Problem:
    line, column = max(error.line, 1), max(error.column, 1)
    if isinstance(error, UnexpectedCharacters):
        rest = text.splitlines()[line - 1][column - 1 :][:20]
        return Problem(name, line, column, f"{rest!r} is no RAPID")
    found, expected = "the end of the file", ""
    if isinstance(error, UnexpectedToken):
        if error.token.type == "$END":
            line = text.count("\n") + 1
            column = 1
        else:
            found = repr(str(error.token))
        wanted = sorted(
            MEANINGS.get(word, word.strip("_")) for word in error.accepts or error.expected
        )
        if len(wanted) <= 4:
            expected = f"; expected was {' or '.join(wanted)}"
    return Problem(name, line, column, f"{found} cannot stand here{expected}")


def content_of(token: str) -> str:
    r"""A string as it is in memory: `""` is one quote, `\\` one backslash, `\0A` one character."""
    inner = token[1:-1].replace('""', '"')
    return re.sub(
        r"\\(\\|[0-9A-Fa-f]{2})",
        lambda found: "\\" if found[1] == "\\" else chr(int(found[1], 16)),
        inner,
    )


def _too_deep(tree: Tree[Token], name: str):
    """What would have everybody who walks through the tree run out of stack."""
    level = [tree]
    for _ in range(DEEPEST):
        level = [one for node in level for one in node.children if isinstance(one, Tree)]
    if level:
        at = level[0].meta
        yield Problem(
            name, getattr(at, "line", 1), getattr(at, "column", 1), "is nested too deeply"
        )


def _lengths(tree: Tree[Token], name: str):
    for token in tree.scan_values(lambda value: isinstance(value, Token)):
        line, column = token.line or 1, token.column or 1
        if token.type == "STRING" and len(content_of(token)) > LONGEST_STRING:
            what = f"a string of {len(content_of(token))} characters; {LONGEST_STRING} fit"
            yield Problem(name, line, column, what)
        if token.type == "NAME" and len(token) > LONGEST_NAME:
            yield Problem(name, line, column, f"the name {token} has more than {LONGEST_NAME}")
