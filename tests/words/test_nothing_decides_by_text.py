"""Sources are read: no code compares, searches, cuts or rewrites a text that is for people."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

import workbench

PACKAGE = Path(workbench.__file__).parent

FOLDERS = "app cli gui model perception planning plugins proof studies web".split()  # noqa: SIM905
"""All but readers and writers of files, and protocols: what these get is no text of ours."""

FOR_PEOPLE = """
    message messages note notes problem problems reason row_ends said says stale verdict why words
    """.split()  # noqa: SIM905
"""What values and variables are called that hold a message or its text."""

CUTS = """
    startswith endswith removeprefix removesuffix partition rpartition split replace find
    """.split()  # noqa: SIM905
SEARCHES = "match search fullmatch sub split findall finditer".split()  # noqa: SIM905

OTHERS = {
    "app/provenance/components.py": {"_licence_of"},
    "studies/case_searches.py": {"held_cases"},
    "studies/load/raw_browser.py": {"_learn"},
    "web/page/pages.py": {"_translate"},
}
"""What looks like it: classifiers of packages, names of files, tags of HTML."""


def decisions(tree: ast.AST) -> Iterator[ast.AST]:
    """Where something is decided by a text for people."""
    for node in ast.walk(tree):
        match node:
            case ast.Compare(left=ast.Constant(value=str()), ops=[ast.In() | ast.NotIn()]):
                if _is_for_people(node.comparators[0]):
                    yield node
            case ast.Compare(
                left=left, ops=[ast.Eq() | ast.NotEq()], comparators=[ast.Constant(value=str(text))]
            ) if " " in text and _is_for_people(left):
                yield node
            case ast.Compare(left=left, ops=[ast.Eq() | ast.NotEq()], comparators=[right]):
                if _is_for_people(left) and _is_for_people(right):
                    yield node
            case ast.Call(func=ast.Attribute(value=owner, attr=attr), args=given):
                cuts = attr in CUTS and (_is_for_people(owner) or _is_english(given))
                if cuts or (attr in SEARCHES and any(map(_is_for_people, given))):
                    yield node
            case _:
                pass


def _is_for_people(node: ast.AST) -> bool:
    match node:
        case ast.Name(id=name) | ast.Attribute(attr=name):
            return name in FOR_PEOPLE
        case ast.Call(func=ast.Name(id="str"), args=[inner]):
            return _is_for_people(inner)
        case _:
            return False


def _is_english(arguments: list[ast.expr]) -> bool:
    """Whether a method is given a piece of a sentence."""
    match arguments:
        case [ast.Constant(value=str(text)), *_]:
            return " " in text.strip() or (text.strip().isalpha() and text != text.strip())
        case _:
            return False


def found_in(source: str) -> set[str]:
    """The functions of a file that decide by a text, `module` for what stands outside of any."""
    tree = ast.parse(source)
    inner = {
        id(node): function.name
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef)
        for node in ast.walk(function)
    }
    return {inner.get(id(node), "module") for node in decisions(tree)}


def test_no_code_decides_by_a_text_that_is_for_people():
    found: dict[str, set[str]] = {}
    for folder in FOLDERS:
        for path in sorted((PACKAGE / folder).rglob("*.py")):
            functions = found_in(path.read_text(encoding="utf-8"))
            if functions:
                found[path.relative_to(PACKAGE).as_posix()] = functions
    assert found == OTHERS


@pytest.mark.parametrize(
    "code",
    [
        'if "may meet" in plan.note: pass',
        'state.message.startswith("no plan")',
        'str(verdict).removeprefix("in ")',
        "re.sub(r'part-', by_number, words)",
        'at_least(bound).removeprefix("at least ")',
        'if result.message == "no plan": pass',
    ],
)
def test_each_way_of_deciding_is_found(code):
    assert found_in(f"def decided():\n    {code}\n") == {"decided"}


@pytest.mark.parametrize(
    "code",
    ["if plan.note: pass", "if note.text is PlanNote.GOES_UNSEEN: pass", 'path.endswith(".json")'],
)
def test_values_and_names_of_files_are_no_texts(code):
    assert found_in(f"def decided():\n    {code}\n") == set()
