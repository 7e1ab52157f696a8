"""Which candidates the table shows, and in which order."""

import re
from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.gui.shared.colours import BUSY, GOOD, VERDICT_KINDS, verdict_colour
from workbench.gui.shared.tables import (
    COLUMNS,
    PAGE,
    CandidateOrder,
    by_part_html,
    candidates_html,
    chosen_html,
    funnel_html,
    holds,
    on_page,
    order_candidates,
    pages,
    sort_key,
    stages_html,
)
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.derived.row_parts import PartFate
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp

HERE = pose_from_rpy((0, 0, 0))

verdicts = st.builds(
    Verdict,
    reason=st.sampled_from(Reason),
    stage=st.sampled_from(Stage),
    distance=st.none() | st.floats(-0.1, 0.1),
)
candidates_drawn = st.lists(
    st.builds(
        Candidate,
        detection=st.integers(0, 3),
        grasp=st.sampled_from(["a", "b", "c"]).map(lambda name: Grasp(name, HERE, 0.04, 0.03)),
        arm=st.sampled_from(["right", "left"]),
        T_world_tcp=st.just(HERE),
        rank=st.floats(0, 2),
        verdict=verdicts,
    ),
    max_size=40,
)
orders = st.builds(
    CandidateOrder,
    only=st.none() | st.sampled_from(VERDICT_KINDS),
    part=st.none() | st.integers(0, 3),
    column=st.sampled_from(list(COLUMNS)),
    is_descending=st.booleans(),
)


@given(candidates_drawn, orders)
def test_all_pages_together_show_each_wanted_candidate_once(candidates, order):
    indices = order_candidates(candidates, order)
    shown = [number for page in range(pages(len(indices))) for number in on_page(indices, page)]
    wanted = [
        number
        for number, candidate in enumerate(candidates)
        if (order.only is None or candidate.verdict.kind is order.only)
        and order.part in (None, candidate.detection)
    ]
    assert sorted(shown) == wanted


@given(candidates_drawn, orders)
def test_rows_are_sorted_by_the_chosen_column(candidates, order):
    keys = [
        sort_key(candidates[number], order.column) for number in order_candidates(candidates, order)
    ]
    assert keys == sorted(keys, reverse=order.is_descending)


@given(candidates=candidates_drawn.filter(bool))
def test_the_first_refused_candidate_is_that_which_got_farthest_in_the_tab_parts(candidates):
    refused = [candidate for candidate in candidates if not candidate.verdict.is_ok]
    if refused:
        first = refused[order_candidates(refused, CandidateOrder())[0]]
        assert first is PartFate((), tuple(refused)).refused


@given(candidates_drawn)
def test_the_counts_of_the_funnel_are_those_of_the_verdicts(candidates):
    html = funnel_html(candidates, None, dict.fromkeys([None, *VERDICT_KINDS], "id"))
    assert f"all <b>{len(candidates)}</b>" in html
    for kind, count in Counter(candidate.verdict.kind for candidate in candidates).items():
        assert f"{kind.message} <b>{count}</b>" in html


@pytest.mark.parametrize("reason", [Reason.IN_COLLISION, Reason.TOOL_COLLISION])
def test_a_margin_that_is_not_kept_is_no_collision(reason):
    """It was told as one in red, with a distance that says that nothing touches."""
    apart, deep = (
        Verdict(reason, Stage.GRASP, ("hand", "wall"), distance) for distance in (0.0014, -0.0014)
    )
    assert apart.kind is Reason.WITHIN_MARGIN and deep.kind is reason
    assert str(apart) == "too close: hand and wall, 1.4 mm apart"
    assert str(deep) == f"{reason.message}: hand and wall, penetration 1.4 mm"
    assert verdict_colour(apart.kind) == BUSY
    assert verdict_colour(deep.kind) not in (BUSY, GOOD)


def test_by_default_what_works_stands_first(result):
    first = result.candidates[order_candidates(result.candidates, CandidateOrder())[0]]
    assert first.verdict.is_ok


def test_no_page_is_longer_than_the_buttons_behind_its_rows(result):
    indices = order_candidates(result.candidates, CandidateOrder())
    assert all(len(on_page(indices, page)) <= PAGE for page in range(pages(len(indices))))


@pytest.mark.parametrize(("count", "expected"), [(0, 1), (1, 1), (PAGE, 1), (PAGE + 1, 2)])
def test_an_empty_table_has_one_page(count, expected):
    assert pages(count) == expected


def test_each_row_presses_its_own_button(result):
    shown = on_page(order_candidates(result.candidates, CandidateOrder()), 0)
    rows = [f"row-{place}" for place in range(PAGE)]
    html = candidates_html(
        result.candidates,
        shown,
        CandidateOrder(),
        headings=dict.fromkeys(COLUMNS, "heading"),
        rows=rows,
    )
    for row in rows[: len(shown)]:
        assert html.count(f"getElementById('{row}').click()") == 2


def test_the_chosen_row_is_marked_without_writing_the_table_anew():
    assert "nth-child(3)" in chosen_html(2)
    assert "nth-child" not in chosen_html(None)


@given(candidates_drawn, st.sampled_from(["", "part-1", "LEFT b", "grasp right", "nothing-of-it"]))
def test_typed_words_keep_the_rows_that_have_all_of_them(candidates, words):
    shown = [
        candidates[number] for number in order_candidates(candidates, CandidateOrder(words=words))
    ]
    for one in candidates:
        text = f"part-{one.detection + 1} {one.grasp.name} {one.arm} {one.verdict.kind.message}"
        text = f"{text} {one.verdict.stage.message}".casefold()
        assert (one in shown) == all(word in text for word in words.casefold().split())


def test_no_stage_is_told_by_its_internal_name():
    grasp = Grasp("side", HERE, 0.04, 0.03)
    verdict = Verdict(Reason.TOOL_COLLISION, Stage.PROPOSE)
    refused = Candidate(0, grasp, "left", HERE, 0.0, verdict)
    assert "preselection <b>1</b>" in stages_html([refused])
    assert holds(refused, "preselection") and not holds(refused, "propose")


@given(candidates_drawn)
def test_the_stages_count_down_to_what_is_left(candidates):
    html = stages_html(candidates)
    ok = sum(one.verdict.is_ok for one in candidates)
    assert html.endswith(f"remaining</span> <b>{ok}</b></div>")
    first = re.search(r"<b>(\d+)</b>", html)[1]
    assert int(first) == (len(candidates) if ok < len(candidates) else ok)
    refused = sum(int(count) for count in re.findall(r"\u2212(\d+)", html))
    assert refused == len(candidates) - ok


@given(candidates_drawn)
def test_each_part_counts_what_works_for_it_and_its_count_shows_it_alone(candidates):
    buttons = [f"part-{number}" for number in range(40)]
    html = by_part_html(candidates, None, buttons)
    parts = {candidate.detection for candidate in candidates}
    counts = dict(re.findall(r">(\d+): <b>(\d+)</b>", html))
    if len(parts) < 2:
        assert html == ""
        return
    for part in parts:
        of_it = [candidate for candidate in candidates if candidate.detection == part]
        assert int(counts[str(part + 1)]) == sum(one.verdict.is_ok for one in of_it)
        shown = order_candidates(candidates, CandidateOrder(part=part))
        assert sorted(map(id, of_it)) == sorted(id(candidates[number]) for number in shown)
