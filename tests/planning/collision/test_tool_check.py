"""The tool alone in the bin: many hands at once, and each by itself."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh, pose_from_rpy
from workbench.model.scan import Obstacle
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.collision.legs import grips
from workbench.planning.collision.tool_check import Hand, ToolCheck


def hands_at(cell, pile, arm):
    """Every grasp of every part by every grip, open and closed, with the pose of the hand."""
    for number, one in enumerate(pile):
        for grasp in cell.part(one.part).grasps:
            for grip, T_tcp_hand in enumerate(grips(arm, grasp)):
                T = one.T_world_part * grasp.T_part_tcp * T_tcp_hand
                if arm.tool.fingers:
                    yield T, Hand(number, grasp, grip, grasp.opening, 0.0)
                yield T, Hand(number, grasp, grip, grasp.grip, arm.tool.press)


def both_ways(cell, pile, arm, obstacles=()):
    check = ToolCheck(cell, pile, obstacles)
    Ts, hands = zip(*hands_at(cell, pile, arm), strict=True)
    at_once = check.contacts(arm, Ts, hands)
    told = [
        None if pair is None else check.told(arm, T, hand.opening, pair)
        for T, hand, pair in zip(Ts, hands, at_once, strict=True)
    ]
    by_one = [
        check.contact(arm, T, hand.opening, hand.target, hand.press)
        for T, hand in zip(Ts, hands, strict=True)
    ]
    return told, by_one


@pytest.mark.parametrize(
    ("cell_name", "kinds", "seed"),
    [
        ("yumi", ("keyed_cylinder",) * 9, 4),
        ("yumi", ("bracket", "bolt") * 4, 5),
        ("tx2_90", ("puck",) * 9, 6),
    ],
)
def test_many_hands_at_once_meet_what_each_meets_by_itself(cell_name, kinds, seed):
    parts = {name: read_part(name) for name in kinds}
    cell = replace(read_cell(cell_name), parts=tuple(parts.values()))
    pile = drop_parts(tuple(parts[name] for name in kinds), cell.bin, seed=seed)
    box = Obstacle(cell.bin.T_world_bin * pose_from_rpy((0.03, 0.02, 0.04)), np.full(3, 0.02))
    for arm in cell.arms:
        told, by_one = both_ways(cell, pile, arm, (box,))
        assert told == by_one
        assert None in told and any(one is not None for one in told)


def test_a_body_that_is_not_convex_is_measured_one_by_one():
    cell = read_cell("yumi")
    pile = drop_parts(cell.parts[:1] * 3, cell.bin, seed=2)
    # A tray of two triangles, above the bin: no compiled code knows it.
    points = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]]) * 0.05
    flat = Mesh(points, np.array([[0, 1, 2], [0, 2, 3]]), is_convex=False)
    solid = replace(cell.fixtures[0].solids[0], shape=flat, T_owner_shape=pose_from_rpy((0, 0, 0)))
    lid = replace(
        cell.fixtures[0],
        solids=(solid,),
        T_world_fixture=cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.06)),
    )
    cell = replace(cell, fixtures=(lid,))
    told, by_one = both_ways(cell, pile, cell.arms[0])
    assert told == by_one
    assert any(one is not None and one[0][1] == solid.name for one in told)


def test_no_hands_meet_nothing():
    cell = read_cell("yumi")
    assert ToolCheck(cell, ()).contacts(cell.arms[0], [], []) == []
