"""Hypotheses of several kinds compete before anybody looks closely."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from workbench.formats.parts.reading import read_part
from workbench.model.scan import Objection
from workbench.perception.localization import judging, kinds
from workbench.perception.localization.choice import Choice, Hypothesis
from workbench.perception.localization.judging import judge_choices
from workbench.perception.localization.kinds import KindHypotheses, compete, look_closely
from workbench.perception.localization.localize import begin_search, proposals
from workbench.perception.scene.scene_model import scene_model
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize

KINDS = tuple(read_part(name) for name in ("bolt", "keyed_cylinder"))
BOLT, CYLINDER = KINDS


@pytest.fixture(scope="module")
def proposed(cell):
    """Where bolts and cylinders may lie among four cylinders and a bolt."""
    mixed = replace(cell, parts=KINDS)
    truth = drop_parts((CYLINDER,) * 4 + (BOLT,), mixed.bin, seed=21)
    scan = synthesize(mixed, truth, seed=21)
    scene = scene_model(scan, mixed)
    sought = [begin_search(scan, part, mixed, detail=1.0, scene=scene) for part in KINDS]
    nothing = [np.zeros(one.depth_map.depth.size, np.bool_) for one in sought]
    return sought, [
        proposals(one, 0, taken, seed=0, step=lambda _: None)
        for one, taken in zip(sought, nothing, strict=True)
    ]


closely = partial(look_closely, lambda _: None)
"""Nobody is told."""


def afresh(sought):
    return [
        replace(one, choice=Choice(np.full(one.depth_map.depth.size, -1), [], [])) for one in sought
    ]


def looked_at(monkeypatch) -> list[object]:
    looks, assess = [], kinds.assess

    def counted(depth_map, coarse_map, surface, *rest):
        looks.append(surface)
        return assess(depth_map, coarse_map, surface, *rest)

    monkeypatch.setattr(kinds, "assess", counted)
    return looks


def test_what_a_larger_part_explains_as_well_needs_no_close_look(proposed, monkeypatch):
    looks = looked_at(monkeypatch)
    sought, found = proposed
    alone, together = afresh(sought[:1]), afresh(sought)
    compete(alone, found[:1], closely)
    beside_none = len(looks)
    looks.clear()
    compete(together, found, closely)
    bolts, cylinders = (one.choice for one in together)
    assert len(cylinders.chosen) == 4 and len(bolts.chosen) == 1
    assert sum(surface is together[0].surface for surface in looks) < beside_none / 2
    assert Objection.OUTDONE in {one.reason for one in bolts.rejected}
    assert not any(one.reason is Objection.OUTDONE for one in cylinders.rejected)


def test_the_order_of_the_kinds_changes_nothing(proposed):
    sought, found = proposed
    one, other = afresh(sought), afresh(sought)[::-1]
    compete(one, found, closely)
    compete(other, found[::-1], closely)
    for first, second in zip(one, other[::-1], strict=True):
        pairs = zip(first.choice.chosen, second.choice.chosen, strict=True)
        assert all(np.array_equal(a.pose, b.pose) for a, b in pairs)


def test_hypotheses_of_a_single_kind_are_all_its_own(proposed):
    sought, found = proposed
    (one,) = afresh(sought[1:])
    compete([one], found[1:], closely)
    poses = len(one.choice.chosen) + len(one.choice.rejected)
    assert poses == len(found[1]) and isinstance(found[1][0], Hypothesis)


def test_of_many_kinds_only_the_kind_that_was_tried_is_weighed_again(proposed, monkeypatch):
    weighed, best_gain = [], KindHypotheses.best_gain

    def counted(kind):
        weighed.append(kind)
        return best_gain.fget(kind)

    monkeypatch.setattr(KindHypotheses, "best_gain", property(counted))
    sought, found = proposed
    many = afresh(sought * 5)
    compete(many, found * 5, closely)
    assert len(weighed) == 5 * sum(map(len, found))
    assert sum(len(search.choice.chosen) for search in many) > 0


def test_kinds_that_are_not_there_change_nothing_of_what_is_judged(proposed, monkeypatch):
    looks, look = [], judging.look

    def counted(*asked):
        looks.append(asked)
        return look(*asked)

    monkeypatch.setattr(judging, "look", counted)
    sought, found = proposed
    there = afresh(sought)
    compete(there, found, closely)
    judged = judge_choices(there)
    asked = len(looks)
    among_others = judge_choices([*there, *afresh(sought * 5)])
    assert 0 < len(looks) == 2 * asked
    assert [one.ratios for one in among_others[: len(there)]] == [one.ratios for one in judged]
    assert not any(one.ratios for one in among_others[len(there) :])
