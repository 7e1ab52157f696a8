"""Random tool poses in a bin, as the thesis drew them, and what an arm can make of each."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm
from workbench.model.geometry import Floats, Ints, pose_from_rpy
from workbench.model.part import Bin
from workbench.planning.collision.world import World
from workbench.planning.kinematics.inverse import configurations

TILT = np.deg2rad(20.0)
"""[rad] The tool points straight down except for up to this turn about y, to either side."""

IK_STARTS = 24
"""Starting points of the inverse kinematics for each target."""

Outcome = Literal["clear", "out of reach", "in collision"]


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """A tool pose and, when it can be taken up without touching anything, the configuration for it.

    `q` is (n,) [rad]: of several configurations the one with the least joint travel from home.
    """

    T_world_tcp: pin.SE3
    outcome: Outcome
    q: Floats | None


def drawn_poses(bin: Bin, count: int, seed: int) -> list[pin.SE3]:
    """Tool poses anywhere in the bin: z down, up to `TILT` about y, any turn about z."""
    rng = np.random.default_rng(seed)
    poses: list[pin.SE3] = []
    for _ in range(count):
        p_bin = (rng.random(3) - (0.5, 0.5, 0.0)) * np.asarray(bin.size)
        tilt, turn = rng.uniform(-TILT, TILT), rng.uniform(-np.pi, np.pi)
        down = pose_from_rpy((0, 0, 0), (np.pi, 0, 0))
        T_bin_tcp = pin.SE3(np.eye(3), p_bin) * pose_from_rpy((0, 0, 0), (0, 0, turn)) * down
        poses.append(bin.T_world_bin * T_bin_tcp * pose_from_rpy((0, 0, 0), (0, tilt, 0)))
    return poses


def judge_targets(
    world: World, arm: Arm, poses: Sequence[pin.SE3], seed: int, among: Ints | None = None
) -> list[Target]:
    """What an arm can make of each pose; the other arms stand at home.

    Args:
        world: in the phase that counts.
        arm: one of its arms.
        poses: of its TCP in the world.
        seed: of the starting points of the inverse kinematics.
        among: (k,) indices of the pairs of the world that count; all when None.
    """
    starts = starts_of(world, arm, seed)
    return [looked_at(world, arm, T, starts, among)[0] for T in poses]


def starts_of(world: World, arm: Arm, seed: int) -> Floats:
    """Where the inverse kinematics begins, (s, n) [rad], home first."""
    chain = world.chains[arm.name]
    rng = np.random.default_rng([seed, 1])
    return np.vstack(
        [arm.home, rng.uniform(chain.lower, chain.upper, (IK_STARTS - 1, len(arm.home)))]
    )


def looked_at(
    world: World, arm: Arm, T_world_tcp: pin.SE3, starts: Floats, among: Ints | None = None
) -> tuple[Target, float]:
    """What an arm can make of one pose, and how far [m] its hand stays away from it at best.

    `starts` (s, n) [rad] are those of the inverse kinematics, `among` (k,) as in `judged`.
    """
    answers = configurations(world.chains[arm.name], T_world_tcp, starts)
    solutions = [world.motion.rounded(q) for q in answers.q]
    clear = [
        q for q in solutions if world.contact(world.configuration({arm.name: q}), among) is None
    ]
    clear.sort(key=lambda q: float(np.abs(q - arm.home).sum()))
    outcome: Outcome = "clear" if clear else "in collision" if solutions else "out of reach"
    away = 0.0 if solutions else float(answers.away[0])
    return Target(T_world_tcp, outcome, clear[0] if clear else None), away
