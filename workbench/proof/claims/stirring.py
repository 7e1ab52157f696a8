"""What the proof asks of a plan by which a hand stirs the parts in the bin.

No scan shows where parts are once they were pushed.  So two boxes stand for all that lies in the
bin: one up to the highest part that the scan shows, and one above it for a part that comes to stand
upright there (`scene.filled_bin`).  On the leg `stir` the tool of the arm may be in both, and the
rest of that arm in the upper one.  On all other legs, and for everything else, both are in the way;
the tool keeps its margin to all but the boxes.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_bin import part_beside_bin
from workbench.model.geometry import Box, Floats
from workbench.model.messages.message import FoundPart
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.proof.claims.scene import filled_bin, scene_bodies, turned_rooms
from workbench.proof.claims.table import ABOVE_CONTENT, CONTENT
from workbench.proof.claims.tolerances import OPENING
from workbench.proof.engine.bodies import CheckedBody
from workbench.proof.engine.robot import Tree

LEAST_HEIGHT = 0.001
"""[m] How high the content of a bin counts at least."""

SEEN_IN_WALL = 0.003
"""[m] By how much a thing may seem to stand in a wall that it only touches: a scan is not exact."""


@dataclass(frozen=True, slots=True, eq=False)
class Content:
    """What lies in the bin: a box as `high` [m] as the scan shows it, and one above that.

    `others` are the obstacles that do not lie in the bin.
    """

    high: float
    boxes: tuple[Obstacle, Obstacle]
    others: tuple[Obstacle, ...]

    @property
    def top(self) -> float:
        """How high [m] both boxes reach above the bin's floor."""
        return self.high + float(self.boxes[1].size[2])


def content_of(cell: Cell, scene: Scene) -> Content:
    """The boxes that stand for all that lies in the bin of a scene, and for parts over its walls.

    An obstacle lies in the bin if it is wholly between the walls, to `SEEN_IN_WALL`.  It may be no
    higher than the rim, or a part upright on the highest one.
    """
    kinds = [part.name for part in cell.parts]
    parts = [_extent_of_part(cell, found) for found in scene.detections]
    highest = max((float(extent[2]) for extent in parts), default=0.0)
    rim = max(float(cell.bin.size[2]), float(filled_bin(cell, highest, kinds).size[2]))
    room = np.array([*(cell.bin.size[:2] / 2 + SEEN_IN_WALL), rim])
    inside: list[Floats] = []
    others: list[Obstacle] = []
    for seen in scene.obstacles:
        extent = _extent(cell.bin.T_world_bin.actInv(seen.T_world_box), seen.size / 2)
        if seen.part or np.any(extent > room):
            others.append(seen)
        else:
            inside.append(extent)
    least = np.array([0.0, 0.0, LEAST_HEIGHT])
    width, depth, high = np.max([least, *parts, *inside], axis=0)
    whole = filled_bin(cell, float(high), kinds)
    floor = np.maximum(whole.size[:2], (2 * width, 2 * depth))
    boxes = (
        _slice(cell, floor, 0.0, float(high)),
        _slice(cell, floor, float(high), float(whole.size[2])),
    )
    return Content(float(high), boxes, tuple(others))


def unseen_content(cell: Cell, scene: Scene) -> Content:
    """The boxes that stand for all that lies in a bin that no scan shows: it is full to the rim."""
    kinds, high = [part.name for part in cell.parts], float(cell.bin.size[2])
    whole = filled_bin(cell, high, kinds)
    boxes = (
        _slice(cell, whole.size[:2], 0.0, high),
        _slice(cell, whole.size[:2], high, float(whole.size[2])),
    )
    return Content(high, boxes, scene.obstacles)


def _slice(cell: Cell, floor: Floats, low: float, high: float) -> Obstacle:
    """A box over a part `floor` (2,) [m] of the bin, between two heights [m] above its floor."""
    T_bin_box = pin.SE3(np.eye(3), np.array([0.0, 0.0, (low + high) / 2]))
    return Obstacle(cell.bin.T_world_bin * T_bin_box, np.array([*floor, high - low]))


def bodies_of(cell: Cell, tree: Tree, plan: Plan) -> tuple[CheckedBody, ...]:
    """All that has a shape while a plan runs.

    Where a hand stirs, or drops back what it holds, boxes stand instead of the parts.
    """
    if not (plan.is_stir_plan or plan.is_drop_plan):
        return scene_bodies(cell, tree, plan.scene)
    content = (unseen_content if plan.is_drop_plan else content_of)(cell, plan.scene)
    rest = scene_bodies(cell, tree, Scene(plan.scan_digest, (), content.others))
    boxes = [
        CheckedBody("still", label, "still", "", -1, 0, box.T_world_box, Box(box.size))
        for label, box in zip((CONTENT, ABOVE_CONTENT), content.boxes, strict=True)
    ]
    return (*rest, *boxes)


def stir_violations(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a plan does nothing else, with a hand that is as open as the robot link can say."""
    arm = cell.arm(arm_plan.arm)
    if len(plan.arms) > 1 or arm_plan.grasp or arm_plan.station:
        yield Violation(ProofText.NOT_ONLY_STIR(), arm.name)
    if not cell.bin.has_walls:
        yield Violation(ProofText.NO_WALLS(), arm.name)
    if (number := part_beside_bin(cell, plan.detections)) is not None:
        yield Violation(ProofText.BESIDE_BIN(part=FoundPart(number)), arm.name)
    opening = _opening(cell, arm)
    for leg in arm_plan.legs:
        if arm.tool.fingers and not abs(leg.opening - opening) <= OPENING:
            yield Violation(ProofText.STIR_OPENING(opening=opening), arm.name, leg.name)


def _opening(cell: Cell, arm: Arm) -> float:
    """How far open [m] the hand is: closed, or wide where the robot link says nothing of it."""
    return arm.tool.stroke[0 if cell.controller.motion.takes_openings else 1]


def _extent_of_part(cell: Cell, found: Detection) -> Floats:
    """As `_extent`, at any turn where the roll of the part is not known."""
    part, T_bin_world = cell.part(found.part), cell.bin.T_world_bin.inverse()
    if found.roll_known:
        T = T_bin_world * found.T_world_part
        points = np.asarray(part.mesh.points) @ T.rotation.T + T.translation
        return np.array([*np.abs(points[:, :2]).max(axis=0), points[:, 2].max()])
    rooms = [
        _extent(T_bin_world * T, np.array([room.radius, room.radius, room.length / 2]))
        for room, T in turned_rooms(part, found)
    ]
    return np.max(rooms, axis=0)


def _extent(T_bin_box: pin.SE3, half: Floats) -> Floats:
    """How far a box (3,) [m] of half that size reaches: to the sides of the middle, and up."""
    middle, reach = T_bin_box.translation, np.abs(T_bin_box.rotation) @ half
    return np.array([*(np.abs(middle[:2]) + reach[:2]), middle[2] + reach[2]])
