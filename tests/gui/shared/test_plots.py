"""Curves over the time of a plan: where their cursor stands, and what is read there."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.gui.plan.curves import plots_of
from workbench.gui.shared.playback import timeline
from workbench.gui.shared.plots import (
    MOST_COLUMNS,
    MOST_TICKS,
    Curve,
    Plot,
    cursor_style,
    drawn_samples,
    legend_html,
    plot_html,
    ticks,
)


@given(st.floats(-1e4, 1e4), st.floats(1e-3, 1e4))
def test_ticks_are_few_round_and_inside(low, width):
    found = ticks(low, low + width)
    assert 1 <= len(found) <= MOST_TICKS + 1
    assert all(low - 1e-6 * width <= one <= low + width * (1 + 1e-6) for one in found)
    steps = np.diff(found)
    if len(steps):
        first = steps[0] / 10 ** math.floor(math.log10(steps[0]) + 1e-9)
        assert first == pytest.approx(round(first), rel=1e-6) and round(first) in (1, 2, 5)


def test_between_two_cycles_there_is_no_mark():
    assert ticks(1.0, 2.0, is_whole=True) == (1.0, 2.0)
    assert ticks(1.0, 2.0) != (1.0, 2.0)
    curve = Curve("send", "#000", np.array([1.0, 2.0]))
    html = plot_html(Plot("t", "s", np.array([1.0, 2.0]), (curve,), along="cycle"), 2.0)
    marks = html[html.index('class="wb-times"') :]
    assert re.findall(r">([\d.]+)<", marks) == ["1", "2"]
    assert "2<span> cycle</span></b>" in marks and "right:0" in marks, "no number under the unit"


def test_every_plot_of_a_plan_has_a_cursor_and_goes_to_the_slider(cell, result):
    runs, seconds = timeline(result.plan), result.plan.cycle_seconds
    plots = plots_of(cell, runs, seconds, [result.proof])
    assert [plot.unit for plot in plots] == ["mm", "mm", "%", "deg", "deg"]
    for plot in plots:
        html = plot_html(plot, seconds, "slider-7")
        assert html.count('class="wb-at"') == 1
        assert html.count("<path") == len(plot.curves)
        assert "slider-7" in html and "nan" not in html
    assert f"{100 * 3 / seconds:.2f}%" in cursor_style(3.0, seconds)


def test_clearance_and_the_distance_of_the_arms_have_axes_of_their_own(cell, result):
    clear, apart, *_ = plots_of(
        cell, timeline(result.plan), result.plan.cycle_seconds, [result.proof]
    )
    assert clear.bounds[1] <= 100.0 < apart.bounds[1]


def test_a_gap_is_a_gap_and_a_bound_holds_from_its_waypoint_on():
    times = np.array([0.0, 1.0, 2.0, 3.0])
    plot = Plot("t", "mm", times, (Curve("a", "#000", np.array([1.0, 2.0, np.nan, 4.0])),))
    path = re.search(r'd="([^"]*)"', plot_html(plot, 3.0, "s"))[1]
    assert path.count("M") == 2 and path.count("L") == 1
    for time, said in ((0.0, "1.0"), (1.9, "2.0"), (2.5, "-"), (9.0, "4.0")):
        assert f"<b>{said}</b>" in legend_html(plot, time)


def test_a_curve_of_a_long_session_is_drawn_by_its_extremes():
    cycles = 40_000
    values = np.sin(np.arange(cycles) / 900.0)
    values[[123, 30_001]] = 9.0, -9.0
    values[20_000:20_400] = np.nan
    drawn = drawn_samples(values)
    assert len(drawn) <= 2 * MOST_COLUMNS and {123, 30_001} <= set(drawn.tolist())
    numbers = np.arange(1.0, cycles + 1)
    long, short = (
        plot_html(Plot("t", "s", numbers[:k], (Curve("a", "#000", values[:k]),)), float(k))
        for k in (cycles, 2 * MOST_COLUMNS)
    )
    assert len(long) < 1.2 * len(short)
    path = re.search(r'd="([^"]*)"', long)[1]
    assert path.count("M") == 2 and 'd="M' in long


def test_of_a_short_curve_every_sample_is_drawn():
    assert drawn_samples(np.full(2 * MOST_COLUMNS, np.nan)).tolist() == [*range(2 * MOST_COLUMNS)]


def test_what_is_written_in_a_plot_is_text():
    plot = Plot("<i>", "<u>", np.zeros(2), (Curve("<b>x", "#000", np.zeros(2)),))
    assert "<i>" not in plot_html(plot, 1.0, "s")
    assert "<b>x" not in legend_html(plot, 0.0)


def test_the_required_margins_are_lines_within_the_plot_of_clearances(cell, result):
    clear, *others = plots_of(
        cell, timeline(result.plan), result.plan.cycle_seconds, [result.proof]
    )
    policy = cell.policy
    assert [value for value, _ in clear.limits] == [policy.margin * 1000, policy.near_margin * 1000]
    assert not any(plot.limits for plot in others)
    assert plot_html(clear, 5.0).count('class="wb-limit"') == 2
    assert "required (5.0 mm free, 1.0 mm linear)" in clear.title
    far = replace(clear, limits=((500.0, "#000"),))
    assert far.bounds[1] == 500.0, "a margin is shown where no curve comes near it"
