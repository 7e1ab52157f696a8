"""SBL: its two trees stay trees, whatever is taken out of them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.planning.planners.sbl import GOAL, START, Roadmap, sbl


def grown(seed: int, count: int = 30) -> Roadmap:
    rng = np.random.default_rng(seed)
    roadmap = Roadmap(np.zeros(2), np.ones(2))
    for _ in range(count):
        parent = int(rng.integers(len(roadmap.q)))
        roadmap.add(rng.uniform(0, 1, 2), parent)
    return roadmap


def check(roadmap: Roadmap) -> None:
    """Every milestone hangs on the root of its tree, and parents know their children."""
    for number, parent in enumerate(roadmap.parents):
        root = roadmap.branch(number)[-1]
        assert root == roadmap.trees[number]
        if parent is not None:
            assert number in roadmap.children[parent]
    listed = sorted(child for children in roadmap.children.values() for child in children)
    assert listed == [n for n, parent in enumerate(roadmap.parents) if parent is not None]


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 9999), cuts=st.integers(1, 8))
def test_what_is_cut_off_goes_over_whole(seed, cuts):
    roadmap = grown(seed)
    rng = np.random.default_rng(seed + 1)
    for _ in range(cuts):
        end = int(rng.integers(2, len(roadmap.q)))
        way = roadmap.branch(end)
        top = way[int(rng.integers(len(way) - 1))]
        others = [n for n, tree in enumerate(roadmap.trees) if tree != roadmap.trees[end]]
        goes = {n for n in range(len(roadmap.q)) if top in roadmap.branch(n)}
        stays = {n: roadmap.trees[n] for n in range(len(roadmap.q)) if n not in goes}
        target = others[int(rng.integers(len(others)))]
        roadmap.hand_over(top, end, target)
        check(roadmap)
        assert all(roadmap.trees[n] == roadmap.trees[target] for n in goes)
        assert all(roadmap.trees[n] == tree for n, tree in stays.items())
    assert (roadmap.trees[0], roadmap.trees[1]) == (START, GOAL)


def test_segments_are_checked_once_when_nothing_is_in_the_way():
    """Lazily: whole segments only on the way that joins both roots."""
    looked: list[tuple[np.ndarray, np.ndarray]] = []

    def is_clear(a, b):
        if not np.array_equal(a, b):
            looked.append((a, b))
        return True

    box = np.full(3, 2.0)
    path = sbl(
        -box / 2, box / 2, -box, box, np.ones(3), is_clear,
        iterations=500, rng=np.random.default_rng(0),
    ).path  # fmt: skip
    assert len(looked) == len(path) - 1
