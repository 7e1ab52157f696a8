"""Which part is taken first: orders by name, each a cost of a pick; the least comes first."""

from collections.abc import Callable, Mapping

import numpy as np

from workbench.model.candidate import Pick
from workbench.model.cell import OrderName
from workbench.model.geometry import Floats
from workbench.planning.collision.world import World

Cost = Callable[[Pick], float]

OTHER_SIDE = 1.0
"""[m] Cost of an arm that reaches over to the other side: more than any bin is wide."""


def cost_of(world: World, order: OrderName) -> Cost:
    """The cost of taking a pick's part first, by an order's name."""
    return lambda pick: _COSTS[order](world, pick)


def _p_bin(world: World, pick: Pick) -> Floats:
    """Where the part lies in the bin's frame, shape (3,) [m]."""
    T_world_part = world.detections[pick.candidate.detection].T_world_part
    return np.asarray(world.cell.bin.T_world_bin.actInv(T_world_part).translation)


def _travel(world: World, pick: Pick) -> float:
    return pick.seconds


def _highest(world: World, pick: Pick) -> float:
    return -float(_p_bin(world, pick)[2])


def _score(world: World, pick: Pick) -> float:
    return -world.detections[pick.candidate.detection].score


def _nearest(world: World, pick: Pick) -> float:
    return pick.candidate.rank


def _far_from_walls(world: World, pick: Pick) -> float:
    """Minus the distance [m] to the nearest wall: the part farthest from walls comes first."""
    return -float((np.asarray(world.cell.bin.size[:2]) / 2 - np.abs(_p_bin(world, pick)[:2])).min())


def _thesis(world: World, pick: Pick) -> float:
    """Each arm takes what lies on its side; the one farther from the bin's middle goes first."""
    arm = world.arm(pick.candidate.arm)
    p_bin = _p_bin(world, pick)
    T_world_home = world.chains[arm.name].pose(np.asarray(arm.home))
    own = world.cell.bin.T_world_bin.actInv(T_world_home).translation[1]
    reaches_over = len(world.cell.arms) > 1 and own * p_bin[1] < 0
    return OTHER_SIDE * reaches_over - float(np.linalg.norm(p_bin[:2]))


_COSTS: Mapping[OrderName, Callable[[World, Pick], float]] = {
    "travel": _travel,
    "highest": _highest,
    "score": _score,
    "nearest": _nearest,
    "walls": _far_from_walls,
    "thesis": _thesis,
}
