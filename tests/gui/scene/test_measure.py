"""What a click means, how distances read, and how far an arm reaches."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest
from shipped import shipped
from waiting import PATIENCE

import workbench.gui.cell.panel
import workbench.gui.drawing.reach
from workbench.gui.cell.panel import CellPanel
from workbench.gui.cell.views import measured_line, reach_line
from workbench.gui.drawing.reach import Reaches
from workbench.gui.scene.marks import measured_text
from workbench.gui.scene.measure import pick_point
from workbench.gui.shared.look import NO_REACH, Look
from workbench.gui.shared.playback import moments
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.reach_map import reach_map

CELL = shipped("yumi")
NONE = np.zeros((0, 3))
DOWN = np.array([0.0, 0.0, -1.0])


def test_a_ray_into_the_bin_meets_its_floor():
    p = pick_point(np.array([0.41, 0.0, 1.0]), DOWN, CELL, {}, NONE)
    np.testing.assert_allclose(p, CELL.bin.T_world_bin.translation, atol=1e-9)


def test_a_scanned_point_in_front_is_what_was_meant():
    points = np.array([[0.41, 0.001, 0.02], [0.41, 0.1, 0.03]])
    p = pick_point(np.array([0.41, 0.0, 1.0]), DOWN, CELL, {}, points)
    np.testing.assert_allclose(p, [0.41, 0.0, 0.02], atol=1e-9)


def test_a_ray_into_the_sky_meets_nothing():
    assert pick_point(np.array([0.41, 0.0, 1.0]), -DOWN, CELL, {}, NONE) is None


def test_the_robot_is_met_where_it_is_jogged_to():
    arm = CELL.arms[0]
    home = pick_point(np.array([0.0, 0.0, 3.0]), DOWN, CELL, {}, NONE)
    assert home[2] > 0.3, "the body of the robot"
    q = np.asarray(arm.home) + [1.2, 0.6, 0, 0, 0, 0, 0]
    tip = chain_of(CELL, arm).pose(q)
    palm, across = tip.translation - 0.1 * tip.rotation[:, 2], tip.rotation[:, 0]
    there = pick_point(palm + 0.15 * across, -across, CELL, {arm.name: q}, NONE)
    assert there is not None and np.linalg.norm(there - palm) < 0.06
    at_home = pick_point(palm + 0.15 * across, -across, CELL, {}, NONE)
    assert at_home is None or np.linalg.norm(at_home - there) > 0.05


def test_the_robot_is_measured_to_as_it_is_drawn(visitor, states, view_of, result, monkeypatch):
    asked = []
    monkeypatch.setattr(
        workbench.gui.scene.measure,
        "pick_point",
        lambda origin, direction, cell, q, points: asked.append(q) or origin,
    )
    panel = CellPanel(visitor)
    view = view_of(states.planned, Look(time=result.plan.cycle_seconds / 2))
    panel.show(None, view)
    panel._turn_measuring()
    panel._clicked(SimpleNamespace(ray_origin=(1.0, 2.0, 3.0), ray_direction=DOWN))
    for arm, moment in moments(CELL, view.runs, view.look.time).items():
        assert np.array_equal(asked[0][arm], moment.q)
    assert len(visitor.own.now.measured) == 1
    panel._clicked(SimpleNamespace(ray_origin=(1.0, 2.0, 4.0), ray_direction=DOWN))
    assert len(visitor.own.now.measured) == 2
    assert panel._clicked is None and panel._measure.label == "Measure"


def test_measuring_can_be_ended_before_the_second_point(visitor):
    panel = CellPanel(visitor)
    panel._turn_measuring()
    assert panel._clicked is not None
    panel._turn_measuring()
    assert panel._clicked is None and panel._measure.label == "Measure"


def test_a_distance_reads_with_its_parts():
    first, second = np.array([0.1, 0.2, 0.3]), np.array([0.1, 0.23, 0.26])
    assert measured_text(first, second) == "50.0 mm\nx +0.0  y +30.0  z -40.0 mm"
    assert "50.0 mm: x +0.0" in measured_line((first, second))
    assert measured_line((first,)) == ""


@pytest.fixture(scope="module")
def reached():
    return reach_map(CELL, CELL.arms[0])


def test_places_that_are_reached_lie_around_the_arm(reached):
    places, shares = reached
    assert len(places) > 500 and len(shares) == len(places)
    assert np.all((shares > 0) & (shares <= 1))
    foot = chain_of(CELL, CELL.arms[0]).p[0]
    assert np.linalg.norm(places - foot, axis=1).max() < 1.0
    middle = CELL.bin.T_world_bin.translation
    assert np.linalg.norm(places - middle, axis=1).min() < 0.08


def test_the_arm_on_the_other_side_reaches_the_other_side(reached):
    right, left = reached[0], reach_map(CELL, CELL.arms[1])[0]
    assert right[:, 1].mean() < 0 < left[:, 1].mean()


def test_a_reach_is_found_once_and_remembered():
    found = threading.Event()
    reaches = Reaches(found.set)
    assert reaches.of(CELL, "") is NO_REACH
    assert reaches.of(CELL, "right") is NO_REACH
    assert found.wait(PATIENCE)
    first = reaches.of(CELL, "right")
    assert len(first[0]) > 500 and reaches.of(CELL, "right") is first
    reaches.close()


def test_a_reach_that_cannot_be_found_is_told_and_not_awaited_for_ever(monkeypatch, caplog):
    def broken(cell, arm, *, cancelled):
        raise ValueError("no limits")

    monkeypatch.setattr(workbench.gui.drawing.reach, "reach_map", broken)
    found = threading.Event()
    reaches = Reaches(found.set)
    reaches.of(CELL, "right")
    assert found.wait(PATIENCE)
    told = reach_line("right", reaches.of(CELL, "right"))
    assert "cannot be computed" in told and "could not be found" in caplog.text
    reaches.close()


def test_a_reach_says_that_it_is_worked_out_and_what_its_colours_mean(reached):
    assert reach_line("", NO_REACH) == ""
    assert "Computing the reach of the right arm" in reach_line("right", NO_REACH)
    assert "Green: " in reach_line("right", reached)
    assert "reaches nowhere" in reach_line("right", (np.zeros((0, 3)), np.zeros(0)))
