"""Parts let go of one after another at their places: where physics has them come to rest."""

from collections.abc import Sequence
from dataclasses import replace

import mujoco
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.by_bin import barriers
from workbench.model.part import Part
from workbench.perception.simulation.physics import (
    TIMESTEP,
    advance,
    come_to_rest,
    model_of,
    poses_of,
)
from workbench.perception.simulation.room import radius_of

BETWEEN = 0.5
"""[s] of simulated time until the next part is let go of."""

AFTER = 2.0
"""[s] of simulated time that a whole stack stands before it is checked."""

AWAY = 50.0
"""[m] Parts that are still to come wait so high, weightless."""


def let_go(cell: Cell, parts: Sequence[tuple[Part, pin.SE3]]) -> tuple[pin.SE3, ...]:
    """Where parts lie in the end that are let go of among the fixtures of a cell: `T_world_part`.

    The hand is left out.

    Args:
        cell: its bin and fixtures stand still.
        parts: each with where it is let go of, `T_world_part`, one after the other.
    """
    T_bin_world = cell.bin.T_world_bin.inverse()
    around = [
        replace(solid, T_owner_shape=T_bin_world * fixture.T_world_fixture * solid.T_owner_shape)
        for fixture in barriers(cell)
        for solid in fixture.solids
    ]
    kinds = [part for part, _ in parts]
    model, radius = model_of(kinds, cell.bin, around=around), max(map(radius_of, kinds))
    data = mujoco.MjData(model)
    state = data.qpos.reshape(len(parts), 7)
    for number in range(len(parts)):
        state[number, :3] = (0.0, 0.0, AWAY + 3.0 * radius * number)
    for number, (_, T_world_part) in enumerate(parts):
        T = T_bin_world * T_world_part
        turn = pin.Quaternion(T.rotation)
        state[number, :3] = T.translation
        state[number, 3:] = (turn.w, turn.x, turn.y, turn.z)
        data.qvel[6 * number : 6 * number + 6] = 0.0
        model.body_gravcomp[number + 1] = 0.0
        advance(model, data, round(BETWEEN / TIMESTEP))
    advance(model, data, round(AFTER / TIMESTEP))
    come_to_rest(model, data, radius)
    return tuple(cell.bin.T_world_bin * T for T in poses_of(data))
