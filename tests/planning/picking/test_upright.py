"""Parts that stay upright: not taken where they lie tilted, not put where they would be."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason
from workbench.model.derived.upright import leans_too_far, tilt_from_vertical
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import PartPlace
from workbench.model.scan import Detection
from workbench.planning.kinematics.chain import chain_of
from workbench.proof.claims.prove import prove

UP = np.array([0.0, 0.0, 1.0])


def upright(cell, axis, degrees: float):
    part = replace(cell.parts[0], upright=np.array(axis), tilt=np.deg2rad(degrees))
    return replace(cell, parts=(part, *cell.parts[1:]))


@pytest.fixture(scope="module")
def pucks():
    return upright(read_cell("tx2_90"), UP, 8.0)


def lying(cell, degrees: float) -> Detection:
    T = pose_from_rpy((0.6, 0.0, 0.03), (np.deg2rad(degrees), 0, 0))
    return Detection(cell.parts[0].name, T)


def tilts(cell, plan):
    """Of all that an arm carries, between its waypoints [rad]."""
    for arm_plan in plan.arms:
        chain = chain_of(cell, cell.arm(arm_plan.arm))
        found = plan.detections[arm_plan.detection]
        axis = cell.part(found.part).upright
        for name in ("extract", "return", "place"):
            q = np.asarray(arm_plan.leg(name).q)
            for share in np.linspace(0, 1, 20):
                for between in q[:-1] + share * np.diff(q, axis=0):
                    R = chain.pose(between).rotation @ arm_plan.T_tcp_part.rotation
                    yield tilt_from_vertical(R @ axis)


def test_a_part_stays_upright_where_it_would_be_tilted_otherwise(pucks):
    free = read_cell("tx2_90")
    plan = plan_pick(pucks, (lying(pucks, 3.0),), "scan", seed=0).plan
    assert plan is not None and max(tilts(pucks, plan)) <= np.deg2rad(8.1)
    other = plan_pick(free, (lying(free, 3.0),), "scan", seed=0).plan
    said = prove(pucks, other.scene, replace(other, cell_digest=pucks.digest)).violations
    assert any("8.0 deg are allowed" in str(violation) for violation in said)


def test_two_arms_at_once_carry_theirs_upright(cell, detections):
    """Each part by the axis of its own that points up as it lies."""
    ups = [one.T_world_part.rotation.T @ UP for one in detections]
    apart = float(np.arccos(np.clip(ups[0] @ ups[1], -1, 1)))
    held = upright(cell, ups[0], np.rad2deg(apart) + 20.0)
    done = plan_pick(held, detections, "scan", seed=0, strategy="coordinated", threshold=0.0)
    assert done.plan is not None and len(done.plan.arms) == 2 and done.proof.holds
    assert max(tilts(held, done.plan)) <= held.parts[0].tilt + np.deg2rad(0.1)


def test_a_part_that_lies_tilted_is_left_and_the_verdict_has_the_figures(pucks):
    candidates = plan_pick(pucks, (lying(pucks, 20.0),), "scan", seed=0).candidates
    assert {candidate.verdict.reason for candidate in candidates} == {Reason.TILTED}
    assert str(candidates[0].verdict) == (
        "tilted (it lies tilted by 20.0 deg; 8.0 deg are allowed)"
    )


def test_a_part_that_looks_the_same_upside_down_may_lie_either_way(pucks):
    for degrees in (180.0, 177.0):
        done = plan_pick(pucks, (lying(pucks, degrees),), "scan", seed=0)
        assert done.plan is not None and done.proof.holds
    assert leans_too_far(
        pucks.parts[0], lying(pucks, 160.0), lying(pucks, 160.0).T_world_part.rotation
    )


def test_a_place_that_would_tilt_it_is_refused(pucks):
    (arm,) = pucks.arms
    aslant = tuple(T * pose_from_rpy((0, 0, 0), (0.3, 0, 0)) for T in arm.Ts_world_place)
    cell = replace(pucks, arms=(replace(arm, Ts_world_place=aslant),))
    done = plan_pick(cell, (lying(cell, 0.0),), "scan", seed=0)
    notes = [c.verdict.note for c in done.candidates if c.verdict.reason is Reason.NO_PLACE]
    assert done.plan is None and notes
    assert all(note.mentions(VerdictNote.TILTED_THERE) for note in notes)


def test_a_place_of_the_part_that_would_tilt_it_is_refused_with_the_figures(pucks):
    (arm,) = pucks.arms
    aslant = PartPlace(pose_from_rpy((0.25, -0.56, 0.19), (0.3, 0, 0)))
    cell = replace(pucks, arms=(replace(arm, Ts_world_place=(), part_places=(aslant,)),))
    done = plan_pick(cell, (lying(cell, 0.0),), "scan", seed=0)
    notes = [c.verdict.note for c in done.candidates if c.verdict.reason is Reason.NO_PLACE]
    assert done.plan is None and notes
    assert {str(note) for note in notes} == {
        "there the part would be tilted by 17.2 deg; 8.0 deg are allowed"
    }


def test_an_unknown_roll_counts_with_its_worst_turn(cell, detections):
    """The roll is about z; an axis that leans by 30 degrees from it may point anywhere around."""
    lean = np.deg2rad(30.0)
    part = replace(
        cell.parts[0], upright=np.array([np.sin(lean), 0, np.cos(lean)]), tilt=np.deg2rad(40.0)
    )
    R = np.eye(3)
    for roll in (True, False):
        found = replace(detections[0], roll_known=roll)
        assert leans_too_far(part, found, R) is None
    tipped = pose_from_rpy((0, 0, 0), (np.deg2rad(15.0), 0, 0)).rotation
    assert leans_too_far(part, replace(detections[0], roll_known=True), tipped) is None
    worst = leans_too_far(part, replace(detections[0], roll_known=False), tipped)
    assert worst == pytest.approx(np.deg2rad(45.0))
