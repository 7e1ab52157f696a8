"""Parts vouch for each other: when one goes, those that it vouched for are asked again."""

from types import SimpleNamespace

import numpy as np
import pytest

from workbench.model.scan import Objection
from workbench.perception.localization import judging
from workbench.perception.localization.assessment import Assessment
from workbench.perception.localization.choice import Choice, Rejection
from workbench.perception.localization.judging import JudgedChoice, PartSearch, judge_choices
from workbench.perception.matching.sightings import Sighting

TOLERANCE, SPREAD = 0.001, 0.00025

AREA = 1000
"""Pixels that each part explains: the n-th those from n * AREA on."""


def a_part(number: int, *, behind: int | None = None) -> Assessment:
    """A part that is met exactly; much of it may lie `behind` another one."""
    hidden = range(0) if behind is None else range(behind * AREA, behind * AREA + AREA // 2)
    pose = np.eye(4)
    pose[0, 3] = number
    sighting = Sighting(
        explained=np.arange(number * AREA, (number + 1) * AREA),
        off=np.random.default_rng(number).normal(0.0, SPREAD / 1.5, AREA),
        violated=np.arange(0),
        is_rim=np.arange(0) > 0,
        hidden=np.array(hidden, int),
        ahead=np.full(len(hidden), 2 * TOLERANCE),
    )
    return Assessment(pose, sighting, None, roll_known=True, is_constrained=True, share=1.0)


def lost(number: int, reason: Objection, rival: int) -> Rejection:
    """A pose that lost to the `rival`-th part."""
    return Rejection(np.eye(4), a_part(number).sighting, reason, rival)


@pytest.fixture
def judge(monkeypatch):
    """Judges parts of one kind, of which each in `ends` ends while such a one stands beside it."""

    def outcome(
        parts: list[Assessment],
        ends: dict[int, int | None],
        rejected: list[Rejection] | None = None,
    ) -> JudgedChoice:
        def has_visible_boundary(depth_map, surface, pose, tolerance, is_other, **_) -> bool:
            number = int(pose[0, 3])
            beside = ends.get(number, number)
            if beside is None:
                return False
            return beside == number or bool(is_other[beside * AREA])

        monkeypatch.setattr(judging, "has_visible_boundary", has_visible_boundary)
        claimed = np.repeat(np.arange(len(parts)), AREA)
        depth_map = SimpleNamespace(depth=np.zeros((len(parts), AREA)))
        choice = Choice(claimed, parts, rejected or [])
        (one,) = judge_choices(
            [PartSearch(None, None, depth_map, depth_map, TOLERANCE, SPREAD, all, choice)]
        )  # type: ignore[arg-type]
        return one

    return outcome


def reasons(one: JudgedChoice) -> dict[int, Objection]:
    return {int(each.pose[0, 3]): each.reason for each in one.choice.rejected}


def test_what_lies_behind_a_part_that_goes_on_lies_behind_something_unknown(judge):
    parts = [a_part(0), a_part(1, behind=2), a_part(2)]
    assert len(judge(parts, {}).choice.chosen) == 3
    one = judge(parts, {2: None})
    assert reasons(one) == {1: Objection.UNKNOWN, 2: Objection.GOES_ON}
    assert [each.pose[0, 3] for each in one.choice.chosen] == [0]
    assert len(one.ratios) == 1 and one.ratios[0] > 0.0


def test_what_ended_at_a_part_that_goes_does_not_end(judge):
    """One after the other, to the last."""
    parts = [a_part(0), a_part(1), a_part(2), a_part(3)]
    assert reasons(judge(parts, {1: 2, 2: 3})) == {}
    one = judge(parts, {1: 2, 2: 3, 3: None})
    assert reasons(one) == dict.fromkeys((1, 2, 3), Objection.GOES_ON)
    assert [each.pose[0, 3] for each in one.choice.chosen] == [0]


def test_what_has_lost_to_a_part_that_goes_is_told_all_the_same(judge):
    rejected = [lost(0, Objection.CLAIMED, 0), lost(1, Objection.TWIN, 1)]
    one = judge([a_part(0), a_part(1)], {0: None}, rejected)
    first, second, gone = one.choice.rejected
    assert (first.reason, first.rival) == (Objection.RIVAL_FELL, None)
    assert (second.reason, second.rival) == (Objection.TWIN, 0)
    assert gone.reason is Objection.GOES_ON
