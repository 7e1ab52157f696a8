"""How far an arm of a cell gets: from home, into its bin, to its places."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Bin, Cell
from workbench.model.geometry import pose_from_rpy
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.pairing import Phase
from workbench.planning.collision.world import World
from workbench.studies.targets import Target, judged

GRID = (5, 5, 3)
"""Tool poses along the bin's length, width and depth."""

TURNS = (0.0, np.pi / 4, np.pi / 2, 3 * np.pi / 4)
"""[rad] About the vertical, each at every place of the grid."""


@dataclass(frozen=True, slots=True, eq=False)
class Reach:
    """What one arm can do.

    `at_home` is what it touches at home, None when it is clear; `bin` are tool poses in the bin,
    pointing straight down, `places` those where it may release a part.
    """

    arm: str
    at_home: Contact | None
    bin: tuple[Target, ...]
    places: tuple[Target, ...]


def reach_of(cell: Cell, arm: Arm, *, seed: int = 0) -> Reach:
    """Look at home, bin and places of one arm, the others standing at home.

    Args:
        cell: without parts in its bin.
        arm: one of its arms.
        seed: of the starting points of the inverse kinematics.
    """
    world = World(cell, ())
    moving, opened = frozenset({arm.name}), {arm.name: arm.tool.stroke[1]}
    world.enter(Phase(moving, opened))
    at_home = world.contact(world.configuration({}))
    world.enter(Phase(moving, opened, straight=moving))
    bin_targets = judged(world, arm, down_poses(cell.bin), seed)
    places = judged(world, arm, list(arm.Ts_world_place), seed)
    return Reach(arm.name, at_home, tuple(bin_targets), tuple(places))


def down_poses(bin: Bin) -> list[pin.SE3]:
    """Tool poses over a grid in the bin, clear of walls and floor by a sixth of its sizes."""
    shares = [(np.arange(count) + 0.5) / count for count in GRID]
    length, width, height = bin.size
    poses: list[pin.SE3] = []
    for x in (shares[0] - 0.5) * length:
        for y in (shares[1] - 0.5) * width:
            for z in shares[2] * height:
                for turn in TURNS:
                    T_bin_tcp = pose_from_rpy((x, y, z), (np.pi, 0.0, turn))
                    poses.append(bin.T_world_bin * T_bin_tcp)
    return poses
