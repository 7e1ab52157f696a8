"""Where the arms of a first cell stand between plans: above the bin, and to the arm's side."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import Chain, chain_of
from workbench.planning.kinematics.inverse import configurations

VERTICAL_TURNS = (0.0, np.pi / 2, np.pi / 4, -np.pi / 4)
"""[rad] About the vertical, of a tool at home and at its places."""

IK_STARTS = 60
AWAY, UP = (0.6, 0.9, 0.3, 0.0), (0.25, 0.15, 0.35, 0.1, 0.07)
"""Half widths to the arm's side of the bin's middle, and [m] above its rim; an arm whose only way
up is an axis of 150 mm gets no higher than the last."""

MOST_ELBOWS = 24
"""Configurations of an arm that are tried where the next arm finds none that is clear of it."""

SAME_SIDE = 0.02
"""[m] Arms whose feet differ by less stand on one column."""

SAME_HEIGHT = 0.01
"""[m] Elbows that differ by less are as high."""


def with_homes(cell: Cell) -> Cell | None:
    """The cell with homes above the bin's rim, tools down, clear of each other; None: no such."""
    for away, up in product(AWAY, UP):
        homes = _homes(cell, away, up)
        if homes is not None:
            arms = zip(cell.arms, homes, strict=True)
            return replace(cell, arms=tuple(replace(arm, home=home) for arm, home in arms))
    return None


def side_of(cell: Cell, arm: Arm) -> float:
    """-1 or 1: on which side of the bin's middle, along its y, an arm works."""
    if len(cell.arms) == 1:
        return -1.0
    T_bin_world = cell.bin.T_world_bin.inverse()
    feet = {o.name: float(T_bin_world.act(chain_of(cell, o).p[0])[1]) for o in cell.arms}
    # Of arms on one column the first works at the first side, so that they part.
    first = min(feet, key=lambda name: round(feet[name] / SAME_SIDE))
    return -1.0 if arm.name == first else 1.0


def _nearest_to_zero(q: Floats, lower: Floats, upper: Floats, slides: Floats) -> Floats:
    """The same configuration (n,) [rad, m] with each joint as near to zero as whole turns bring it.

    `lower`, `upper` and `slides` (n,) are those of a `Chain`: slides, marked by 1, have no turns.
    """
    turns = np.round(q / (2 * np.pi)) * (slides < 0.5)
    nearer = q - 2 * np.pi * turns
    # A joint whose range is not around zero may come only so near.
    for _ in range(4):
        nearer = np.where(nearer < lower, nearer + 2 * np.pi * (slides < 0.5), nearer)
        nearer = np.where(nearer > upper, nearer - 2 * np.pi * (slides < 0.5), nearer)
    is_inside = (nearer >= lower) & (nearer <= upper)
    return np.where(is_inside, nearer, q)


def _homes(cell: Cell, away: float, up: float) -> list[Floats] | None:
    """One clear configuration for each arm, the least awkward one."""
    world = World(cell, ())
    world.enter(LegPhase(frozenset(arm.name for arm in cell.arms)))
    answers = [_answers(cell, arm, world.chains[arm.name], away, up) for arm in cell.arms]
    return _clear_together(world, cell.arms, answers, {})


def _clear_together(
    world: World, arms: Sequence[Arm], answers: Sequence[list[Floats]], homes: Mapping[str, Floats]
) -> list[Floats] | None:
    """The first configurations of `arms` with which they are clear of all, and of `homes`."""
    if not arms:
        return list(homes.values())
    arm, is_last, tried = arms[0], len(arms) == 1, 0
    among = None if is_last else world.pairs.alone(arm.name)
    for q in map(world.motion.rounded, answers[0]):
        if world.contact(world.configuration({**homes, arm.name: q}), among) is not None:
            continue
        found = _clear_together(world, arms[1:], answers[1:], {**homes, arm.name: q})
        tried += 1
        if found is not None or tried == MOST_ELBOWS:
            return found
    return None


def _answers(cell: Cell, arm: Arm, chain: Chain, away: float, up: float) -> list[Floats]:
    """Configurations (n,) with the tool down above the bin, the least awkward first."""
    p = np.array([0.0, side_of(cell, arm) * away * cell.bin.size[1] / 2, cell.bin.size[2] + up])
    rng = np.random.default_rng(0)
    starts = rng.uniform(chain.lower, chain.upper, (IK_STARTS, len(arm.joints)))
    answers: list[Floats] = []
    for turn in VERTICAL_TURNS:
        T = cell.bin.T_world_bin * pose_from_rpy(p, (np.pi, 0, turn))
        answers += list(configurations(chain, T, starts).q)
    return _order(chain, answers)


def _order(chain: Chain, answers: Iterable[Floats]) -> list[Floats]:
    """Configurations (n,) far from the limits first, then with the elbow high, then near zero."""
    near = [_nearest_to_zero(q, chain.lower, chain.upper, chain.slides) for q in answers]
    return sorted(near, key=lambda q: _awkwardness(chain, q))


def _awkwardness(chain: Chain, q: Floats) -> tuple[bool, float, float]:
    middle, half = (chain.lower + chain.upper) / 2, (chain.upper - chain.lower) / 2
    is_near_limit = bool(np.abs((q - middle) / half).max() > 0.9)
    height = float(chain.joint_positions(q)[:, 2].mean())
    return is_near_limit, -round(height / SAME_HEIGHT) * SAME_HEIGHT, float(np.abs(q).sum())
