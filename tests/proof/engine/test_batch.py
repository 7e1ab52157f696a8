"""Sets that are looked at together: nothing that is asked of them is lost."""

import numpy as np
import pytest

from workbench.app.picking.proving import prove
from workbench.proof.engine import search
from workbench.proof.engine.batch import OTHER, Batch, around, firsts, inside
from workbench.proof.engine.sets import Sets


def drawn(draw, columns, groups: int) -> Sets:
    """Groups of one to four sets of one arm."""
    counts = draw.integers(1, 5, groups)
    number, total = np.arange(groups), int(counts.sum())
    corners, hulls = (draw.normal(size=(k, 3, len(columns))) for k in (total, groups))
    sizes = draw.integers(2, 4, total)
    return Sets(columns, corners, sizes, np.repeat(number, counts), hulls, 10 + number)


@pytest.mark.parametrize("arms", [1, 2])
def test_every_set_of_a_group_is_asked_what_is_asked_of_the_group(arms):
    draw, base = np.random.default_rng(arms), np.arange(5.0)
    blocks = [drawn(draw, np.array([0, 3]), 6), drawn(draw, np.array([1, 2]), 4)][:arms]
    groups = around(base, tuple(blocks))
    assert groups.at[:6].tolist() == blocks[0].at.tolist()
    assert (groups.at[6:] == OTHER).all()
    items = np.array([[1, 1, 7], [4, 4, 8]])
    if arms == 2:
        items[:, 1] += 6 - 1
    batch, asked = inside(base, tuple(blocks), items)
    wanted = []
    for one, other, pair in items:
        mine = blocks[0].corners[blocks[0].groups == one]
        if arms == 1:
            wanted += [(*a.ravel(), *a.ravel(), pair) for a in mine]
        else:
            others = blocks[1].corners[blocks[1].groups == other - 6]
            wanted += [(*a.ravel(), *b.ravel(), pair) for a in mine for b in others]
    second = blocks[-1].columns
    found = [
        (*batch.corners[i][:, [0, 3]].ravel(), *batch.corners[j][:, second].ravel(), pair)
        for i, j, pair in asked
    ]
    assert sorted(found) == sorted(wanted)
    stands = np.setdiff1d(np.arange(5), [*blocks[0].columns, *second])
    assert (batch.corners[:, :, stands] == base[stands]).all()
    begins = firsts(base, tuple(blocks))
    assert len(begins) == len(groups)
    assert begins.at.tolist() == groups.at.tolist()


@pytest.mark.parametrize("arms", [1, 2])
def test_halves_hold_what_was_halved(arms):
    """Each corner is a corner of a half; each half is asked about, by both of a pair alike."""
    draw = np.random.default_rng(arms + 10)
    batch = Batch(draw.normal(size=(9, 3, 4)), draw.integers(2, 4, 9), draw.integers(0, 9, 9))
    one = draw.integers(0, 5, 20)
    other = one if arms == 1 else draw.integers(5, 9, 20)
    items = np.column_stack([one, other, np.arange(20)])
    halves, asked = batch.halve(items, np.ones(4))
    assert len(asked) == 40
    assert sorted(asked[:, 2]) == sorted([*range(20), *range(20)])
    assert set(asked[:, :2].ravel()) == set(range(len(halves))), "no set is kept for nothing"
    for first, second, pair in items:
        mine = asked[asked[:, 2] == pair]
        if arms == 1:
            assert (mine[:, 0] == mine[:, 1]).all()
        cut = [k for k in range(2) if len(set(mine[:, k])) == 2]
        assert cut == [0, 1] if arms == 1 else len(cut) == 1
        for k, whole in ((0, first), (1, second)):
            corners = {tuple(c) for c in batch.corners[whole, : batch.sizes[whole]]}
            seen = {tuple(c) for h in mine[:, k] for c in halves.corners[h, : halves.sizes[h]]}
            assert corners <= seen
            assert (halves.at[mine[:, k]] == batch.at[whole]).all()


@pytest.mark.extensive
def test_a_plan_is_proven_alike_whatever_is_looked_at_together(cell, result, monkeypatch):
    usual = prove(cell, result.plan)
    sizes, left = [], search._Search._open_pairs

    def noted(self, batch, items):
        sizes.append(len(batch))
        return left(self, batch, items)

    monkeypatch.setattr(search._Search, "_open_pairs", noted)
    prove(cell, result.plan)
    assert max(sizes) > 4
    sizes.clear()
    monkeypatch.setattr(search, "RUN", 2)
    monkeypatch.setattr(search, "HALVES", 4)
    few = prove(cell, result.plan)
    assert few.holds and max(sizes) == 4
    assert few.clearance == pytest.approx(usual.clearance, abs=0.0003)
