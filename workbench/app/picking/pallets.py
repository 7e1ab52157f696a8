"""Placed parts as obstacles, and how full pallets are."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby, pairwise

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.derived.assembling import rest_pose
from workbench.model.errors import InputError
from workbench.model.geometry import Box
from workbench.model.messages.message import Message
from workbench.model.messages.parts import PalletText
from workbench.model.part import Part, PartPlace
from workbench.model.scan import Detection, Obstacle
from workbench.proof.claims.places.layers import (
    FALL,
    SEARCHED_BELOW,
    fall,
    kept_box,
    place_at,
    standing_problem,
)
from workbench.proof.claims.scene import turned_pieces
from workbench.proof.engine.shapes import gap_of


def boxes_around(cell: Cell, placed: Sequence[Detection]) -> tuple[Obstacle, ...]:
    """Placed parts as obstacles, in order of placing.

    A part that a later scan shows is at its pose in the latest scan.

    Raises:
        InputError: the cell does not have one of the parts any more.
    """
    boxes: list[Obstacle] = []
    known = {part.name for part in cell.parts}
    for detection in placed:
        if detection.part not in known:
            raise InputError(PalletText.UNKNOWN_PART(part=detection.part))
        # What nothing speaks for may be there since a fault, or not: it carries no other.
        T_put = detection.T_world_part
        box = kept_box(cell, boxes, detection, T_put, is_sure=detection.score > 0)
        if detection.T_world_seen is not None:
            T_believed = rest_pose(cell, box) if box.part else T_put
            T_box = detection.T_world_seen * T_believed.actInv(box.T_world_box)
            box = replace(box, T_world_box=T_box)
        boxes.append(box)
    return tuple(boxes)


def at_rest(cell: Cell, placed: Sequence[Detection]) -> tuple[pin.SE3, ...]:
    """`T_world_part` of placed parts: as a scan shows them, or where they came to rest."""
    boxes, found = boxes_around(cell, placed), list[pin.SE3]()
    for number, (box, detection) in enumerate(zip(boxes, placed, strict=True)):
        T = (detection.T_world_seen or detection.T_world_part).copy()
        if box.part and detection.T_world_seen is None:
            T.translation -= [
                0.0,
                0.0,
                fall(cell, boxes[:number], detection, detection.T_world_part),
            ]
        found.append(T)
    return tuple(found)


@dataclass(frozen=True, slots=True)
class PalletFill:
    """How full a pallet with layers is.

    `number` counts the pallets of the `arm` from 1.  `parts` of its `places` are occupied, where
    `doubtful` parts may be missing.  `layer` is the one being filled; 0: none.
    """

    arm: str
    number: int
    parts: int
    places: int
    layer: int
    doubtful: int

    @property
    def words(self) -> tuple[Message, ...]:
        """For people, one sentence or two."""
        filled = {
            "arm": self.arm,
            "number": self.number,
            "parts": self.parts,
            "places": self.places,
        }
        text = PalletText.FULL(**filled)
        if self.layer:
            text = PalletText.FILL(**filled, layer=self.layer)
        return (text, PalletText.DOUBTFUL(count=self.doubtful)) if self.doubtful else (text,)


def pallets_of(cell: Cell, placed: Sequence[Detection]) -> tuple[PalletFill, ...]:
    """How full each pallet with layers of a cell is."""
    known = [
        detection for detection in placed if detection.part in {part.name for part in cell.parts}
    ]
    fills: list[PalletFill] = []
    for arm, number, places in _pallets(cell):
        lie = [
            (detection, place_at(arm, cell.part(detection.part), detection.T_world_part))
            for detection in known
        ]
        sure = {place for detection, place in lie if place in places and detection.score > 0}
        doubtful = {place for detection, place in lie if place in places and detection.score <= 0}
        open_layers = [place.layer for place in places if place not in sure]
        layer = min(open_layers, default=0)
        fills.append(PalletFill(arm.name, number, len(sure), len(places), layer, len(doubtful)))
    return tuple(fills)


def pallet_problems(cell: Cell) -> Iterator[Message]:
    """Problems of a cell's pallets with layers, when filled with parts of each kind."""
    for arm, number, places in _pallets(cell):
        for part in cell.parts:
            if places[0].is_for(part.name):
                problem = _problem(cell, part, places)
                if problem:
                    yield PalletText.PROBLEM(
                        arm=arm.name, number=number, part=part.name, problem=problem
                    )


def _pallets(cell: Cell) -> Iterator[tuple[Arm, int, list[PartPlace]]]:
    for arm in cell.arms:
        for number, places in groupby(arm.part_places, key=lambda place: place.pallet):
            if number:
                yield arm, number, list(places)


def _problem(cell: Cell, part: Part, places: Sequence[PartPlace]) -> Message | None:
    """The first problem when a pallet is filled with parts of a kind."""
    margin, most = cell.policy.margin, cell.policy.margin + FALL
    points = part.mesh.points @ places[0].T_world_part.rotation.T
    high = float(np.ptp(points[:, 2]))
    layers = [place.T_world_part.translation[2] for place in places]
    pitch = min((b - a for a, b in pairwise(layers) if b > a), default=0.0)
    boxes: list[Obstacle] = []
    for place in places:
        detection = Detection(part.name, place.T_world_part)
        falls = fall(cell, boxes, detection, place.T_world_part)
        if falls >= SEARCHED_BELOW:
            return PalletText.NOTHING_BENEATH(layer=place.layer, far=SEARCHED_BELOW)
        if falls > most or falls < margin:
            problem = PalletText.FALLS(layer=place.layer, falls=falls, least=margin, most=most)
            if place.layer > 1:
                return PalletText.PITCH(problem=problem, pitch=float(pitch), high=high)
            return problem
        beside = [
            gap_of(piece, (Box(box.size), box.T_world_box), 10 * margin + SEARCHED_BELOW)
            for box in boxes
            for turns in turned_pieces(part, detection)
            for piece in turns
        ]
        nearest = min(beside, default=np.inf)
        if nearest < margin:
            near = float(max(nearest, 0.0))
            return PalletText.TOO_CLOSE(layer=place.layer, near=near, margin=margin)
        if problem := standing_problem(part, place, place.T_world_part):
            return PalletText.IN_LAYER(layer=place.layer, problem=problem)
        boxes.append(kept_box(cell, boxes, detection, place.T_world_part))
    return None
