"""Pallets in layers: whether a part may be put there now and stands, and where it falls to."""

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.derived.assembling import assembled_kinds
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.model.messages.proofs import ProofText
from workbench.model.part import Part, PartPlace
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.proof.claims.places.placed_poses import place_offs
from workbench.proof.claims.places.standing import STEADY, centre_of_mass, stands_within
from workbench.proof.claims.scene import roll_axis, still_of, turned_pieces
from workbench.proof.claims.stages import put_at
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.shapes import gap_of

FALL = 0.003
"""[m] So much more than the margin a part may fall when it is let go of onto a pallet."""

SEARCHED_BELOW = 0.05
"""[m] Nothing that is farther beneath is searched for."""

RESTS_WITHIN = 1e-5
"""[m] A part that has come so near to something lies on it."""

SAME_FACE_WITHIN = 0.0005
"""[m] Points no farther from the highest of a part, or the lowest, are of the same face."""


def pallet_violations(
    cell: Cell, tree: Tree, scene: Scene, plan: Plan, arm_plan: ArmPlan
) -> Iterator[Violation]:
    """Whether a part that is put onto a pallet in layers may be put there now, and stands there.

    What counts is what is known to lie on the pallet: every place of the layer below has a part,
    the place itself has none, nor any of a layer above.  The part falls by little onto something,
    and its weight is within what it stands on however high the stack is by then.
    """
    if arm_plan.station:
        return
    found = plan.detections[arm_plan.detection]
    part, T_world_put = cell.part(found.part), put_at(cell, tree, plan, arm_plan)
    for arm in cell.arms:
        place = place_at(arm, part, T_world_put)
        if place is None:
            continue
        problem = occupation(cell, arm, place, scene.obstacles) or _falls_over(
            cell, scene, place, found, T_world_put
        )
        if problem is not None:
            yield Violation(problem, arm_plan.arm, "place")
            return


def place_at(arm: Arm, part: Part, T_world_put: pin.SE3) -> PartPlace | None:
    """The place of a pallet in layers at which a part lies as that asks; None for none."""
    best: tuple[float, PartPlace] | None = None
    for place in arm.part_places:
        if place.pallet and place.is_for(part.name) and _may_fill(place, part, T_world_put):
            offs = place_offs(place, part.symmetry, T_world_put)
            share = min(max(d / place.tolerance, a / place.turn_tolerance) for d, a in offs)
            if share <= 1.0 and (best is None or share < best[0]):
                best = share, place
    return None if best is None else best[1]


def _may_fill(place: PartPlace, part: Part, T_world_put: pin.SE3) -> bool:
    """Whether a closer look is worth it: a right turn leaves a symmetry's point at its height."""
    point = np.array(part.symmetry.point)
    off = place.T_world_part.actInv(T_world_put).act(point) - point
    far = place.tolerance + place.turn_tolerance * float(np.linalg.norm(point)) + 1e-6
    reach = 2 * float(np.linalg.norm(point[:2])) + far
    return bool(abs(off[2]) <= far and np.linalg.norm(off) <= reach + far)


def occupation(cell: Cell, arm: Arm, place: PartPlace, known: Sequence[Obstacle]) -> Message | None:
    """What lies at a place of a pallet and keeps it from taking a part; None for nothing."""
    names = {part.name for part in cell.parts}
    filled = [
        place_at(arm, cell.part(obstacle.part), obstacle.T_world_put)
        for obstacle in known
        if obstacle.part in names and obstacle.T_world_put is not None
    ]
    pallet = [other for other in arm.part_places if other.pallet == place.pallet]
    if any(part_place is place for part_place in filled):
        return ProofText.PLACE_TAKEN()
    above = [
        part_place.layer
        for part_place in filled
        if part_place in pallet and part_place.layer > place.layer
    ]
    if above:
        return ProofText.PART_ABOVE(layer=max(above))
    below = [other for other in pallet if other.layer == place.layer - 1]
    empty = sum(all(part_place is not other for part_place in filled) for other in below)
    if empty:
        return ProofText.LAYER_OPEN(layer=place.layer - 1, empty=empty, places=len(below))
    return None


def _falls_over(
    cell: Cell, scene: Scene, place: PartPlace, found: Detection, T_world_put: pin.SE3
) -> Message | None:
    """Why a part would not come to stand at a place of a pallet; None where it does."""
    falls = fall(cell, scene.obstacles, found, T_world_put)
    most = cell.policy.margin + FALL
    if falls >= SEARCHED_BELOW:
        return ProofText.NOTHING_BENEATH(far=SEARCHED_BELOW)
    if falls > most:
        return ProofText.RELEASED_HIGH(falls=falls, most=most)
    return standing_problem(cell.part(found.part), place, T_world_put)


