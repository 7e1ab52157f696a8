"""What the tab of a plan says of loads: a line for each arm, and one where a mass is missing."""

import re
from dataclasses import replace
from html import unescape

import pytest

from workbench.gui.plan.views import plan_html
from workbench.plugins.robot_link import controller_by


def lines(state):
    found = re.findall(
        r'<div class="wb-small"[^>]*>([^<]*(?:load|mass)[^<]*)</div>', plan_html(state)
    )
    return [unescape(one) for one in found]


@pytest.fixture
def spoken_to_by(states):
    """The planned state of a cell with another robot link."""

    def made(link):
        cell = replace(states.planned.cell, controller=controller_by(link))
        return replace(states.planned, cell=cell)

    return made


def without_loads(state):
    arms = tuple(replace(one, loads=None) for one in state.plan.arms)
    return replace(state, plan=replace(state.plan, arms=arms))


def test_each_arm_has_its_load_without_and_with_the_part(states):
    assert sorted(lines(states.planned)) == [
        "left arm: load 0.23 kg, 0.35 kg with the part",
        "right arm: load 0.23 kg, 0.35 kg with the part",
    ]
    assert "centre of gravity 8, 12, 52 mm from the flange" in plan_html(states.planned)


def test_a_missing_mass_is_one_line_for_both_arms(states):
    assert lines(without_loads(states.planned)) == [
        "No load is sent: mass_g of smart_gripper is missing"
    ]


def test_a_link_that_sends_no_load_is_named_and_asks_for_no_mass(spoken_to_by):
    state = spoken_to_by("abb-socket")
    assert len(lines(state)) == 2
    assert all(one.endswith("with the part, not sent by abb-socket") for one in lines(state))
    assert lines(without_loads(state)) == []
