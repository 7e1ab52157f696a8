"""How often a part mates with the one that it is inserted into, or put over.

The terms are those of Whitney, Quasi-static assembly of compliantly supported rigid parts, Journal
of Dynamic Systems, Measurement, and Control 104 (1982) 65-77.  The parts meet: chamfer crossing
takes an offset of the axes up to the clearance and the width of the chamfers.  Then one-point
contact pushes the part sideways, as far as it gives way in the hand.  Two-point contact, at which
parts wedge or jam, is not allowed: a part does not turn in the hand.
"""

import numpy as np

from workbench.model.geometry import Bools, Floats
from workbench.model.recipes.joint import PlacingError
from workbench.model.recipes.kit import Insertion
from workbench.planning.placing.chance import DRAWS, draw_errors

ROUNDED = 1.0 + 1e-9
"""A point on the rim of what is allowed is allowed."""


def mating_chance(
    insertion: Insertion, part: PlacingError, base: PlacingError, scanner: Floats
) -> float:
    """The share of parts that mate, 0..1, where what they tolerate is stated.

    Args:
        insertion: with a joint.
        part: in the hand.
        base: where it stands.
        scanner: (6, 6) [m, rad] covariance of the scanner's pose, by which both were found.
    """
    turned = draw_errors(scanner, DRAWS, 0)
    of_part, of_base = (
        turned @ placed.by_scanner.T + draw_errors(placed.covariance, DRAWS, seed)
        for seed, placed in enumerate((part, base), 1)
    )
    return float(np.mean(mate(insertion, of_part, of_base)))


def mate(insertion: Insertion, part: Floats, base: Floats) -> Bools:
    """Which of some parts (n,) mate.

    Args:
        insertion: with a joint.
        part: (n, 6) [m, rad] errors of the part in the hand: shifts of its origin, then turns,
            along its axes.
        base: (n, 6) [m, rad] those of its base, along the base's axes.
    """
    joint = insertion.joint
    assert joint is not None
    meets, *deeper = offsets(insertion, part, base)
    is_mated = np.linalg.norm(meets[0], axis=1) <= joint.takes * ROUNDED
    for ends in deeper:
        is_mated &= least_push(*ends, joint.clearance) <= joint.compliance * ROUNDED
    return is_mated


def offsets(insertion: Insertion, part: Floats, base: Floats) -> list[tuple[Floats, Floats]]:
    """How far the axes are apart, each (n, 2) [m], at both ends of what the part is in the joint.

    First as the parts meet, then at the depths at which the joint's ends pass each other, at last
    seated: between, offsets lie between those, and so does the push that the part needs.

    Args:
        insertion: with a joint.
        part: errors as in `mate`.
        base: errors as in `mate`.
    """
    joint = insertion.joint
    assert joint is not None
    along, mouth = np.array(insertion.along), np.array(joint.mouth)
    across = np.linalg.svd(along[None])[2][1:]
    T_part_base = insertion.T_base_part.inverse()

    def apart(depth: float, base_depth: float) -> Floats:
        seated = mouth + (joint.depth - depth + base_depth) * along
        moved = _move(part, T_part_base.act(seated)) @ T_part_base.rotation
        return (moved - _move(base, mouth + base_depth * along)) @ across.T

    return [
        (
            apart(depth, max(0.0, depth - joint.part_length)),
            apart(depth, min(depth, joint.base_length)),
        )
        for depth in sorted({0.0, joint.part_length, joint.base_length, joint.depth})
    ]


def _move(errors: Floats, point: Floats) -> Floats:
    """How errors (n, 6) move a point (3,) [m] of what is off: (n, 3) [m]."""
    return errors[:, :3] + np.cross(errors[:, 3:], point)


def least_push(mouth: Floats, tip: Floats, clearance: float) -> Floats:
    """How far a part has to be pushed sideways to be within the clearance at both ends: (n,) [m].

    Infinitely far where it is tilted too much: it would touch at two points.

    Args:
        mouth: (n, 2) [m] offset of the axes there.
        tip: (n, 2) [m] that at the other end.
        clearance: [m] of the joint.
    """
    middle, half = (mouth + tip) / 2, (tip - mouth) / 2
    far = np.linalg.norm(half, axis=1, keepdims=True)
    normal = np.stack([-half[:, 1], half[:, 0]], axis=1) / np.maximum(far, 1e-300)
    rise = np.sqrt(np.maximum(clearance**2 - far**2, 0.0)) * normal
    # The nearest point of two discs that overlap: here, on the rim of either, or on both rims.
    pushes = [
        np.zeros_like(mouth),
        *(_onto(offset, clearance) for offset in (mouth, tip)),
        -middle + rise,
        -middle - rise,
    ]
    found = np.full(len(mouth), np.inf)
    for push in pushes:
        off = np.maximum(*(np.linalg.norm(offset + push, axis=1) for offset in (mouth, tip)))
        length = np.linalg.norm(push, axis=1)
        found = np.where(off <= clearance * ROUNDED, np.minimum(found, length), found)
    return found


def _onto(offset: Floats, clearance: float) -> Floats:
    """The least push (n, 2) [m] that brings an offset (n, 2) [m] within the clearance."""
    far = np.linalg.norm(offset, axis=1, keepdims=True)
    return -offset * np.maximum(1.0 - clearance / np.maximum(far, 1e-300), 0.0)
