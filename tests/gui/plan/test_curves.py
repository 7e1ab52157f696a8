"""The plan over time, as lanes and curves."""

import re
from dataclasses import replace

import numpy as np
import pytest

from workbench.gui.plan.curves import (
    NEAR_MARGIN_LEGS,
    axis_curves,
    clearance_curves,
    doing,
    lanes_html,
    speed_curve,
)
from workbench.gui.shared.playback import Run, timeline
from workbench.gui.shared.plots import cursor_style
from workbench.model.robot import AxisMapping


@pytest.fixture(scope="module")
def runs(result):
    return timeline(result.plan)


def test_each_leg_has_a_block_and_each_arm_a_lane(cell, result, runs):
    html = lanes_html(cell, runs, result.plan.cycle_seconds)
    assert html.count('class="wb-block') == len(runs)
    assert html.count("wb-holds") == sum(run.leg.holding for run in runs)
    assert html.count('class="wb-lane"') == len(cell.arms)


def test_sync_points_are_named_over_the_lanes_and_told_in_words(cell, runs):
    leg = runs[0].leg
    three = tuple(
        Run(arm, leg, k * leg.seconds, (k + 1) * leg.seconds)
        for k, arm in enumerate(("right", "left", "left"))
    )
    html = lanes_html(cell, three, 3 * leg.seconds)
    assert html.count('class="wb-sync"') == 1 and ">S1</i>" in html
    assert f"S1, {leg.seconds:.2f} s; right: {leg.name}; left: {leg.name}" in html
    assert "1 sync point<" in html
    assert "sync" not in lanes_html(cell, three[1:], 3 * leg.seconds)


def test_names_of_sync_points_do_not_lie_over_each_other(cell, runs):
    leg = replace(runs[0].leg, q=runs[0].leg.q[:2], t=np.array([0.0, 0.01]))
    many = tuple(Run(("right", "left")[k % 2], leg, 0.01 * k, 0.01 * (k + 1)) for k in range(60))
    html = lanes_html(cell, many, 0.6)
    named = [float(at) for at in re.findall(r'left:([\d.]+)%" title="[^"]*">S', html)]
    assert html.count('class="wb-sync"') == 59 and 10 < len(named) < 59
    assert np.diff(named).min() >= 4.4


def test_the_curves_of_axes_begin_at_home_in_degrees_and_wire_order(cell, result, runs):
    right = cell.arm("right")
    times, *axes = axis_curves(cell, right, runs, result.plan.cycle_seconds)
    assert times[-1] == pytest.approx(result.plan.cycle_seconds)
    np.testing.assert_allclose(
        [curve[0] for curve in axes], [0, -130, 30, 0, 40, 0, -135], atol=0.01
    )


def test_the_lowest_point_of_the_clearance_curve_is_the_smallest_clearance(result, runs):
    proof = result.proof
    times, free, straight, _ = clearance_curves(runs, proof)
    assert np.all(np.diff(times) > 0)
    assert np.all(np.isfinite(free) | np.isfinite(straight)), "something moves all the time"
    assert np.nanmin(free) == pytest.approx(proof.clearance * 1000, abs=1e-9)
    near = min(d.min() for _, leg, d in proof.clearances if leg in NEAR_MARGIN_LEGS)
    assert np.nanmin(straight) == pytest.approx(near * 1000)


def test_an_arm_that_waits_for_the_other_still_counts(result, runs):
    """Two legs at once, one of them longer: what was proven of the first holds until then."""
    first = runs[0]
    leg = replace(first.leg, t=0.5 * np.asarray(first.leg.t))
    both = (
        Run("right", leg, 0.0, leg.seconds),
        Run("left", first.leg, 0.0, first.leg.seconds),
    )
    count = len(leg.t)
    near, far = np.full(count, 0.020), np.full(count, 0.090)
    near[count - 2] = 0.010
    clearances = (("right", leg.name, near), ("left", leg.name, far))
    times, free, _, _ = clearance_curves(both, replace(result.proof, clearances=clearances))
    assert times[-1] > 1.9 * leg.seconds
    assert np.all(free[times > leg.seconds] == pytest.approx(10.0))


def test_a_proof_without_clearances_has_an_empty_curve(result, runs):
    times, free, straight, _ = clearance_curves(runs, replace(result.proof, clearances=()))
    assert len(times) == len(free) == len(straight) == 2
    assert np.isnan(free).all()


@pytest.mark.parametrize(
    ("time", "share"), [(-1.0, "0.00%"), (0.0, "0.00%"), (5.0, "50.00%"), (99.0, "100.00%")]
)
def test_the_cursor_stays_within_its_track(time, share):
    assert f"left:{share}" in cursor_style(time, 10.0)


def test_what_goes_on_is_said(cell, result, runs):
    first = runs[0]
    assert str(doing(runs, first.start)) == f"{first.arm}: {first.leg.name}"
    assert doing(runs, result.plan.cycle_seconds + 1) == "at the end"
    assert doing((), 0.0) == "at home"


def test_the_distance_between_the_arms_is_that_of_the_proof(result, runs):
    *_, apart = clearance_curves(runs, result.proof)
    smallest = min(float(values.min()) for _, _, values in result.proof.apart)
    assert np.nanmin(apart) == pytest.approx(smallest * 1000)


def test_no_joint_is_faster_than_its_limit(cell, result, runs):
    for arm in cell.arms:
        share = speed_curve(arm, cell, runs, result.plan.cycle_seconds)
        assert 1.0 < share.max() <= 100.0


def test_the_curves_of_axes_are_counted_as_a_controller_with_coupled_axes_does(cell, result, runs):
    coupled = np.eye(7)
    coupled[2, 1] = -1.0
    arm, seconds = cell.arm("right"), result.plan.cycle_seconds
    _, *plain = axis_curves(cell, arm, runs, seconds)
    mapped = replace(arm, mapping=AxisMapping(coupled, np.zeros(7)))
    _, *shown = axis_curves(cell, mapped, runs, seconds)
    np.testing.assert_allclose(shown[2], plain[2] - plain[1])
    np.testing.assert_allclose(shown[3], plain[3])
