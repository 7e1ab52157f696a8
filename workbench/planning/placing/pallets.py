"""Pallets in layers: which of their places may take a part now."""

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import Part, PartPlace
from workbench.model.scan import Obstacle
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World

TOLERANCE_SLACK = 0.0005
"""[m] How much farther than the tolerance a part may be from its place: rounding, and the like."""


def open_places(
    world: World, arm: Arm, number: int, phase: LegPhase | None = None
) -> tuple[PartPlace, ...]:
    """The places of an arm where a part found may be put now, in the order in which they are tried.

    Of a pallet in layers those are the places without a part in the lowest layer that is not full;
    unless a part lies in a layer above.

    Args:
        world: whose obstacles say what lies on pallets.
        arm: that brings the part.
        number: of the detection.
        phase: parts that other arms have placed in it are in the way; nothing is put onto them,
            since nobody has seen yet whether they are there.
    """
    places = arm.places_for(world.detections[number].part)
    if not any(place.pallet for place in places):
        return places
    sure = _find_sure(arm, world.cell.parts, tuple(world.obstacles))
    put = _find_filled(arm, () if phase is None else _just_put(world, phase))
    return tuple(place for place in places if _is_open(arm, place, sure, put))


def why_full(world: World, arm: Arm, number: int) -> Verdict:
    """That no place for a part found is open."""
    places = arm.places_for(world.detections[number].part)
    count = len(_find_sure(arm, world.cell.parts, tuple(world.obstacles)) & set(places))
    note = VerdictNote.PALLETS_FULL(arm=arm.name, places=len(places))
    if count < len(places):
        note = VerdictNote.PALLETS_CLOSED(arm=arm.name, places=len(places), taken=count)
    return Verdict(Reason.NO_PLACE, Stage.PLACE, note=note)


def _find_filled(arm: Arm, parts: Iterable[tuple[Part, pin.SE3]]) -> frozenset[PartPlace]:
    """The places of pallets in layers of an arm at which some parts lie."""
    found: set[PartPlace] = set()
    pallets = [place for place in arm.part_places if place.pallet]
    for part, T in parts:
        near = [(_off(place, part, T), place) for place in pallets if place.is_for(part.name)]
        off, nearest = min(near, key=lambda nearby: nearby[0], default=(np.inf, None))
        if nearest is not None and off <= TOLERANCE_SLACK:
            found.add(nearest)
    return frozenset(found)


# It is asked of every candidate.
@lru_cache(maxsize=8)
def _find_sure(
    arm: Arm, parts: tuple[Part, ...], obstacles: tuple[Obstacle, ...]
) -> frozenset[PartPlace]:
    """The places at which a part surely lies."""
    kinds = {part.name: part for part in parts}
    return _find_filled(
        arm,
        [
            (kinds[obstacle.part], obstacle.T_world_put)
            for obstacle in obstacles
            if obstacle.part in kinds and obstacle.T_world_put is not None
        ],
    )


def _is_open(
    arm: Arm, place: PartPlace, sure: frozenset[PartPlace], put: frozenset[PartPlace]
) -> bool:
    if not place.pallet:
        return True
    others = [part_place for part_place in arm.part_places if part_place.pallet == place.pallet]
    return (
        place not in sure | put
        and not any(
            part_place in sure | put for part_place in others if part_place.layer > place.layer
        )
        and all(part_place in sure for part_place in others if part_place.layer == place.layer - 1)
    )


def _just_put(world: World, phase: LegPhase) -> list[tuple[Part, pin.SE3]]:
    return [
        (world.cell.part(world.detections[number].part), world.chains[arm].pose(q) * T_tcp_part)
        for arm, (number, T_tcp_part, q) in phase.placed.items()
    ]


def _off(place: PartPlace, part: Part, T_world_part: pin.SE3) -> float:
    """How far [m] beyond its tolerances a part is from a place; how it is turned does not count.

    What no turn of a symmetry moves is compared: it stays on its circle about z of the place.
    """
    point = np.array(part.symmetry.point)
    off = place.T_world_part.actInv(T_world_part).act(point)
    around = float(np.hypot(*off[:2]) - np.hypot(*point[:2]))
    beside = around if place.free_rotation > 0 else float(np.hypot(*(off - point)[:2]))
    lever = place.turn_tolerance * float(np.linalg.norm(point))
    return float(np.hypot(beside, off[2] - point[2])) - place.tolerance - lever
