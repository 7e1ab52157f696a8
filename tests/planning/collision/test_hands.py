"""What hands do to the part that they take, looked at in one go and pair by pair."""

import coal
import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.planning.collision.bodies import coal_shape, tool_shapes
from workbench.planning.collision.hands import NO_PAIR, cut_of, hands_of


def cut_pair_by_pair(tool, pieces, T_part_tcp, opening, press):
    for number, one in enumerate(tool_shapes(tool)):
        T = one.at(tool, T_part_tcp, opening)
        for piece, solid in enumerate(pieces):
            T_piece = solid.T_owner_shape
            distance = coal.distance(
                one.geometry,
                coal.Transform3s(T.rotation, T.translation),
                coal_shape(solid.shape),
                coal.Transform3s(T_piece.rotation, T_piece.translation),
                coal.DistanceRequest(),
                coal.DistanceResult(),
            )
            if distance < -press:
                return number * len(pieces) + piece
    return NO_PAIR


@pytest.mark.parametrize("cell_name", ["yumi", "tx2_90"])
def test_the_first_cut_is_that_of_looking_at_every_pair(cell_name):
    cell, rng = read_cell(cell_name), np.random.default_rng(4)
    tool, pieces = cell.arms[0].tool, cell.parts[0].pieces
    found = []
    for _ in range(300):
        q = rng.normal(size=4)
        T = pin.SE3(pin.Quaternion(q / np.linalg.norm(q)).toRotationMatrix(), rng.normal(size=3))
        T.translation *= 0.05
        opening, press = rng.uniform(*tool.stroke), float(rng.choice([0.0, tool.press]))
        found.append(cut_of(tool, pieces, T, opening, press, 0.005))
        assert found[-1] == cut_pair_by_pair(tool, pieces, T, opening, press)
    assert NO_PAIR in found and len(set(found)) > 2


def test_arms_with_one_tool_share_what_its_hands_do():
    cell = read_cell("yumi")
    first, second = (
        hands_of(arm.tool, cell.parts[0].pieces, cell.parts[0].grasps, None, 0.005, 0.001)
        for arm in cell.arms
    )
    assert first is second
