"""SBL: a single-query, bi-directional, lazy planner.

Two trees of clear configurations grow from start and goal.  Their edges are not checked until a
chain of them joins start and goal; then its segments are checked, each coarsely before any is
checked finely.  A segment that fails is taken out, and what hung on it goes over to the other
tree.

Source: G. Sanchez and J.-C. Latombe, "A single-query bi-directional probabilistic roadmap planner
with lazy collision checking", Robotics Research, STAR 6, 2003.
"""

import heapq
from collections import defaultdict
from itertools import pairwise

import numpy as np

from workbench.model.geometry import Floats
from workbench.plugins.planner import EdgeCheck, Search

LONGEST_EDGE = 1.5
"""[rad] Largest distance, in the weighted metric, of a new milestone from the one it grows from."""

JOIN = 6.0
"""[rad] Milestones of the two trees are joined when they lie no further apart, in the metric.

A test of the way between them is lazy and cheap; a tree that first has to grow near is not.
"""

SHRINKINGS = 6
"""Neighbourhoods tried around a milestone, each smaller than the one before."""

CELLS = 8
"""A milestone is chosen from the cells of a grid with this many cells along each of two joints."""

LEVELS = 3
"""How often a segment is halved to look at states on it before it is checked as a whole."""

START, GOAL = 0, 1


class Roadmap:
    """Both trees: milestones (n,) [rad] with their parents, and which root they hang on.

    Concurrency: one thread.
    """

    def __init__(self, start: Floats, goal: Floats):
        self.q = [start, goal]
        self.parents: list[int | None] = [None, None]
        self.trees = [START, GOAL]
        self.children: defaultdict[int, set[int]] = defaultdict(set)

    def add(self, q: Floats, parent: int) -> int:
        """A new milestone under another one."""
        number = len(self.q)
        self.q.append(q)
        self.parents.append(parent)
        self.trees.append(self.trees[parent])
        self.children[parent].add(number)
        return number

    def members(self, tree: int) -> list[int]:
        """The milestones of one tree."""
        return [number for number, label in enumerate(self.trees) if label == tree]

    def branch(self, number: int) -> list[int]:
        """From a milestone back to its root."""
        branch = [number]
        while (parent := self.parents[branch[-1]]) is not None:
            branch.append(parent)
        return branch

    def hand_over(self, top: int, end: int, new_parent: int) -> None:
        """Cut `top` from its parent, and hang its subtree by `end` under a milestone.

        `end` is in the subtree of `top`; the way between them is turned round.
        """
        way = self.branch(end)
        way = way[: way.index(top) + 1]
        parent = self.parents[top]
        if parent is not None:
            self.children[parent].discard(top)
        for lower, upper in pairwise(way):
            self.children[upper].discard(lower)
            self.children[lower].add(upper)
            self.parents[upper] = lower
        self.parents[end] = new_parent
        self.children[new_parent].add(end)
        waiting = [end]
        while waiting:
            number = waiting.pop()
            self.trees[number] = self.trees[new_parent]
            waiting += self.children[number]


def sbl(
    start: Floats,
    goal: Floats,
    lower: Floats,
    upper: Floats,
    weights: Floats,
    is_clear: EdgeCheck,
    *,
    iterations: int,
    rng: np.random.Generator,
) -> Search:
    """A path from start to goal (n,) [rad], or none when the iterations are used up.

    The arguments are those of `planners.rrt_connect`.
    """
    roadmap = Roadmap(start, goal)
    checked: set[tuple[int, int]] = set()
    for iteration in range(iterations):
        tree = int(rng.integers(2))
        parent = _choose(roadmap, tree, lower, upper, rng)
        new = _expand(roadmap, parent, lower, upper, weights, is_clear=is_clear, rng=rng)
        if new is None:
            continue
        other = _nearest(roadmap, new, 1 - tree, weights, rng)
        if other is None:
            continue
        first, second = (new, other) if tree == START else (other, new)
        chain = roadmap.branch(first)[::-1] + roadmap.branch(second)
        failed = _test(roadmap, chain, weights, is_clear, checked)
        if failed is None:
            return Search(np.array([roadmap.q[number] for number in chain]), iteration + 1)
        _take_out(roadmap, chain, failed, len(roadmap.branch(first)) - 1)
    return Search(None, iterations)


