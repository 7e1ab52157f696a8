"""From where on the scanner sees past the arms: looked at densely, by code that shares nothing."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.sightlines import CLEAR_OF_VIEW, seconds_seen, sees_from
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.kinematics.chain import chain_of


@pytest.fixture(scope="module")
def cell():
    found = read_cell("yumi")
    return replace(found, scanner=replace(found.scanner, while_moving=True))


@pytest.fixture(scope="module")
def plan(cell):
    pile = drop_parts([cell.parts[0]] * 2, cell.bin, seed=1)
    result = plan_pick(cell, pile, "", strategy="alternated")
    assert result.plan is not None and len(result.plan.arms) == 2
    return result.plan


def tool_tips(cell, plan, first):
    """Where the TCP of each moving arm is, many times in each step from `first` on, (n, 3) [m]."""
    for step in plan.sequence[first - 1 :]:
        for name, leg_name in step.runs:
            leg, chain = plan.arm(name).leg(leg_name), chain_of(cell, cell.arm(name))
            for t in np.linspace(0.0, leg.seconds, 40):
                yield chain.pose(leg.at(t)).translation


def is_seen(mount, p):
    x, y, z = mount.T_world_scanner.actInv(p)
    half = z * np.tan(mount.field_of_view / 2)
    columns, rows = mount.resolution
    return 0 < z < mount.far and abs(x) < half and abs(y) < half * rows / columns


def test_no_tool_is_in_the_picture_from_there_on_and_one_was_before(cell, plan):
    first = sees_from(cell, plan)
    assert 1 < first <= len(plan.sequence)
    assert not any(is_seen(cell.scanner, p) for p in tool_tips(cell, plan, first))
    assert any(is_seen(cell.scanner, p) for p in tool_tips(cell, plan, 1))
    after = [leg for step in plan.sequence[first - 1 :] for _, leg in step.runs]
    assert not {"reach", "approach", "extract"} & set(after)
    assert 1.0 < seconds_seen(plan, first) < plan.cycle_seconds
    assert seconds_seen(plan, 0) == 0.0


def test_a_scanner_that_waits_sees_from_nowhere(cell, plan):
    assert sees_from(replace(cell, scanner=replace(cell.scanner, while_moving=False)), plan) == 0


@pytest.mark.parametrize("arm", ["right", "left"])
def test_an_arm_at_home_in_the_picture_hides_all(cell, plan, arm):
    """The scanner hangs over where an arm stands when all is done."""
    home = chain_of(cell, cell.arm(arm)).pose(np.asarray(cell.arm(arm).home)).translation
    there = pose_from_rpy((*home[:2], 0.9), (np.pi, 0.0, 0.0))
    assert sees_from(_with_scanner(cell, there), plan) == 0


def test_room_is_kept_to_what_is_seen(cell, plan):
    """A wider view sees less; one that ends just beside a tool's way does not count as free."""
    first = sees_from(cell, plan)
    mount = cell.scanner
    away = []
    for p in tool_tips(cell, plan, first):
        x, y, z = mount.T_world_scanner.actInv(p)
        away.append(np.arctan2(abs(x), z) if abs(y) < abs(x) else np.inf)
    widest = min(min(away), 1.2)
    wider = replace(mount, field_of_view=2 * float(widest) - CLEAR_OF_VIEW)
    later = sees_from(replace(cell, scanner=wider), plan)
    assert later == 0 or later > first


def _with_scanner(cell, T_world_scanner: pin.SE3):
    return replace(cell, scanner=replace(cell.scanner, T_world_scanner=T_world_scanner))
