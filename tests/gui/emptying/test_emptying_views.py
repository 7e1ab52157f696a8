"""What the tab says of piles that were emptied in simulation."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.emptying.summary import summary
from workbench.app.emptying.what_if import rank_changes
from workbench.gui.emptying.curves import MOST_CURVES, end_of, taken_plot
from workbench.gui.emptying.views import (
    COLUMNS,
    PileOrder,
    changes_html,
    left_html,
    order_piles,
    piles_html,
    summary_html,
)
from workbench.gui.shared.colours import MUTED, VERDICTS, left_colour
from workbench.model.candidate import Reason
from workbench.model.messages.changes import ChangeText
from workbench.model.messages.message import Message, plain
from workbench.model.prediction import EmptiedPile, Emptying, LeftPart, PileTask

TAKES = {"scan_seconds": 1.0, "approval_seconds": 0.0}
HEADINGS = {column: f"h-{column}" for column in COLUMNS}
ROWS = [f"r-{number}" for number in range(30)]


def pile(
    seed: int,
    outcomes: tuple[str, ...],
    left: tuple[LeftPart, ...] = (),
    change: Message | None = None,
):
    taken = sum(not one for one in outcomes)
    failed = tuple(outcomes.count(kind) for kind in ("missed", "crooked", "turned"))
    task = PileTask("cell", "peg+<b>", taken + sum(failed) + len(left), seed, change=change)
    return EmptiedPile(task, task.count, taken, failed, 0, 0, len(outcomes), len(outcomes) + 3,
                       5.0 * len(outcomes), left, (0.1,), (("propose", 0.1),), 0.0,
                       outcomes=outcomes)  # fmt: skip


STAYS = (
    LeftPart(
        "part-2", "tool collision", plain("the palm and <i>bin_wall</i>, 1.5 mm"), "take it deeper"
    ),
    LeftPart("part-4", "not found", plain("it was not found"), ""),
)
PILES = (pile(7, ("", "missed", "")), pile(8, ("",), STAYS), pile(9, ("", "", "")))
FOUND = Emptying("d" * 64, PILES)


def test_the_sum_says_what_was_taken_what_failed_and_what_stays():
    html = summary_html(FOUND, summary(PILES, **TAKES), is_stale=False)
    assert "6 of 9 parts, 67%" in html
    assert "7, 1 failed (1 missed), 0 touches" in html
    assert "1 tool collision, 1 not found" in html
    assert "100 ms median" in html and "seed 7 to 9, by true poses, in simulation" in html
    assert "has changed since" not in html
    assert "has changed since" in summary_html(FOUND, summary(PILES, **TAKES), is_stale=True)


def test_where_nothing_was_planned_no_number_is_made_up():
    bare = replace(pile(1, (), STAYS), planning=(), stages=(), motion_seconds=0.0, scans=0)
    html = summary_html(Emptying("", (bare,)), summary((bare,), **TAKES), is_stale=False)
    assert "0 of 2 parts, 0%" in html and "nan" not in html and "None" not in html


def test_whatever_a_part_is_called_it_is_text():
    html = summary_html(FOUND, summary(PILES, **TAKES), is_stale=False)
    html += left_html(PILES[1], None, ROWS)
    assert "<b>" not in html and "<i>bin" not in html and "&lt;i&gt;bin_wall" in html


@pytest.mark.parametrize(
    ("order", "seeds"),
    [
        (PileOrder(), [7, 8, 9]),
        (PileOrder("seed", True), [9, 8, 7]),
        (PileOrder("taken", True), [9, 7, 8]),
        (PileOrder("left", True), [8, 7, 9]),
        (PileOrder("failed", True), [7, 8, 9]),
        (PileOrder("plans"), [8, 7, 9]),
        (PileOrder("motion", True), [7, 9, 8]),
    ],
)
def test_the_table_sorts_by_each_column(order, seeds):
    shown = order_piles(PILES, order)
    assert [PILES[number].task.seed for number in shown] == seeds
    html = piles_html(PILES, shown, order, None, headings=HEADINGS, rows=ROWS)
    places = [html.index(f">{seed}</td>") for seed in seeds]
    assert places == sorted(places)
    assert html.count("▾") + html.count("▴") == 1 and ("▾" in html) == order.is_descending


def test_the_chosen_pile_is_marked_and_each_row_has_its_button():
    html = piles_html(PILES, (2, 0, 1), PileOrder(), 0, headings=HEADINGS, rows=ROWS)
    body = html.split("<tbody>")[1].split("<tr")[1:]
    assert ["wb-chosen" in row for row in body] == [False, True, False]
    assert [f"r-{place}'" in row for place, row in enumerate(body)] == [True] * 3
    assert "part-2 tool in collision, part-4 not found" in body[2] and "nothing stays" in body[0]


def test_a_part_that_stays_has_its_sentence_its_fix_and_its_colour():
    html = left_html(PILES[1], 3, ROWS)
    assert "1.5 mm" in html and "Smallest change that takes it: take it deeper." in html
    assert "No small change of a grasp takes it." in html
    rows = html.split("<tbody>")[1].split("<tr")[1:]
    assert VERDICTS[Reason.TOOL_COLLISION] in rows[0] and MUTED in rows[1]
    assert ["wb-chosen" in row for row in rows] == [False, True]
    assert "The bin was emptied" in left_html(PILES[0], None, ROWS)


def test_every_verdict_has_its_colour_in_the_bin_too():
    assert [left_colour(str(reason)) for reason in VERDICTS] == list(VERDICTS.values())


def test_changes_are_told_with_what_they_gain_and_lose():
    more = pile(8, ("", "", ""), (), ChangeText.FINGERS_THINNER(by=0.001))
    less = pile(8, (), (*STAYS, STAYS[0]), plain("in words, as older records have it"))
    html = changes_html(rank_changes((PILES[1], more, less), **TAKES))
    first, second = html.split("<tbody>")[1].split("<tr")[1:]
    assert "in words, as older records" in second
    assert "fingers 1 mm thinner" in first and "33%" in first and "100%" in first
    assert "wb-gain" in first and "+2" in first and "wb-loss" in second and "-1" in second
    assert changes_html(()) == ""


def test_a_curve_rises_with_each_part_and_is_level_where_a_pick_failed():
    plot = taken_plot(PILES)
    assert [curve.name for curve in plot.curves] == ["seed 7", "seed 8", "seed 9"]
    np.testing.assert_array_equal(plot.curves[0].values, [0, 1, 1, 2])
    np.testing.assert_array_equal(plot.curves[1].values, [0, 1, np.nan, np.nan])
    assert plot.bounds == (0.0, 3.0) and plot.along == "pick" and end_of(plot) > 5.0


def test_more_piles_than_colours_are_not_drawn_and_that_is_said():
    plot = taken_plot(PILES * 5)
    assert len(plot.curves) == MOST_CURVES and f"first {MOST_CURVES} piles" in plot.title