def _choose(
    roadmap: Roadmap, tree: int, lower: Floats, upper: Floats, rng: np.random.Generator
) -> int:
    """A milestone, each crowded place of a grid over two joints as likely as a lonely one."""
    members = roadmap.members(tree)
    joints = rng.choice(len(lower), size=min(2, len(lower)), replace=False)
    q = np.array([roadmap.q[number][joints] for number in members])
    share = (q - lower[joints]) / (upper[joints] - lower[joints])
    cells: defaultdict[tuple[int, ...], list[int]] = defaultdict(list)
    for number, cell in zip(members, (share * CELLS).astype(int).tolist(), strict=True):
        cells[tuple(cell)].append(number)
    keys = sorted(cells)
    crowd = cells[keys[int(rng.integers(len(keys)))]]
    return crowd[int(rng.integers(len(crowd)))]


def _expand(
    roadmap: Roadmap,
    parent: int,
    lower: Floats,
    upper: Floats,
    weights: Floats,
    *,
    is_clear: EdgeCheck,
    rng: np.random.Generator,
) -> int | None:
    """A new clear milestone near another one, from ever smaller neighbourhoods."""
    at = roadmap.q[parent]
    for shrinking in range(1, SHRINKINGS + 1):
        half = LONGEST_EDGE / shrinking / np.sqrt(len(at)) / weights
        q = rng.uniform(np.maximum(at - half, lower), np.minimum(at + half, upper))
        if is_clear(q, q):
            return roadmap.add(q, parent)
    return None


def _nearest(
    roadmap: Roadmap, number: int, tree: int, weights: Floats, rng: np.random.Generator
) -> int | None:
    """A milestone of a tree to join with: the nearest, or now and then any, if near enough."""
    members = roadmap.members(tree)
    q = np.array([roadmap.q[member] for member in members])
    distances = np.linalg.norm((q - roadmap.q[number]) * weights, axis=1)
    picked = int(np.argmin(distances)) if rng.random() < 0.75 else int(rng.integers(len(members)))
    return members[picked] if distances[picked] <= JOIN else None


def _test(
    roadmap: Roadmap,
    chain: list[int],
    weights: Floats,
    is_clear: EdgeCheck,
    checked: set[tuple[int, int]],
) -> int | None:
    """The first segment of a chain that fails, counted from 0; None when all are clear.

    Long and coarsely checked segments come first: they fail soonest.
    """
    waiting: list[tuple[float, int, int]] = []
    for k, (a, b) in enumerate(pairwise(chain)):
        if (min(a, b), max(a, b)) not in checked:
            length = float(np.linalg.norm((roadmap.q[b] - roadmap.q[a]) * weights))
            heapq.heappush(waiting, (-length, 0, k))
    while waiting:
        minus, level, k = heapq.heappop(waiting)
        a, b = chain[k], chain[k + 1]
        if level == LEVELS:
            if not is_clear(roadmap.q[a], roadmap.q[b]):
                return k
            checked.add((min(a, b), max(a, b)))
            continue
        steps = 2**level
        for share in (np.arange(steps) + 0.5) / steps:
            q = roadmap.q[a] + share * (roadmap.q[b] - roadmap.q[a])
            if not is_clear(q, q):
                return k
        heapq.heappush(waiting, (minus / 2, level + 1, k))
    return None


def _take_out(roadmap: Roadmap, chain: list[int], failed: int, bridge: int) -> None:
    """Remove a segment; what it parts from its root goes over by way of the bridge.

    `bridge` is the number of the segment that joins the two trees.
    """
    if failed < bridge:
        roadmap.hand_over(chain[failed + 1], chain[bridge], chain[bridge + 1])
    elif failed > bridge:
        roadmap.hand_over(chain[failed], chain[bridge + 1], chain[bridge])
