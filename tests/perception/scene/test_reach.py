"""Nothing that a robot carries leaves the ball that is said to hold it."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.perception.scene.reach import reach
from workbench.planning.kinematics.robot import Kinematics


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_hands_and_links_stay_within_the_reach(name):
    cell = read_cell(name)
    kinematics, radius = Kinematics(cell), reach(cell)
    foot = cell.T_world_robot.translation
    draw, farthest = np.random.default_rng(0), 0.0
    for _ in range(300):
        q = {}
        for arm in cell.arms:
            lower, upper, _ = cell.robot.limits(arm.joints)
            q |= dict(zip(arm.joints, draw.uniform(lower, upper), strict=True))
        poses = kinematics.link_poses(q)
        tips = [(poses[arm.flange] * arm.tool.T_flange_tcp).translation for arm in cell.arms]
        away = [np.linalg.norm(p - foot) for p in (*tips, *(T.translation for T in poses.values()))]
        farthest = max(farthest, *away)
    assert farthest < radius < 3 * farthest


def test_a_longer_tool_reaches_further():
    cell = read_cell("tx2_90")
    arm = cell.arms[0]
    longer = replace(arm.tool, T_flange_tcp=pose_from_rpy((0, 0, 1.3)))
    other = replace(cell, arms=(replace(arm, tool=longer),))
    assert reach(other) == pytest.approx(reach(cell) + 1.0, abs=0.02)
