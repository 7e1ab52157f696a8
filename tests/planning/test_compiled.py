"""Functions compiled in place: numba counts no references in them, so they return no array."""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from numba.core.errors import TypingError

import workbench
from workbench.planning.compiled import njit_in_place
from workbench.planning.planners.trees import _draw

NUMBERS = {"None", "int", "float", "bool", "tuple", "PairDrift"}
"""Types that hold no array, of which a function compiled in place returns some."""

SOURCES = Path(workbench.__file__).parent


def functions_in_place(layer: str) -> Iterator[tuple[str, ast.FunctionDef]]:
    for file in sorted((SOURCES / layer).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.FunctionDef) and any(
                isinstance(by, ast.Name) and by.id == "njit_in_place" for by in node.decorator_list
            ):
                yield f"{file.relative_to(SOURCES)}: {node.name}", node


@pytest.mark.parametrize("layer", ["planning", "proof"])
def test_what_is_compiled_in_place_returns_numbers(layer: str) -> None:
    found = dict(functions_in_place(layer))
    assert found
    for name, function in found.items():
        assert function.returns is not None, name
        names = {n.id for n in ast.walk(function.returns) if isinstance(n, ast.Name)}
        assert names <= NUMBERS, name
        taken = ast.dump(function.args)
        # Numba makes an owner of each generator that is handed in, which nobody would release.
        assert "Generator" not in taken, name


def test_a_search_keeps_no_generator():
    rng = np.random.default_rng(3)
    start, goal = np.zeros(2), np.array([0.4, 0.2])
    box = np.array([[-1.0, -1.0], [1.0, 1.0], [1.0, 1.0]])
    sample = np.zeros(2)
    _draw(sample, start, goal, box, 0, rng)
    before = sys.getrefcount(rng)
    for _ in range(10):
        _draw(sample, start, goal, box, 0, rng)
    assert sys.getrefcount(rng) == before


def test_what_is_compiled_in_place_writes_into_what_it_is_handed() -> None:
    @njit_in_place
    def double(values: np.ndarray) -> float:
        total = 0.0
        for i in range(len(values)):
            values[i] *= 2.0
            total += values[i]
        return total

    values = np.arange(4.0)
    assert double(values) == 12.0
    assert values.tolist() == [0.0, 2.0, 4.0, 6.0]


def test_what_is_compiled_in_place_makes_no_array() -> None:
    @njit_in_place
    def make(count: int) -> float:
        return np.zeros(count).sum()

    with pytest.raises(TypingError):
        make(3)