def standing_problem(part: Part, place: PartPlace, T_world_put: pin.SE3) -> Message | None:
    """Why a part would not stay as it stands at a place of a pallet; None where it does."""
    centre = centre_of_mass(part)
    if centre is None:
        return ProofText.NO_WEIGHT()
    points = part.mesh.points @ T_world_put.rotation.T + T_world_put.translation
    low, high = float(points[:, 2].min()), float(points[:, 2].max())
    middle = T_world_put.act(centre)
    # Parts of a kind stand on each other turned as their places leave it: both faces carry.
    faces = [points[points[:, 2] <= low + SAME_FACE_WITHIN, :2]]
    if place.layer > 1:
        faces.append(points[points[:, 2] >= high - SAME_FACE_WITHIN, :2])
    within = min(stands_within(face, middle[:2]) for face in faces)
    if place.layer > 1:
        within -= place.tolerance
    tall = max(middle[2] - low, place.layer * (high - low) / 2)
    tilt = float(np.arctan2(within, tall))
    if tilt < STEADY:
        return ProofText.STACK_FALLS(layers=place.layer, tilt=max(0.0, tilt), least=float(STEADY))
    return None


def fall(cell: Cell, known: Sequence[Obstacle], found: Detection, T_world_put: pin.SE3) -> float:
    """How far [m] a part falls straight down when a hand lets go of it, `SEARCHED_BELOW` at most.

    Args:
        cell: whose bin and fixtures stand around.
        known: what else does.
        found: the part, as it was found.
        T_world_put: where the hand lets go of it.
    """
    still = [(body.shape, body.T_joint_body)
             for body in still_of(cell, Scene("", (), tuple(known)))]  # fmt: skip
    put = Detection(found.part, T_world_put, roll_known=found.roll_known, roll_axis=found.roll_axis)
    pieces = [piece for turns in turned_pieces(cell.part(found.part), put) for piece in turns]
    near = [
        (piece, body)
        for piece, body in product(pieces, still)
        if gap_of(piece, body, SEARCHED_BELOW) < SEARCHED_BELOW
    ]
    fallen = 0.0
    while fallen < SEARCHED_BELOW:
        down = np.array([0.0, 0.0, -fallen])
        gap = min(
            (
                gap_of((shape, pin.SE3(T.rotation, T.translation + down)), body)
                for (shape, T), body in near
            ),
            default=SEARCHED_BELOW,
        )
        if gap <= RESTS_WITHIN:
            return fallen
        # Nothing nearer than that can be met sooner.
        fallen += gap
    return SEARCHED_BELOW


def kept_box(
    cell: Cell,
    known: Sequence[Obstacle],
    found: Detection,
    T_world_put: pin.SE3,
    *,
    is_sure: bool = True,
) -> Obstacle:
    """The box around a part that was put down: later plans keep clear of it.

    On a pallet in layers, and in an assembly, it is where it has fallen to; it counts as what
    others stand on, as long as it `is_sure` that it is there.  Elsewhere it is where the hand has
    let go of it.

    Args:
        cell: as it is.
        known: what stands there already.
        found: the part, as it was found.
        T_world_put: where the hand has let go of it.
        is_sure: whether it is there, or may be.
    """
    part = cell.part(found.part)
    T_part_box, size = _box_of(part, found)
    if is_sure and found.roll_known and found.part in assembled_kinds(cell):
        T_world_part = T_world_put.copy()
        T_world_part.translation -= [0.0, 0.0, fall(cell, known, found, T_world_put)]
        return Obstacle(T_world_part * T_part_box, size, found.part, T_world_put)
    places = [place_at(arm, part, T_world_put) for arm in cell.arms] if is_sure else []
    place = next((part_place for part_place in places if part_place is not None), None)
    if place is None:
        return Obstacle(T_world_put * T_part_box, size)
    # Along the axes of the grid: however round parts are turned, they need no more room beside.
    signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
    points = part.mesh.points if found.roll_known else _act(T_part_box, signs * size)
    seen = _act(place.T_world_part.actInv(T_world_put), points)
    low, high = seen.min(axis=0), seen.max(axis=0)
    T_world_box = place.T_world_part * pin.SE3(np.eye(3), (low + high) / 2)
    T_world_box.translation -= [0.0, 0.0, fall(cell, known, found, T_world_put)]
    return Obstacle(T_world_box, high - low, found.part, T_world_put)


def _box_of(part: Part, found: Detection) -> tuple[pin.SE3, Floats]:
    """A box (3,) [m] that holds a part, and where: one of unknown roll at every turn of it."""
    points, R, origin = part.mesh.points, np.eye(3), np.zeros(3)
    if not found.roll_known:
        origin, direction = roll_axis(part, found)
        R = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(direction)).matrix()
    seen = (points - origin) @ R
    low, high = seen.min(axis=0), seen.max(axis=0)
    if not found.roll_known:
        radius = np.full(2, np.linalg.norm(seen[:, :2], axis=1).max())
        low, high = np.append(-radius, low[2]), np.append(radius, high[2])
    return pin.SE3(R, origin + R @ ((low + high) / 2)), high - low


def _act(T: pin.SE3, points: Floats) -> Floats:
    return points @ T.rotation.T + T.translation
