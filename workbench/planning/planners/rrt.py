"""Paths between two configurations: RRT and RRT-Connect, and shortening what they find.

RRT-Connect (Kuffner and LaValle 2000) is written here rather than taken from OMPL, whose Python
module 2.0.1 takes no sampler: samples near start and goal first are what makes ours quick.
"""

import numpy as np

from workbench.model.geometry import Floats
from workbench.plugins.planner import EdgeCheck, Search

GOAL_BIAS = 10

CUTS = (0.8, 0.5, 0.25)
"""Shares of the segments at a corner that a cut may leave out, tried in this order."""

TINY = np.deg2rad(2.0)
"""[rad] Corners closer together than this in every joint count as one."""

ROUNDS = 2
"""How often all corners are cut: each cut leaves two flatter ones."""


STEP = 0.6
"""[rad] Longest new edge of a tree, in the weighted metric."""

NEARBY = 0.3
WIDENING = 0.03
"""[rad] Samples lie in the box around start and goal, wider by `NEARBY`, and by so much more
with each iteration: most ways need no joint to go far, and most of its range leads elsewhere."""


class Tree:
    """Configurations (n,) [rad] with their parents; grows by doubling its array.

    Concurrency: one thread.
    """

    def __init__(self, root: Floats):
        self.q = np.empty((64, len(root)))
        self.q[0] = root
        self.parents = [-1]

    def add(self, q: Floats, parent: int) -> int:
        """Append a configuration and return its number."""
        number = len(self.parents)
        if number == len(self.q):
            self.q = np.concatenate([self.q, np.empty_like(self.q)])
        self.q[number] = q
        self.parents.append(parent)
        return number

    def nearest(self, q: Floats, weights: Floats) -> int:
        """The configuration closest to `q` (n,) in the weighted Euclidean metric."""
        difference = (self.q[: len(self.parents)] - q) * weights
        return int(np.argmin(np.einsum("ij,ij->i", difference, difference)))

    def branch(self, number: int) -> list[Floats]:
        """From a configuration back to the root."""
        path: list[Floats] = []
        while number >= 0:
            path.append(self.q[number].copy())
            number = self.parents[number]
        return path


