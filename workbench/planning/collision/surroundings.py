"""The surroundings of arms, tools and parts in a scan, computed once and shared."""

from collections.abc import Iterator, Sequence

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.assembling import assembled_kinds, insertion_of, rest_pose
from workbench.model.derived.by_bin import barriers
from workbench.model.geometry import Bools, Box, Floats, Shape, Solid
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.around import Around
from workbench.planning.collision.bodies import (
    Body,
    BodyKind,
    boxes_of,
    extent,
    obstacle_label,
    part_label,
)
from workbench.planning.collision.distances.cores import cores_of
from workbench.planning.collision.unknown_rolls import room_of


class Surroundings:
    """What no arm carries: bin, fixtures, parts found, obstacles seen, in this order.

    `pieces` are the solids that count for each detection (`room_of`), `bodies` everything that is
    there, and `boxes` the same for compiled code.  `owner` (b,) is the number of the part that a
    body belongs to, -1 for others.

    Lifetime: as long as cell and detections; it never changes.
    """

    def __init__(
        self, cell: Cell, detections: tuple[Detection, ...], obstacles: tuple[Obstacle, ...] = ()
    ) -> None:
        self.cell = cell
        self.detections = detections
        self.pieces = tuple(
            room_of(cell.part(detection.part), detection) for detection in detections
        )
        # The bin first: where several things are met, that one is named.
        self.bodies = tuple(
            [*_of_cell(cell), *_of_parts(detections, self.pieces), *_of_obstacles(cell, obstacles)]
        )
        self.boxes = boxes_of(self.bodies)
        self.owner = np.array(
            [int(body.owner) if body.kind == "part" else -1 for body in self.bodies]
        )

    def bases_of(self, number: int) -> Bools:
        """Which bodies (b,), no unit, are of the part that one found comes onto in an assembly."""
        insertion = insertion_of(self.cell, self.detections[number].part)
        if insertion is None:
            return np.zeros(len(self.bodies), bool)
        base = ("assembled", insertion.base)
        return np.array([(body.kind, body.owner) == base for body in self.bodies], bool)

    def around(self, moving: Sequence[tuple[Shape, pin.SE3, Floats]]) -> Around:
        """The same around solids that move together, for compiled code.

        Args:
            moving: shapes with their poses in a common frame, and where each goes (3,), no unit,
                as fingers open.
        """
        shapes = [*(shape for shape, _, _ in moving), *(body.shape for body in self.bodies)]
        extents = [extent(shape) for shape in shapes]
        own = extents[: len(moving)]
        return Around(
            np.array([T.rotation for _, T, _ in moving]),
            np.array([T.act(e[0]) for (_, T, _), e in zip(moving, own, strict=True)]),
            np.array([way for _, _, way in moving]),
            np.array([half for _, half, _ in own]),
            np.array([radius for _, _, radius in own]),
            self.boxes.R,
            self.boxes.c,
            self.boxes.half,
            self.owner,
            cores_of(shapes, np.array([centre for centre, _, _ in extents])),
        )

    def gaps(self, p: Floats) -> Floats:
        """How far a point (3,) [m] is from the box around each body (b,) [m]; 0 inside."""
        offset = np.einsum("gji,gj->gi", self.boxes.R, p - self.boxes.c)
        return np.linalg.norm(np.maximum(np.abs(offset) - self.boxes.half, 0.0), axis=1)


def _of_cell(cell: Cell) -> Iterator[Body]:
    for solid in cell.bin.solids:
        yield _still(solid, cell.bin.T_world_bin, "bin", "bin", solid.name)
    for fixture in barriers(cell):
        for solid in fixture.solids:
            yield _still(solid, fixture.T_world_fixture, "fixture", fixture.name, solid.name)


def _of_parts(detections: Sequence[Detection], pieces: Sequence[Sequence[Solid]]) -> Iterator[Body]:
    for number, (detection, solids) in enumerate(zip(detections, pieces, strict=True)):
        for solid in solids:
            yield _still(solid, detection.T_world_part, "part", str(number), part_label(number))


def _of_obstacles(cell: Cell, obstacles: Sequence[Obstacle]) -> Iterator[Body]:
    assembled = assembled_kinds(cell)
    for number, obstacle in enumerate(obstacles):
        if (kind := obstacle.part) in assembled:
            T_world_part = rest_pose(cell, obstacle)
            for solid in cell.part(kind).pieces:
                yield _still(solid, T_world_part, "assembled", kind, kind)
            continue
        label = obstacle_label(number)
        yield Body(label, "fixture", "seen", -1, 0, obstacle.T_world_box, Box(obstacle.size))


def _still(solid: Solid, T_world_owner: pin.SE3, kind: BodyKind, owner: str, label: str) -> Body:
    return Body(label, kind, owner, -1, 0, T_world_owner * solid.T_owner_shape, solid.shape)
