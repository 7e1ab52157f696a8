"""Where an arm can show something to the scanner, or the scanner to something that stands.

The poses differ as much as can be.
"""

from collections.abc import Callable

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell, ScannerMount
from workbench.model.geometry import Floats
from workbench.model.scan import Obstacle
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.inverse import configurations

TILT = np.deg2rad(30.0)
"""[rad] Largest tilt of the tool from straight down."""

LOWEST_POINT, HIGHEST_POINT = 0.12, 0.26
"""[m] Height of what is shown above the rim of the bin."""

ASIDE = 0.03
"""[m] Largest distance of what is shown from the scanner's axis, where nothing else is wanted."""

NEARER, FARTHER = 0.7, 1.1
"""Least and greatest distance of a scanner on an arm, over that from its view."""

RANGE_MARGIN = 0.06
"""[m] From the ends of the scanner's range, half of what is shown."""

POSES_TRIED = 40
"""Poses that are tried for each one that is wanted."""

IK_STARTS = 16
"""Starting points of the inverse kinematics, in addition to home."""


Draw = Callable[[np.random.Generator], pin.SE3]
"""Draws a pose `T_world_tcp` of the arm's TCP."""


def sample_configurations(
    cell: Cell,
    arm: Arm,
    draw: Draw,
    count: int,
    *,
    seed: int,
    obstacles: tuple[Obstacle, ...] = (),
) -> tuple[Floats, ...]:
    """Configurations in which an arm stands at poses that are drawn.

    The other arms stand at home, fingers are closed, and everything keeps the policy's margin.  The
    turns of the tool are as different as those that were found allow.

    Args:
        cell: with bin and scanner.
        arm: that moves.
        draw: poses of its TCP.
        count: how many are wanted; fewer come when the arm cannot.
        seed: of the poses that are tried.
        obstacles: what stands around besides.

    Returns:
        Configurations (n,) [rad].
    """
    rng, world = np.random.default_rng(seed), World(cell, (), obstacles)
    world.enter(LegPhase(frozenset(each_arm.name for each_arm in cell.arms)))
    chain = world.chains[arm.name]
    found: list[tuple[Floats, Floats]] = []
    for _ in range(count * POSES_TRIED):
        T_world_tcp = draw(rng)
        starts = np.vstack(
            [arm.home, rng.uniform(chain.lower, chain.upper, (IK_STARTS, len(arm.home)))]
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


def showing_poses(cell: Cell, T_tcp_shown: pin.SE3, aside: float) -> Draw:
    """Poses in which an arm holds something near the scanner's axis, above the bin.

    Its z points downwards except for a tilt.  Whether the scanner sees it is not checked.

    Args:
        cell: with bin and scanner; the scanner looks into the bin.
        T_tcp_shown: what is shown, in the frame of the arm's TCP.
        aside: [m] largest distance of what is shown from the scanner's axis, along two others.
    """
    T, axis = cell.bin.T_world_bin, cell.scanner.T_world_scanner
    forward = axis.rotation[:, 2]

    def draw(rng: np.random.Generator) -> pin.SE3:
        height = float(cell.bin.size[2]) + rng.uniform(LOWEST_POINT, HIGHEST_POINT)
        above = T.act(np.array([0.0, 0.0, height]))
        # On the scanner's axis, at that height.
        along = float(forward @ (above - axis.translation))
        centre = axis.translation + along * forward
        centre = centre + axis.rotation[:, :2] @ rng.uniform(-aside, aside, 2)
        yaw, turn = _draw_turns(rng)
        T_world_shown = pin.SE3(turn @ pin.rpy.rpyToMatrix(np.pi, 0.0, yaw), centre)
        return T_world_shown * T_tcp_shown.inverse()

    return draw


def viewing_poses(mount: ScannerMount, T_tcp_scanner: pin.SE3, shown: Floats, aside: float) -> Draw:
    """Poses in which the scanner on an arm looks at something that stands.

    It looks as from the view, except for a tilt and a turn about its axis, and from as far away.

    Args:
        mount: the scanner; the distance stays within its range.
        T_tcp_scanner: where it is, in the frame of the arm's TCP.
        shown: (3,) [m] in the world: what it looks at.
        aside: [m] largest distance of what is shown from the scanner's axis, along two others.
    """
    T_scanner_tcp, at_view = T_tcp_scanner.inverse(), mount.T_world_scanner
    away = float(np.linalg.norm(shown - at_view.translation))
    farthest = min(FARTHER * away, mount.far - RANGE_MARGIN)
    nearest = min(max(NEARER * away, mount.near + RANGE_MARGIN), farthest)

    def draw(rng: np.random.Generator) -> pin.SE3:
        distance = rng.uniform(nearest, farthest)
        centre = np.array([*rng.uniform(-aside, aside, 2), distance])
        yaw, turn = _draw_turns(rng)
        rotation = at_view.rotation @ turn @ pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
        return pin.SE3(rotation, shown - rotation @ centre) * T_scanner_tcp

    return draw


def _draw_turns(rng: np.random.Generator) -> tuple[float, Floats]:
    """A turn [rad] about the axis z, and a tilt (3, 3) of that axis."""
    lean, yaw, tilt = rng.uniform(-np.pi, np.pi), rng.uniform(-np.pi, np.pi), rng.uniform(0, TILT)
    return yaw, pin.exp3(tilt * np.array([np.cos(lean), np.sin(lean), 0.0]))


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
