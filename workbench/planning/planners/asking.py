"""Edge checks that compiled planners ask themselves, or have somebody else asked.

A compiled function runs until it needs an answer that compiled code does not have; then it returns,
and is called again with that answer.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from workbench.model.geometry import Bools, Floats, Ints
from workbench.planning.collision.sweeping.edges import ASK, Edges, edge_answer, no_edges
from workbench.planning.compiled import njit_in_place
from workbench.plugins.planner import EdgeCheck


class CompiledCheck:
    """An edge check that compiled code can do by itself where `edges` are known.

    `on_time` raises what ends a search once its time is over.
    """

    def __init__(
        self, is_clear: EdgeCheck, on_time: Callable[[], None], edges: Edges | None
    ) -> None:
        self.is_clear = is_clear
        self.on_time = on_time
        self.edges = edges

    def __call__(self, a: Floats, b: Floats) -> bool:
        """Whether the straight motion from a to b (n,) [rad] is clear."""
        return self.is_clear(a, b)


def edges_in(is_clear: EdgeCheck, count: int) -> Edges:
    """What compiled code can check of an edge check by itself, for this many joints."""
    known = is_clear.edges if isinstance(is_clear, CompiledCheck) else None
    return no_edges(count) if known is None else known


def look_at_the_clock(is_clear: EdgeCheck) -> None:
    """Raise what ends a search when its time is over."""
    if isinstance(is_clear, CompiledCheck):
        is_clear.on_time()


class RecordedAnswers(NamedTuple):
    """Answers to a function's questions; with each new answer the function starts again.

    `known` (k,) are the answers in the order of the questions.  `asked` (2,) counts the questions
    since the start, and the answers.  `edge` (2, n) [rad] is the open question.
    """

    known: Bools
    asked: Ints
    edge: Floats


@njit_in_place
def look_up(a: Floats, b: Floats, edges: Edges, answers: RecordedAnswers) -> int:
    """`CLEAR`, `BLOCKED` or `ASK` for the next straight motion, from a to b (n,) [rad]."""
    number = answers.asked[0]
    answers.asked[0] += 1
    if number < answers.asked[1]:
        return int(answers.known[number])
    answer = edge_answer(a, b, edges)
    if answer == ASK:
        for i in range(len(a)):
            answers.edge[0, i], answers.edge[1, i] = a[i], b[i]
    else:
        answers.known[number] = answer == 1
        answers.asked[1] = number + 1
    return answer


@njit_in_place
def write_row(path: Floats, row: int, q: Floats) -> None:
    """Write q (n,) [rad] into a path (m, n): numba takes seconds to compile `path[row] = q`."""
    for i in range(len(q)):
        path[row, i] = q[i]


def asking(
    compiled: Callable[[Edges, RecordedAnswers], Floats], is_clear: EdgeCheck, count: int, most: int
) -> Floats:
    """What a compiled function returns once it has its answers, a path (m, n) [rad].

    Args:
        compiled: returns an empty array where an answer is missing.
        is_clear: whom to ask.
        count: of joints.
        most: questions that it can ask.
    """
    edges = edges_in(is_clear, count)
    answers = RecordedAnswers(np.zeros(most, np.bool_), np.zeros(2, np.int64), np.zeros((2, count)))
    look_at_the_clock(is_clear)
    while len(result := compiled(edges, answers)) == 0:
        a, b = answers.edge
        answers.known[answers.asked[1]] = is_clear(a.copy(), b.copy())
        answers.asked[1] += 1
        answers.asked[0] = 0
    return result
