"""A part alone, moved along straight ways out of the bin: which of them are free, whoever holds it.

The way of a part does not depend on the grasp, so where a neighbour lies on it, or leans on it, no
grasp has to be tried.
"""

from collections.abc import Sequence
from itertools import combinations

import coal
import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.bodies import coal_shape, extent, still_bodies
from workbench.planning.collision.gjk import cores_of
from workbench.planning.collision.hands import NOTHING, Around, first_contacts
from workbench.planning.collision.world import World

STEP = 0.004
"""[m] Parts are looked at so far apart on their way."""


class PartWays:
    """The parts found, and what stands around each of them.

    Lifetime: as long as cell and detections.
    """

    def __init__(
        self, cell: Cell, detections: tuple[Detection, ...], obstacles: tuple[Obstacle, ...] = ()
    ) -> None:
        self._detections = detections
        self._pieces = [cell.part(one.part).pieces for one in detections]
        self._release = cell.policy.release
        self._still = still_bodies(cell, detections, obstacles)
        self._around: dict[int, Around] = {}

    def blocked(self, number: int, ways: Sequence[Floats]) -> list[tuple[str, float] | None]:
        """For each way (3,) [m] in the world: what a part meets on it and after how much [m].

        None where it meets nothing.  Only what is touched counts, and only once the part has
        come off what it lies on: the first `release` of the policy is left out.

        Args:
            number: of the detection.
            ways: straight, from where it lies.
        """
        around = self._of(number)
        if not ways or not around.cores.known.all():
            return [None] * len(ways)
        T = self._detections[number].T_world_part
        lengths = [float(np.linalg.norm(way)) for way in ways]
        far = [np.append(np.arange(self._release, most, STEP), most) for most in lengths]
        places = [
            T.translation + s[:, None] * way / most
            for s, way, most in zip(far, ways, lengths, strict=True)
        ]
        p = np.ascontiguousarray(np.vstack(places))
        R = np.ascontiguousarray(np.broadcast_to(T.rotation, (len(p), 3, 3)))
        met = first_contacts(R, p, number, 0.0, around)
        found: list[tuple[str, float] | None] = []
        first = 0
        for s in far:
            mine = met[first : first + len(s)]
            hits = np.flatnonzero(mine != NOTHING)
            first += len(s)
            if len(hits) == 0:
                found.append(None)
                continue
            body = self._still[int(mine[hits[0]]) % len(self._still)]
            found.append((body.label, float(s[hits[0]])))
        return found

    def standing_in(self, number: int, T_world_part: pin.SE3, margin: float) -> str | None:
        """What a part, put elsewhere, is nearer to than the margin [m]; None where nothing.

        Other parts found do not count: they may be gone by then.
        """
        around = self._of(number)
        if not around.cores.known.all():
            return None
        fixed = around._replace(owner=np.where(around.owner < 0, around.owner, number))
        R, p = np.array(T_world_part.rotation)[None], np.array(T_world_part.translation)[None]
        (code,) = first_contacts(R, p, number, margin, fixed)
        return None if code == NOTHING else self._still[int(code) % len(self._still)].label

    def _of(self, number: int) -> Around:
        if number not in self._around:
            self._around[number] = self._surroundings(number)
        return self._around[number]

    def _surroundings(self, number: int) -> Around:
        pieces, still = self._pieces[number], self._still
        shapes = [solid.shape for solid in pieces] + [body.shape for body in still]
        extents = [extent(shape) for shape in shapes]
        centres = np.array([e[0] for e in extents])
        poses = [body.T_joint_body for body in still]
        count = len(pieces)
        return Around(
            np.array([solid.T_owner_shape.rotation for solid in pieces]),
            np.array(
                [
                    solid.T_owner_shape.act(centre)
                    for solid, centre in zip(pieces, centres[:count], strict=True)
                ]
            ),
            np.zeros((count, 3)),
            np.array([e[1] for e in extents[:count]]),
            np.array([e[2] for e in extents[:count]]),
            np.array([T.rotation for T in poses]),
            np.array([T.act(c) for T, c in zip(poses, centres[count:], strict=True)]),
            np.array([e[1] for e in extents[count:]]),
            np.array([int(b.owner) if b.kind == "part" else -1 for b in still]),
            cores_of(shapes, centres),
        )


def heaps(world: World, gap: float) -> list[int]:
    """For each part found the number of its heap: parts nearer than `gap` [m] are of one.

    When a part is taken, others of its heap may move, also those that it does not touch itself.
    """
    count = len(world.detections)
    radius = {part.name: float(np.linalg.norm(part.mesh.points, axis=1).max())
              for part in world.cell.parts}  # fmt: skip
    heap = list(range(count))
    for first, second in combinations(range(count), 2):
        one, other = world.detections[first], world.detections[second]
        if heap[first] == heap[second]:
            continue
        far = float(np.linalg.norm(one.T_world_part.translation - other.T_world_part.translation))
        if far - radius[one.part] - radius[other.part] >= gap:
            continue
        if part_gap(world, first, second) < gap:
            old, new = heap[second], heap[first]
            heap = [new if number == old else number for number in heap]
    return heap


def part_gap(world: World, first: int, second: int) -> float:
    """How near two parts lie to each other [m], negative where they reach into each other."""
    one, other = (
        [
            (coal_shape(solid.shape), found.T_world_part * solid.T_owner_shape)
            for solid in world.cell.part(found.part).pieces
        ]
        for found in (world.detections[first], world.detections[second])
    )
    request = coal.DistanceRequest()
    return min(
        coal.distance(
            a,
            coal.Transform3s(T.rotation, T.translation),
            b,
            coal.Transform3s(U.rotation, U.translation),
            request,
            coal.DistanceResult(),
        )
        for a, T in one
        for b, U in other
    )
