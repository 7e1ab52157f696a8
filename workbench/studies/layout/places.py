"""Where the arms of a first cell put parts: a tray beside the bin for each."""

from dataclasses import replace
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell, Fixture
from workbench.model.geometry import Box, Solid, pose_from_rpy
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.studies.layout.homes import VERTICAL_TURNS, side_of
from workbench.studies.targets import judge_targets

DROP = 0.02
"""[m] A part is let go of this far above a tray."""


def with_places(cell: Cell) -> Cell:
    """The cell with a tray beside the bin for each arm that reaches one."""
    arms: list[Arm] = []
    fixtures = list(cell.fixtures)
    for arm in cell.arms:
        found = _place(cell, arm)
        if found is None:
            arms.append(arm)
            continue
        places, top = found
        arms.append(replace(arm, Ts_world_place=places))
        tray = Solid("tray_top", Box(np.array([0.16, 0.16, 0.01])), pose_from_rpy((0, 0, -0.005)))
        fixtures.append(Fixture(f"tray_{arm.name}", top, (tray,)))
    return replace(cell, arms=tuple(arms), fixtures=tuple(fixtures))


def _place(cell: Cell, arm: Arm) -> tuple[tuple[pin.SE3, ...], pin.SE3] | None:
    """Poses where the arm can release a part, one turned four ways, and the tray's top."""
    world = World(cell, ())
    moving = frozenset({arm.name})
    world.enter(LegPhase(moving, straight=moving))
    _, width, _ = cell.bin.size
    for gap, x, height in product((0.15, 0.2, 0.28), (0.0, -0.1, 0.1), (0.08, 0.15)):
        p = np.array([x, side_of(cell, arm) * (width / 2 + gap), height])
        poses = [
            cell.bin.T_world_bin * pose_from_rpy(p, (np.pi, 0, turn)) for turn in VERTICAL_TURNS
        ]
        targets = judge_targets(world, arm, poses, 0)
        clear = tuple(target.T_world_tcp for target in targets if target.q is not None)
        if clear:
            top = cell.bin.T_world_bin * pose_from_rpy(p - [0, 0, 2 * DROP])
            return clear, top
    return None
