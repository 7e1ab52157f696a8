"""Whether a part lies as a place asks, by a search of its own for the nearest right pose."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm
from workbench.model.geometry import Floats
from workbench.model.messages.proofs import ProofText
from workbench.model.part import Part, PartPlace
from workbench.model.plan import Violation
from workbench.model.scan import Detection
from workbench.model.symmetry import BALL, NONE, ROUND, Symmetry
from workbench.proof.claims.scene import roll_axis
from workbench.proof.claims.tolerances import is_on_axis

START_STEP, SEARCH_STEPS = np.deg2rad(15.0), 20
"""[rad] How far apart the search for the nearest right pose begins, and how often it goes on."""

OFF_LINE = 0.002
"""[m] How far the end of the linear motion to a place may lie off the direction that it states."""


def lying_violations(
    arm: Arm, part: Part, found: Detection, T_world_put: pin.SE3, came: Floats
) -> Iterator[Violation]:
    """Whether a part lies as one of the places for its kind asks, where the hand lets go of it.

    And whether it came straight from where that place has it come.

    Args:
        arm: whose places count.
        part: that is put down.
        found: the part as it was found.
        T_world_put: where it is when the hand lets go of it.
        came: (3,) [m] the linear motion on which it got there.
    """
    best: tuple[float, float, float, PartPlace] | None = None
    unseen, is_aside = False, False
    for place in arm.part_places:
        if place.part not in ("", part.name):
            continue
        if not found.roll_known and not _is_any_turn(place, part, roll_axis(part, found)):
            unseen = True
            continue
        for far, turn in place_offs(place, part.symmetry, T_world_put):
            share = max(far / place.tolerance, turn / place.turn_tolerance)
            if np.linalg.norm(came - np.linalg.norm(came) * np.array(place.approach)) > OFF_LINE:
                is_aside |= share <= 1.0
                continue
            if best is None or share < best[0]:
                best = share, far, turn, place
    if best is not None and best[0] <= 1.0:
        return
    if is_aside:
        yield Violation(ProofText.OTHER_APPROACH(), arm.name, "place")
        return
    if best is None:
        problem = ProofText.PLACE_NEEDS_ROLL() if unseen else ProofText.NO_PLACE()
        yield Violation(problem, arm.name, "place")
        return
    _, far, turn, place = best
    problem = ProofText.MISPLACED(
        far=far, turn=turn, tolerance=place.tolerance, turn_tolerance=place.turn_tolerance
    )
    yield Violation(problem, arm.name, "place")


def place_offs(
    place: PartPlace, symmetry: Symmetry, T_world_put: pin.SE3
) -> Iterator[tuple[float, float]]:
    """How far [m, rad] a part is from poses that are right at a place, the nearest among them."""
    off = place.T_world_part.actInv(T_world_put)
    for right in right_poses(place, symmetry, T_world_put):
        yield (
            float(np.linalg.norm(right.translation - off.translation)),
            float(np.linalg.norm(pin.log3(right.rotation.T @ off.rotation))),
        )


def right_poses(place: PartPlace, symmetry: Symmetry, T_world_put: pin.SE3) -> Iterator[pin.SE3]:
    """Poses in the frame of a place that are right there, those nearest to a part among them.

    What is right is T_world_part * Rz(a) * S with |a| up to the free rotation and S of the group.
    Each pose found so is one of these, so that one within the tolerances proves the part right;
    were the nearest missed, a plan would be refused.
    """
    z, free = np.array([0.0, 0.0, 1.0]), min(place.free_rotation, np.pi)
    off = place.T_world_part.actInv(T_world_put)
    R, point = np.asarray(off.rotation), np.array(symmetry.point)
    axis = None
    if symmetry.form == ROUND:
        axis = symmetry.axes[0].axis
    starts = np.linspace(-free, free, 1 + 2 * int(np.ceil(free / START_STEP)))
    # No turn of the symmetry moves its point: where that is tells a turn about z, too.
    (x, y), (u, v) = point[:2], off.act(point)[:2]
    starts = np.append(starts, np.clip(np.arctan2(x * v - y * u, x * u + y * v), -free, free))
    if symmetry.form == NONE:
        starts = np.zeros(1)  # one search is exact
    group = [np.eye(3)] if symmetry.form == BALL else symmetry.motions(1)[:, :3, :3]
    for G in group:
        for a in starts:
            S = G
            for _ in range(1 if axis is None else SEARCH_STEPS):
                if symmetry.form == BALL:
                    S = pin.exp3(-a * z) @ R
                elif axis is not None:
                    S = pin.exp3(axis * _angle(axis, pin.exp3(-a * z) @ R @ G.T)) @ G
                if symmetry.form != BALL:
                    a = float(np.clip(_angle(z, R @ S.T), -free, free))
            Z = pin.exp3(a * z)
            yield pin.SE3(Z @ S, Z @ (point - S @ point))


def _angle(axis: Floats, R: Floats) -> float:
    """The angle [rad] of the turn about an axis (3,) that comes nearest to a rotation (3, 3)."""
    across = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return float(np.arctan2(axis @ across, np.trace(R) - axis @ R @ axis))


def _is_any_turn(place: PartPlace, part: Part, axis: Floats) -> bool:
    """Whether no turn of a part about an axis (2, 3) of its own matters at a place."""
    symmetry, along = part.symmetry, axis[1]
    lines = (
        [np.array([np.zeros(3), [0.0, 0.0, 1.0]])] if place.free_rotation >= np.pi - 1e-6 else []
    )
    if symmetry.form == ROUND:
        lines.append(np.array([symmetry.point, symmetry.axes[0].axis]))
    elif symmetry.form == BALL:
        lines.append(np.array([symmetry.point, along]))
    return any(is_on_axis(part, axis, line) for line in lines)
