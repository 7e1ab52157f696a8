"""A pile after one part is lifted out of it: its neighbours move."""

import math
from collections.abc import Sequence
from itertools import pairwise

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.part import Bin, Part
from workbench.model.scan import Detection
from workbench.perception.simulation.physics import (
    TIMESTEP,
    advance,
    come_to_rest,
    model_of,
    poses_of,
)
from workbench.perception.simulation.room import around_frame, radius_of

LIFT_SPEED = 0.25
"""[m/s] At which a part is lifted; pushed parts move more at higher speeds."""

LIFT = 0.2
"""[m] Straight up, of a part that is taken out of a pile."""

SAME_PART = 0.03
"""[m] A part whose frame lies this near to where a scan has shown one is the same."""

LEAST_SECONDS = 0.2
"""[s] Shortest duration of a lift."""

NO_SLIP = 10
"""Iterations of MuJoCo's search for forces without slip.  Without them parts that lean on others
creep, until one topples that nobody has touched."""


def unloaded(
    cell: Cell, pile: Sequence[Detection], taken: int, way: Sequence[pin.SE3]
) -> tuple[Detection, ...]:
    """The other parts of a pile, at rest again after one was lifted out.

    The part follows its way whatever is in it; the others are pushed, tip over and fall as MuJoCo
    has it.  The hand is not there: plans keep it away from them.

    Args:
        cell: whose bin and parts.
        pile: how the parts lie, at rest.
        taken: the number in it of the part that is lifted.
        way: poses of that part in the world, from where it lies on.

    Returns:
        All but the taken one, in their order.
    """
    parts = [cell.part(detection.part) for detection in pile]
    T_bin_world = cell.bin.T_world_bin.inverse()
    others = [number for number in range(len(pile)) if number != taken]
    if not others:
        return ()
    kinds = {id(part): around_frame(part) for part in parts}
    parts, Ts_part_frame = zip(*(kinds[id(part)] for part in parts), strict=True)
    model = model_of(parts, cell.bin, carried=taken, no_slip=NO_SLIP)
    model.body_gravcomp[1:] = 0.0
    data = mujoco.MjData(model)
    state = data.qpos.reshape(-1, 7)
    for row, number in enumerate(others):
        state[row] = place_and_turn(T_bin_world * pile[number].T_world_part * Ts_part_frame[number])
    for T in _evenly([T * Ts_part_frame[taken] for T in way]):
        data.mocap_pos[0], data.mocap_quat[0] = np.split(place_and_turn(T_bin_world * T), [3])
        advance(model, data)
    # What is out of the bin for good must not hold up those that fall.
    data.mocap_pos[0] = (0.0, 0.0, 10.0)
    come_to_rest(model, data, max(map(radius_of, parts)))
    return tuple(
        Detection(pile[number].part, cell.bin.T_world_bin * T * Ts_part_frame[number].inverse())
        for number, T in zip(others, poses_of(data), strict=True)
    )


def left_of(
    cell: Cell, pile: Sequence[Detection], lifted: Sequence[pin.SE3]
) -> tuple[Detection, ...]:
    """What is left of a pile once parts were lifted out, one after the other, at rest again.

    Args:
        cell: whose bin and parts.
        pile: how the parts lie, at rest.
        lifted: `T_world_part` of each that was taken, as a scan has shown it; where no part lies
            near enough, nothing is taken.
    """
    rest = tuple(pile)
    for T in lifted:
        away = [math.dist(part.T_world_part.translation, T.translation) for part in rest]
        if not away or min(away) > SAME_PART:
            continue
        taken = int(np.argmin(away))
        start = rest[taken].T_world_part
        end = pin.SE3(start.rotation, start.translation + np.array([0.0, 0.0, LIFT]))
        rest = unloaded(cell, rest, taken, (start, end))
    return rest


def is_in_bin(bin: Bin, part: Part, T_world_part: pin.SE3) -> bool:
    """Whether a part is still in the bin: its middle is between the sides and above the floor.

    Its frame may be at an edge, which sinks into the floor a little as it lies there.
    """
    x, y, z = bin.T_world_bin.actInv(T_world_part).act(part.mesh.middle)
    length, width, _ = bin.size
    return bool(abs(x) <= length / 2 and abs(y) <= width / 2 and z >= 0.0)


def place_and_turn(T: pin.SE3) -> np.ndarray:
    """Place (3) [m] and quaternion w, x, y, z as MuJoCo has them, (7,)."""
    quaternion = pin.Quaternion(T.rotation)
    place = T.translation
    return np.array([*place, quaternion.w, quaternion.x, quaternion.y, quaternion.z])


def _evenly(way: Sequence[pin.SE3]) -> list[pin.SE3]:
    """Poses along a way, one a time step, at `LIFT_SPEED`."""
    found: list[pin.SE3] = []
    lengths = [float(np.linalg.norm(b.translation - a.translation)) for a, b in pairwise(way)]
    seconds = max(sum(lengths) / LIFT_SPEED, LEAST_SECONDS)
    for a, b, length in zip(way, way[1:], lengths, strict=False):
        share = length / sum(lengths) if sum(lengths) else 1.0 / len(lengths)
        count = max(1, round(seconds * share / TIMESTEP))
        found += [pin.SE3.Interpolate(a, b, k / count) for k in range(1, count + 1)]
    return found
