"""The table of the parts found: what each row tells."""

import re
from dataclasses import replace

import numpy as np
import pytest

from workbench.gui.parts.fates import part_fates
from workbench.gui.parts.views import parts_html
from workbench.gui.shared.views import parts_line
from workbench.gui.texts.parts import PartsText
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.words.words import words_of

EVIL = "<b>bolt</b>"


def test_parts_say_how_sure_they_are_where_it_is_known():
    T = pose_from_rpy((0, 0, 0))
    variances = np.diag([1e-8, 4e-8, 1e-8, 1e-5, 1e-5, 4e-5])
    sure = Detection("bolt", T, residual=1e-4, covariance=variances, probability=0.93)
    html = parts_html((sure, Detection(EVIL, T)), 0, ("a", "b"))
    text = re.sub(r"<[^>]*>", " ", html)
    for word in ("Sure", "93%", "0.20 mm 0.4°", "by hand", "&lt;b&gt;bolt"):
        assert word in text
    assert EVIL not in html and text.count("°") == 1


def test_below_each_part_stands_what_the_plans_do_with_it(states):
    found = states.planned.detections
    rows = [f"row-{number}" for number in range(len(found))]
    html = parts_html(found, 0, rows, fates=part_fates(states.planned))
    assert html.count('class="wb-fate"') == len(found) == 2
    for pick in states.planned.plan.picks:
        assert f"the {pick.arm} arm takes it" in html
    assert "wb-fate" not in parts_html(found, 0, rows)


def test_a_part_that_is_left_says_why_and_what_came_farthest(states):
    state = states.planned
    left, near = (
        state.detections[0],
        Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT, distance=-0.002),
    )
    early = Verdict(Reason.OUT_OF_REACH, Stage.GRASP)
    candidate = state.candidates[0]
    tried = tuple(
        replace(candidate, detection=2, verdict=verdict) for verdict in (early, near, early)
    )
    more = replace(
        state,
        detections=(*state.detections, left, left),
        plan=replace(state.plan, detections=(*state.plan.detections, left, left)),
        candidates=(*state.candidates, *tried),
    )
    fates = [str(fate) for fate in part_fates(more)]
    assert fates[2] == (
        f"Not taken: {near.message}; {candidate.grasp_label}, {candidate.arm} arm, "
        "got farthest of 3"
    )
    assert fates[3] == "Not taken: no grasp was tried"
    works = replace(tried[0], verdict=Verdict(Reason.OK, Stage.ROUTE))
    able = replace(more, candidates=(*more.candidates, works))
    assert str(part_fates(able)[2]) == "Left for a later plan: 1 grasp works"


def test_before_a_plan_nothing_is_stated_of_parts_and_without_one_why_each_is_left(states):
    assert part_fates(states.localized) == (None, None)
    verdict = Verdict(Reason.NO_PATH, Stage.ROUTE)
    refused = tuple(replace(each, verdict=verdict) for each in states.planned.candidates)
    state = replace(states.planned, plan=None, proof=None, verdict=verdict, candidates=refused)
    fates = [str(fate) for fate in part_fates(state)]
    assert all("Not taken: " in fate and "got farthest" in fate for fate in fates)


def test_without_a_plan_a_part_with_grasps_that_work_states_why_there_is_none(states):
    planned, verdict = states.planned, Verdict(Reason.NO_PATH, Stage.ROUTE)
    works = replace(planned.candidates[0], verdict=Verdict(Reason.OK, Stage.PLACE))
    both = tuple(replace(works, detection=part) for part in (0, 1, 1))
    state = replace(planned, plan=None, proof=None, verdict=verdict, candidates=both)
    assert [str(fate) for fate in part_fates(state)] == [
        f"Not taken: no plan ({verdict.message}); 1 grasp works apart from that",
        f"Not taken: no plan ({verdict.message}); 2 grasps work apart from that",
    ]


@pytest.mark.parametrize(
    ("language", "of"), [("it", "tra 12"), ("es", "entre 12"), ("fr", "parmi 12")]
)
def test_a_grasp_got_farthest_among_others_not_farther_than_their_count(language, of):
    verdict = Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT).message
    left = PartsText.LEFT(verdict=verdict, grasp="side", arm="left", count=12)
    text = words_of(language).render(left)
    assert f" {of}, side" in text and text.count("12") == 1


def test_a_part_placed_by_hand_has_no_score(states):
    by_hand = Detection("bolt", pose_from_rpy((0, 0, 0)))
    html = parts_html((by_hand,), None, ("a",))
    assert "1.00" not in html and "100%" not in html and "by hand" in html
    scanned = states.localized
    assert "1.00" not in parts_line(replace(scanned, detections=(*scanned.detections, by_hand)))
    assert "by hand" in parts_line(replace(scanned, detections=(by_hand,)))


def test_a_plan_that_stirs_leaves_no_part_for_a_later_plan(states):
    state = states.planned
    arm = state.plan.arms[0]
    stirring = replace(state.plan, arms=(replace(arm, legs=(replace(arm.legs[0], name="stir"),)),))
    assert stirring.is_stir_plan
    told = [str(fate) for fate in part_fates(replace(state, plan=stirring)) if fate]
    assert told and not any("later plan" in text for text in told)
