"""Parts dropped into a bin and left to settle: how they come to lie in production."""

from collections.abc import Sequence
from copy import copy
from functools import lru_cache
from operator import mul

import mujoco
import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import parts_in_turn
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.parts import PileText
from workbench.model.part import Bin, Part
from workbench.model.scan import Detection
from workbench.perception.simulation.physics import (
    TIMESTEP,
    advance,
    come_to_rest,
    model_of,
    poses_of,
)
from workbench.perception.simulation.room import (
    around_frame,
    check_room,
    kinds_of,
    radius_of,
)
from workbench.perception.simulation.unloading import is_in_bin

BETWEEN_DROPS = 0.35
"""[s] of simulated time."""

ATTEMPTS = 10

OUTSIDE = 0.001
"""[m] How far a part may reach into a wall or the floor (contacts yield a little)."""


def pile_of(cell: Cell, kind: str, count: int, *, seed: int) -> tuple[Detection, ...]:
    """Parts that fell into the cell's bin; see `parts_in_turn`.

    Raises:
        InputError: the cell has no part, or none of that kind; or they do not fit.
    """
    return drop_parts(parts_in_turn(cell, kind, count), cell.bin, seed=seed)


def drop_parts(parts: Sequence[Part], bin: Bin, *, seed: int) -> tuple[Detection, ...]:
    """Where parts come to lie that fall into the bin one after another.

    MuJoCo simulates them as unions of their convex pieces.  They start in random attitudes at
    places spread over the bin.  When a part ends up outside, all is repeated with a seed
    derived from the given one.  From a bin without walls parts may roll off, time and again: then
    the most that have stayed are all there are.

    Args:
        parts: what falls, in this order, a part as often as it falls; its `pieces` give the
            shape and its `mass` the inertia.
        bin: where to.
        seed: the same seed gives the same poses on the same machine.

    Returns:
        The truth: the pose of each part that is in the bin, in the order in which they fell.

    Raises:
        InputError: a part that does not fit, or too many for the bin.
    """
    if not parts:
        return ()
    check_room(parts, bin)
    kinds = {id(part): around_frame(part) for part in parts}
    falling = [kinds[id(part)][0] for part in parts]
    Ts_falling_part = [kinds[id(part)][1].inverse() for part in parts]
    count, radius = len(parts), max(map(radius_of, falling))
    model = copy(_model(tuple(falling), bin))
    most: tuple[Detection, ...] = ()
    for attempt in range(ATTEMPTS):
        generator = np.random.default_rng([seed, attempt])
        Ts_bin_falling = _settle(model, _starts(bin, count, radius, generator), radius)
        Ts_bin_part = map(mul, Ts_bin_falling, Ts_falling_part)
        fallen = zip(parts, Ts_bin_part, strict=True)
        stay = tuple(
            Detection(part.name, bin.T_world_bin * T) for part, T in fallen if _stays(bin, part, T)
        )
        if len(stay) == count:
            return stay
        most = max(most, stay, key=len)
    if most and not bin.has_walls:
        return most
    raise InputError(
        PileText.FALLEN_OUT(count=len(parts), parts=kinds_of(parts), attempts=ATTEMPTS)
    )


@lru_cache(maxsize=4)
def _model(parts: tuple[Part, ...], bin: Bin) -> mujoco.MjModel:
    """The same parts fall again and again, and compiling takes as long as a part falls."""
    return model_of(parts, bin)


def _starts(
    bin: Bin, count: int, radius: float, generator: np.random.Generator
) -> list[tuple[Floats, Floats]]:
    """Place over the bin (2,) [m] and attitude (quaternion w x y z) of each part.

    The bin is divided into cells, one at least for each part, so that the parts spread.
    """
    room = np.maximum(bin.size[:2] / 2 - radius, 0.0)
    columns = max(1, round(np.sqrt(count * bin.size[0] / bin.size[1])))
    cells = np.array([columns, -(-count // columns)])
    chosen = generator.permutation(cells.prod())[:count]
    corner = np.stack(np.unravel_index(chosen, cells), axis=1)
    places = ((corner + generator.random((count, 2))) / cells * 2 - 1) * room
    attitudes = generator.standard_normal((count, 4))
    attitudes /= np.linalg.norm(attitudes, axis=1, keepdims=True)
    return list(zip(places, attitudes, strict=True))


def _settle(
    model: mujoco.MjModel, starts: list[tuple[Floats, Floats]], radius: float
) -> list[pin.SE3]:
    """Let the parts fall one after another; T_bin_part when all lie still."""
    data = mujoco.MjData(model)
    model.body_gravcomp[1:] = 1.0
    state = data.qpos.reshape(len(starts), 7)
    for number in range(len(starts)):  # waiting, weightless, far above each other
        state[number, :3] = (0.0, 0.0, 10.0 + 3.0 * radius * number)
    for number, (place, attitude) in enumerate(starts):
        top = state[:number, 2].max(initial=0.0)
        state[number, :2] = place
        state[number, 2] = top + (2.1 if number else 1.1) * radius
        state[number, 3:] = attitude
        data.qvel[6 * number : 6 * number + 6] = 0.0
        model.body_gravcomp[number + 1] = 0.0
        advance(model, data, round(BETWEEN_DROPS / TIMESTEP))
    come_to_rest(model, data, radius)
    return poses_of(data)


def _stays(bin: Bin, part: Part, T_bin_part: pin.SE3) -> bool:
    """Whether a part that fell has come to lie in the bin; over the edge of a surface it may."""
    if bin.has_walls:
        return _is_inside(part.mesh.points, T_bin_part, bin)
    return is_in_bin(bin, part, bin.T_world_bin * T_bin_part)


def _is_inside(points: Floats, T_bin_part: pin.SE3, bin: Bin) -> bool:
    """Whether all of the part's points (n, 3) [m] are between the walls and above the floor."""
    p_bin = points @ T_bin_part.rotation.T + T_bin_part.translation
    across = np.abs(p_bin[:, :2]).max(axis=0)
    return bool(np.all(across <= bin.size[:2] / 2 + OUTSIDE) and p_bin[:, 2].min() >= -OUTSIDE)
