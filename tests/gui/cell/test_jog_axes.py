"""The sliders of jogging: axes as the controller counts them, where it couples them too."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.runtime.live import Live
from workbench.gui.cell.jogging import JogControls
from workbench.gui.shared.look import View
from workbench.model.derived.controller_axes import shown_axes
from workbench.model.robot import AxisMapping

COUPLED = np.eye(7)
COUPLED[2, 1] = -1.0


@pytest.fixture
def coupled(bench):
    """The first arm, whose controller counts its third axis with the second one."""
    cell = bench.state.cell
    arm = replace(cell.arms[0], mapping=AxisMapping(COUPLED, np.zeros(7)))
    bench.do(ChangeCell(replace(cell, arms=(arm, *cell.arms[1:])), "counted otherwise"), "Ada")
    return arm


def slide(controls, arm, axis, value):
    """A person moves one slider; all of them as they are shown after it."""
    slider = controls._axes[arm.name][axis]
    slider.value = value
    controls._slid(arm.name, SimpleNamespace(client=object(), target=slider))


def shown(controls, arm):
    return np.array([slider.value for slider in controls._axes[arm.name]])


def test_a_slider_moves_what_the_controller_shows_and_nothing_else_of_it(bench, visitor, coupled):
    controls = JogControls(visitor)
    controls._turn()
    home = shown_axes(bench.state.cell, coupled, coupled.home)
    np.testing.assert_allclose(shown(controls, coupled), home, atol=0.051)
    slide(controls, coupled, 1, home[1] + 5.0)
    q = visitor.own.now.jog[coupled.name]
    after = shown_axes(bench.state.cell, coupled, q)
    np.testing.assert_allclose(after - home, [0, 5, 0, 0, 0, 0, 0], atol=1e-9)
    np.testing.assert_allclose(np.rad2deg(q - coupled.home)[[1, 2]].max(), 5.0, atol=0.001)


def test_where_a_joint_is_at_its_limit_the_sliders_show_where_the_arm_is(bench, visitor, coupled):
    controls = JogControls(visitor)
    controls._turn()
    controls.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0, own=visitor.own.now))
    most = controls._axes[coupled.name][2].max
    slide(controls, coupled, 2, most)
    controls.show(None, View(bench.state, Live(), visitor.look.now, (), 0.0, own=visitor.own.now))
    q = visitor.own.now.jog[coupled.name]
    there = shown_axes(bench.state.cell, coupled, q)
    assert there[2] < most - 1.0, "the second axis stands where the third one cannot go so far"
    np.testing.assert_allclose(shown(controls, coupled), there, atol=0.051)
