"""Whoever takes or gives arrays says their shapes and units."""

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "workbench"
ARRAYS = re.compile(r"\b(?:Floats|Ints|Bools|Bytes|Reached|NDArray|ndarray|ArrayLike)\b")

LENGTH = r"(?:\d+|[a-z]{1,2}(?: ?[+-] ?\d)?|[a-z]+s|count|dof|[A-Z]+|\.\.\.)"
SHAPE = re.compile(rf"\((?:{LENGTH},|{LENGTH}(?:, {LENGTH})+)\)")
"""As NumPy prints it, with letters, or words for what is counted: (3,), (n, 3), (rows, columns)."""

UNIT = re.compile(
    r"\[(?:m|mm|rad|deg|s|px|1)\b[^\]]*\]"
    r"|\b[Nn]o unit|(?:'s|own|their) unit\b|\b[Uu]nit (?:vector|normal|direction|quaternion)s?\b"
    r"|\b[Ii]nd(?:ex|ices)\b|\b[Bb]ytes?\b|\b[Tt]rue\b|\b0\.\.(?:1|255)\b"
)
"""In brackets; or words for what has none: an index, a share, a colour, a yes or no."""

Described = tuple[str, str, str]


def with_arrays(path: Path) -> list[Described]:
    """Every public function of a file that takes or gives arrays: name, signature, docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [
        one for one in _in(tree, path.relative_to(PACKAGE).as_posix(), "") if ARRAYS.search(one[1])
    ]


def _in(node: ast.AST, name: str, around: str) -> Iterator[Described]:
    for child in ast.iter_child_nodes(node):
        if not isinstance(child, ast.ClassDef | ast.FunctionDef) or child.name.startswith("_"):
            continue
        says = f"{around}\n{_docstring(child)}"
        here = f"{name}:{child.name}"
        if isinstance(child, ast.ClassDef):
            made = [one for one in child.body if getattr(one, "name", "") == "__init__"]
            yield here, _fields(child), "\n".join([says, *(_docstring(one) for one in made)])
            yield from _in(child, here, says)
        else:
            yield here, _signature(child), says


def _docstring(node: ast.AST) -> str:
    is_one = isinstance(node, ast.ClassDef | ast.FunctionDef)
    return (ast.get_docstring(node) if is_one else "") or ""


def _fields(node: ast.ClassDef) -> str:
    """The types of what a class holds, and what it is made from."""
    types = [
        ast.unparse(one.annotation)
        for one in node.body
        if isinstance(one, ast.AnnAssign) and not ast.unparse(one.target).startswith("_")
    ]
    types += [
        _signature(one)
        for one in node.body
        if isinstance(one, ast.FunctionDef) and one.name == "__init__"
    ]
    return " ".join(types)


def _signature(node: ast.FunctionDef) -> str:
    of = node.args
    types = [one.annotation for one in (*of.posonlyargs, *of.args, *of.kwonlyargs)] + [node.returns]
    return " ".join(ast.unparse(one) for one in types if one is not None)


@pytest.mark.parametrize(
    ("says", "has_shape", "has_unit"),
    [
        ("points (n, 3) [m] in the world", True, True),
        ("`q` (n,) [rad]", True, True),
        ("an image (rows, columns, 3), 0..255", True, True),
        ("a matrix (3, 4), lengths in m", True, False),
        ("the way (as it is, roughly) to go", False, False),
        ("where `x` (m) lies [see there]", False, False),
    ],
)
def test_what_counts_as_a_shape_and_a_unit(says, has_shape, has_unit):
    assert bool(SHAPE.search(says)) is has_shape
    assert bool(UNIT.search(says)) is has_unit


def test_arrays_have_shapes_and_units():
    those = [one for path in sorted(PACKAGE.rglob("*.py")) for one in with_arrays(path)]
    assert len(those) > 250
    missing = [
        f"{name} lacks a {word}"
        for name, _, says in those
        for word, law in (("shape", SHAPE), ("unit", UNIT))
        if not law.search(says)
    ]
    assert missing == []
