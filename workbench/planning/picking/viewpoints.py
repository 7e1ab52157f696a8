"""Where an arm can hold something into the scanner's view: poses that differ as much as can be."""

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.inverse import configurations

TILT = np.deg2rad(30.0)
"""[rad] Largest tilt of the tool from straight down."""

LOWEST, HIGHEST = 0.12, 0.26
"""[m] Height of what is shown above the rim of the bin."""

ASIDE = 0.03
"""[m] Largest distance of what is shown from the scanner's axis, where nothing else is wanted."""

TRIES = 40
"""Poses that are tried for each one that is wanted."""

STARTS = 16
"""Starting points of the inverse kinematics, beside home."""


def sample_showing_configurations(
    cell: Cell, arm: Arm, T_tcp_shown: pin.SE3, count: int, *, seed: int, aside: float = ASIDE
) -> tuple[Floats, ...]:
    """Configurations in which an arm holds something near the scanner's axis, above the bin.

    Whether the scanner sees it is not checked.

    The other arms stand at home, fingers are closed, and everything keeps the policy's margin.  The
    turns of the tool are as different as those that were found allow.

    Args:
        cell: with bin and scanner; the scanner looks into the bin.
        arm: that moves.
        T_tcp_shown: what is shown, in the frame of the arm's TCP.
        count: how many are wanted; fewer come when the arm cannot.
        seed: of the poses that are tried.
        aside: [m] largest distance of what is shown from the scanner's axis, along two others.

    Returns:
        Configurations (n,) [rad].
    """
    rng, world = np.random.default_rng(seed), World(cell, ())
    world.enter(LegPhase(frozenset(each_arm.name for each_arm in cell.arms)))
    chain = world.chains[arm.name]
    found: list[tuple[Floats, Floats]] = []
    for _ in range(count * TRIES):
        T_world_tcp = _draw_pose(cell, rng, aside) * T_tcp_shown.inverse()
        starts = np.vstack(
            [arm.home, rng.uniform(chain.lower, chain.upper, (STARTS, len(arm.home)))]
        )
        answers = configurations(chain, T_world_tcp, starts).q
        # Nearest to home first: that is how a person would go there.
        for q in answers[np.argsort(np.abs(answers - arm.home).max(axis=1), kind="stable")]:
            if world.contact(world.configuration({arm.name: q})) is None:
                found.append((q, T_world_tcp.rotation))
                break
        if len(found) >= 4 * count:
            break
    return _spread(found, count)


def _draw_pose(cell: Cell, rng: np.random.Generator, aside: float) -> pin.SE3:
    """A pose above the bin for what is shown, z downwards except for the tilt."""
    T, axis = cell.bin.T_world_bin, cell.scanner.T_world_scanner
    height = float(cell.bin.size[2]) + rng.uniform(LOWEST, HIGHEST)
    above = T.act(np.array([0.0, 0.0, height]))
    # On the scanner's axis, at that height.
    forward = axis.rotation[:, 2]
    along = float(forward @ (above - axis.translation))
    centre = axis.translation + along * forward
    centre = centre + axis.rotation[:, :2] @ rng.uniform(-aside, aside, 2)
    lean, yaw, tilt = rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi), rng.uniform(0, TILT)
    turn = pin.exp3(tilt * np.array([np.cos(lean), np.sin(lean), 0.0]))
    return pin.SE3(turn @ pin.rpy.rpyToMatrix(np.pi, 0.0, yaw), centre)


def _spread(found: list[tuple[Floats, Floats]], count: int) -> tuple[Floats, ...]:
    """Those whose rotations differ most: each next one is the furthest from those taken."""
    if not found:
        return ()
    taken = [0]
    while len(taken) < min(count, len(found)):
        nearest = [
            min(float(np.linalg.norm(pin.log3(found[k][1].T @ R))) for k in taken) for _, R in found
        ]
        taken.append(int(np.argmax(nearest)))
    return tuple(found[k][0] for k in taken)
