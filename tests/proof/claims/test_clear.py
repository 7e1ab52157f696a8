"""What lies clear of a part that is lifted stays clear of it, however little that is.

Two bolts as they lay in a pile of 20: the first leans on the other.  They are in touch already,
with other pieces of theirs than those that the lifts below bring together.
"""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from bending import with_leg
from penetration import on_its_lift

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.proof.claims.table import NEARER_BY, TOUCH, least_distance_allowed

LYING = (
    ((436.1786, -31.0882, 14.9278), (-74.3126, 29.0744, 20.7968)),
    ((453.2840, -102.3185, 13.9083), (108.9185, -0.5755, 42.0279)),
)
"""[mm], [deg]"""


@pytest.fixture(scope="module")
def cell():
    return replace(
        read_cell("robots/yumi/full_bin.toml"), parts=(read_part("parts/bolt/full_bin"),)
    )


@pytest.fixture(scope="module")
def pile():
    return tuple(
        Detection("bolt", pose_from_rpy(np.array(p) / 1e3, np.deg2rad(rpy))) for p, rpy in LYING
    )


@pytest.fixture(scope="module")
def alone(cell, pile):
    """Plans by each arm for the first bolt, made without the other and stated with it."""
    plans = [plan_pick(cell, pile[:1], "scan", strategy=arm).plan for arm in ("right", "left")]
    return [replace(plan, detections=pile) for plan in plans]


@pytest.fixture(scope="module")
def taken(cell, pile):
    return plan_pick(cell, pile, "scan", strategy="right", avoided={1: "it stays"})


def gone_wrong(cell, plan):
    """Whether pieces that were clear of the other bolt touch it on the lift."""
    (one,) = plan.arms
    return [(b, n) for b, n in on_its_lift(cell, plan, one, 1) if b > TOUCH and n < 0]


def test_a_plan_whose_lift_would_touch_what_is_clear_is_refused(cell, alone):
    """By 31 and 100 um; what was clear by 0.36 mm was allowed to come 0.5 mm nearer."""
    for plan in alone:
        ((begins, nearest),) = gone_wrong(cell, plan)
        assert begins - NEARER_BY < nearest < 0, "a proof that lets all come nearer by SLACK held"
        (violation,) = prove(cell, plan).violations
        assert (violation.leg, set(violation.pair)) == ("extract", {"part-1", "part-2"})


def test_the_planner_takes_the_part_without_touching_what_is_clear(cell, pile, taken):
    assert taken.plan is not None and taken.proof is not None and taken.proof.holds
    (one,) = taken.plan.arms
    assert min(begins for begins, _ in on_its_lift(cell, taken.plan, one, 1)) < 0, "they touch"
    assert not gone_wrong(cell, taken.plan)


def test_no_lift_that_is_bent_holds_and_touches_what_was_clear(cell, alone, taken):
    """Each joint is turned a little on the way, of a lift that touches and of one that does not."""
    seen: set[tuple[bool, bool]] = set()
    for plan, joint, turn in product((alone[0], taken.plan), range(7), np.deg2rad([-0.05, 0.05])):
        (one,) = plan.arms
        leg = one.leg("extract")
        q = np.array(leg.q)
        q[1:-1, joint] += turn
        bent = with_leg(plan, one.arm, "extract", q=cell.controller.motion.rounded(q), t=leg.t * 3)
        touches, holds = bool(gone_wrong(cell, bent)), prove(cell, bent).holds
        assert not (touches and holds), (joint, turn)
        seen.add((touches, holds))
    assert {(True, False), (False, True)} <= seen


def test_what_is_kept_grows_with_what_there_is_and_is_no_touch():
    assert least_distance_allowed(-0.0003) == pytest.approx(-0.0003 - NEARER_BY)
    assert least_distance_allowed(0.0) == -NEARER_BY
    begins = np.linspace(2 * TOUCH, 0.003, 100).tolist()
    assert all(0 < least_distance_allowed(one) < one for one in begins)
    assert np.all(np.diff([least_distance_allowed(one) for one in begins]) > 0)
