"""Sources are read: a text of the page with a value in it has an id, and is no literal."""

import ast
import re
from collections.abc import Iterator

import pytest

from workbench.words import extract
from workbench.words.markup import TAG, texts_of

VALUE = extract.VALUE

WORDS = re.compile(r"[A-Za-z]{2,} +[a-z]{2,}|[a-z]{3,} *\{\}|\{\} *[a-z]{3,}")
"""Two words in a row, or one beside a value."""

NOT_ENGLISH = re.compile(r"[{}\w.:-]*\.(json|zip)|[\w-]+:[^ ]*|\.wb-.*|[a-z]+\{\}|\{\}[a-z]+")
"""Names of files and attributes, styles."""


UNITS = re.compile(r"\b(deg|mm|min)\b")

NAMES = {"from {}", "pose {}", "region {}", "{} place {}", "{} part-place {}"}
"""What things without a name of their own are called, also on record; numbers as typed."""


def texts_with_values(tree: ast.Module) -> Iterator[str]:
    """Texts for people that are put together with values, `{}` for each."""
    found = [text for text, _ in extract._literals(tree) if VALUE in text]
    for node in ast.walk(tree):
        match node:
            case ast.BinOp(ast.Constant(str(text)), ast.Mod()):
                found.append(re.sub(r"%[sdrgf.0-9]+", VALUE, text))
            case ast.BinOp(ast.Constant(str(text)), ast.Add(), right) if not _is_text(right):
                found.append(text + VALUE)
            case ast.BinOp(left, ast.Add(), ast.Constant(str(text))) if not _is_text(left):
                found.append(VALUE + text)
            case ast.Call(ast.Attribute(ast.Constant(str(text)), "format")):
                found.append(re.sub(r"\{[^{}]*\}", VALUE, text))
            case _:
                pass
    for text in found:
        for piece in texts_of(text) if TAG.search(text) else (text,):
            said = " ".join(piece.split())
            if said in NAMES or NOT_ENGLISH.fullmatch(said):
                continue
            if VALUE in said and WORDS.search(UNITS.sub("", said)):
                yield said


def _is_text(node: ast.expr) -> bool:
    return isinstance(node, ast.JoinedStr | ast.Constant)


def test_every_text_of_the_page_with_a_value_has_an_id():
    found: dict[str, list[str]] = {}
    for folder in extract.PAGE_FOLDERS:
        for path in sorted((extract.PACKAGE / folder).rglob("*.py")):
            where = path.relative_to(extract.PACKAGE).as_posix()
            if where in extract.UNSEEN or where.startswith(extract.WITH_IDS):
                continue
            if texts := list(texts_with_values(ast.parse(path.read_text(encoding="utf-8")))):
                found[where] = texts
    assert found == {}


@pytest.mark.parametrize(
    "code",
    [
        'f"{count} parts found"',
        'f"{count} parts"',
        'f"<b>{name} is gone</b>"',
        '"{} parts found".format(count)',
        '"%d parts found" % count',
        '"parts found: " + str(count)',
        'str(count) + " parts found"',
    ],
)
def test_each_way_of_putting_a_value_in_is_found(code):
    assert list(texts_with_values(ast.parse(f"shown = {code}")))


@pytest.mark.parametrize(
    "code", ['f"{count} mm"', 'f"certificate-{digest}.json"', 'f"<td>{name}</td>"', '"parts found"']
)
def test_units_names_and_whole_texts_are_none(code):
    assert not list(texts_with_values(ast.parse(f"shown = {code}")))