def rrt_connect(
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

    The direct way is tried first.  `weights` (n,) make joints count more in the metric: the
    first ones move more of the arm.
    """
    if is_clear(start, goal):
        return Search(np.array([start, goal]), 0)
    trees = (Tree(start), Tree(goal))
    for iteration in range(iterations):
        grown, other = trees if iteration % 2 == 0 else trees[::-1]
        sample = sample_around(start, goal, lower, upper, iteration, rng)
        new = _extend(grown, sample, weights, is_clear)
        if new is None:
            continue
        reached = _connect(other, grown.q[new], weights, is_clear)
        if reached is not None:
            from_start, from_goal = (new, reached) if grown is trees[0] else (reached, new)
            forward = trees[0].branch(from_start)[::-1]
            return Search(np.array(forward + trees[1].branch(from_goal)[1:]), iteration + 1)
    return Search(None, iterations)


def rrt(
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
    """As `rrt_connect`, with a single tree that grows from the start (LaValle 1998).

    Every `GOAL_BIAS`-th sample is the goal.  Configurations are (n,) [rad].
    """
    tree = Tree(start)
    for iteration in range(iterations):
        is_goal = iteration % GOAL_BIAS == 0
        sample = goal if is_goal else sample_around(start, goal, lower, upper, iteration, rng)
        new = _extend(tree, sample, weights, is_clear)
        if new is None or np.linalg.norm((goal - tree.q[new]) * weights) > STEP:
            continue
        if is_clear(tree.q[new].copy(), goal):
            return Search(np.array([*tree.branch(new)[::-1], goal]), iteration + 1)
    return Search(None, iterations)


def sample_around(
    start: Floats,
    goal: Floats,
    lower: Floats,
    upper: Floats,
    iteration: int,
    rng: np.random.Generator,
) -> Floats:
    """A configuration (n,) [rad] within limits, in the box around start and goal; see `NEARBY`."""
    around = NEARBY + WIDENING * iteration
    low = np.maximum(lower, np.minimum(start, goal) - around)
    high = np.minimum(upper, np.maximum(start, goal) + around)
    # What `rng.uniform` does with arrays, number for number, in a fifth of the time.
    return low + (high - low) * rng.random(len(low))


def _extend(tree: Tree, target: Floats, weights: Floats, is_clear: EdgeCheck) -> int | None:
    """One edge from the nearest configuration towards the target."""
    near = tree.nearest(target, weights)
    step = target - tree.q[near]
    length = float(np.linalg.norm(step * weights))
    if length == 0.0:
        return None
    q = target if length <= STEP else tree.q[near] + step * (STEP / length)
    return tree.add(q, near) if is_clear(tree.q[near].copy(), q) else None


def _connect(tree: Tree, target: Floats, weights: Floats, is_clear: EdgeCheck) -> int | None:
    """Edges towards the target until it is reached or something is in the way."""
    while True:
        new = _extend(tree, target, weights, is_clear)
        if new is None:
            return None
        if np.array_equal(tree.q[new], target):
            return new


def shortened(path: Floats, is_clear: EdgeCheck, *, most: int) -> Floats:
    """The same path (m, n) [rad] with detours cut: waypoints skipped, then corners cut off.

    From each kept waypoint it goes straight on to the furthest one that can be reached; then at
    each corner the widest of some straight cuts that is clear is taken, `ROUNDS` times or until
    there could be more than `most` waypoints.
    """
    path = _skipped(path, is_clear)
    for _ in range(ROUNDS):
        if 2 * len(path) - 2 <= most:
            path = _cut(path, is_clear)
    return path


def _cut(path: Floats, is_clear: EdgeCheck) -> Floats:
    """Every corner cut off as widely as `CUTS` allow."""
    kept = [path[0]]
    for before, corner, after in zip(path[:-2], path[1:-1], path[2:], strict=True):
        start = kept[-1] if len(kept) > 1 else before
        for share in CUTS:
            enter = corner + share * (start - corner)
            leave = corner + share * (after - corner)
            if is_clear(enter, leave):
                kept += [enter, leave]
                break
        else:
            kept.append(corner)
    return np.array([*kept, path[-1]])


def _skipped(path: Floats, is_clear: EdgeCheck) -> Floats:
    """From each kept waypoint on to the furthest one that can be reached straight."""
    kept, at = [0], 0
    while at < len(path) - 1:
        onward = len(path) - 1
        while onward > at + 1 and not is_clear(path[at], path[onward]):
            onward -= 1
        kept.append(onward)
        at = onward
    return path[kept]


def merged(path: Floats, is_clear: EdgeCheck) -> Floats:
    """The same path (m, n) [rad], corners less than `TINY` apart made one where that is clear.

    A tiny segment between long ones is a sharp corner twice: it slows the arm down to a crawl.
    """
    kept = [np.asarray(q) for q in path]
    k = 0
    while k < len(kept) - 1:
        a, b = kept[k], kept[k + 1]
        if np.abs(b - a).max() >= TINY or len(kept) == 2:
            k += 1
            continue
        is_first, is_last = k == 0, k + 1 == len(kept) - 1
        one = a if is_first else b if is_last else (a + b) / 2
        before = is_first or is_clear(kept[k - 1], one)
        if before and (is_last or is_clear(one, kept[k + 2])):
            kept[k : k + 2] = [one]
        else:
            k += 1
    return np.array(kept)


def resampled(path: Floats, count: int) -> Floats:
    """The same polyline (m, n) [rad] with `count` waypoints, all its corners among them.

    Extra waypoints go where the steps are longest.  A path with more corners than `count`
    keeps them all: a corner left out would be another path.
    """
    pieces = np.ones(len(path) - 1, int)
    lengths = np.abs(np.diff(path, axis=0)).max(axis=1)
    while 1 + pieces.sum() < count:
        pieces[np.argmax(lengths / pieces)] += 1
    points = [path[0]]
    for start, end, share in zip(path[:-1], path[1:], pieces, strict=True):
        points.extend(start + (end - start) * k / share for k in range(1, share + 1))
    return np.array(points)
