"""The place that a plan brings its part to, by its number."""

from dataclasses import replace

import pinocchio as pin
import pytest
from prepared_bench import make_results

from workbench.model.derived.place_of_plan import place_number
from workbench.model.part import PartPlace


@pytest.fixture(scope="module")
def planned():
    made = make_results()
    return made.cell, made.planned.plan


def with_places(cell, **fields):
    return replace(cell, arms=tuple(replace(arm, **fields) for arm in cell.arms))


def released(cell, arm_plan):
    """Where the hand is when it lets go: TCP and part, in the world."""
    leg = [leg for leg in arm_plan.legs if leg.holding][-1]
    values = dict(zip(arm_plan.joints, map(float, leg.q[-1]), strict=True))
    arm = cell.arm(arm_plan.arm)
    T = cell.T_world_robot * cell.robot.link_poses(values)[arm.flange] * arm.tool.T_flange_tcp
    return T, T * arm_plan.T_tcp_part


def test_the_place_is_counted_in_the_order_of_the_cell(planned):
    cell, plan = planned
    away = pin.SE3(pin.utils.rotate("z", 0.0), pin.utils.zero(3) + 0.3)
    for arm_plan in plan.arms:
        T_tcp, T_part = released(cell, arm_plan)
        there, elsewhere = PartPlace(T_part), PartPlace(away * T_part)
        for of_tool, of_parts, number in (
            ((T_tcp,), (), 1),
            ((away * T_tcp, T_tcp), (), 2),
            ((away * T_tcp,), (elsewhere, there), 3),
            ((), (there, elsewhere), 1),
            ((), (), 0),
        ):
            at = with_places(cell, Ts_world_place=of_tool, part_places=of_parts)
            assert place_number(at, arm_plan) == number


def test_a_station_is_no_place(planned):
    cell, plan = planned
    assert place_number(cell, replace(plan.arms[0], station="turn")) == 0
    for arm_plan in plan.arms:
        assert place_number(cell, arm_plan) in range(
            1, len(cell.arm(arm_plan.arm).Ts_world_place) + 1
        )
