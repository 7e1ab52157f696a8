"""What becomes of the parts in a bin as a hand goes through them: they are pushed, tip and fall."""

from collections.abc import Sequence
from itertools import pairwise

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats, Solid
from workbench.model.scan import Detection
from workbench.perception.simulation.physics import (
    TIMESTEP,
    advance,
    come_to_rest,
    model_of,
    poses_of,
)
from workbench.perception.simulation.room import around_frame, radius_of
from workbench.perception.simulation.unloading import NO_SLIP, place_and_turn

AWAY = np.array([0.0, 0.0, 10.0])
"""[m] Where the hand is once it has left the bin."""


def stirred(
    cell: Cell,
    pile: Sequence[Detection],
    hand: Sequence[Solid],
    way: Sequence[pin.SE3],
    times: Floats,
) -> list[tuple[Detection, ...]]:
    """How the parts lie while a hand goes through them, and afterwards.

    The hand follows its way whatever is in it.

    Args:
        cell: whose bin and parts.
        pile: how the parts lie, at rest.
        hand: its solids, in its own frame.
        way: (m) poses of that frame in the world.
        times: (m,) [s] when the hand passes them.

    Returns:
        All parts in their order, m times: as the hand passes each pose; last, at rest again.
    """
    T_bin_world = cell.bin.T_world_bin.inverse()
    around = [around_frame(cell.part(detection.part)) for detection in pile]
    parts, Ts_part_frame = zip(*around, strict=True)
    model = model_of(parts, cell.bin, no_slip=NO_SLIP, hand=hand)
    model.body_gravcomp[1:] = 0.0
    data = mujoco.MjData(model)
    state = data.qpos.reshape(-1, 7)
    for row, (detection, T_part_frame) in enumerate(zip(pile, Ts_part_frame, strict=True)):
        state[row] = place_and_turn(T_bin_world * detection.T_world_part * T_part_frame)

    def lying() -> tuple[Detection, ...]:
        return tuple(
            Detection(detection.part, cell.bin.T_world_bin * T * T_part_frame.inverse())
            for detection, T, T_part_frame in zip(pile, poses_of(data), Ts_part_frame, strict=True)
        )

    found = [tuple(pile)]
    for (T_a, t_a), (T_b, t_b) in pairwise(zip(way, times, strict=True)):
        count = max(1, round((t_b - t_a) / TIMESTEP))
        for k in range(1, count + 1):
            T = T_bin_world * pin.SE3.Interpolate(T_a, T_b, k / count)
            data.mocap_pos[0], data.mocap_quat[0] = np.split(place_and_turn(T), [3])
            advance(model, data)
        found.append(lying())
    data.mocap_pos[0] = AWAY
    come_to_rest(model, data, max(map(radius_of, parts)))
    return [*found[:-1], lying()]
