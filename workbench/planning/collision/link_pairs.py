"""Which pairs of links need no check: neighbours, and those that meet whatever the arms do.

What a robot's maker gives as an SRDF file is found here by trying: seeded configurations over
the whole range of all arms.  Pairs that were never seen to meet stay checked, neighbours too: a
sample proves nothing, and the check is cheap.
"""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Bools
from workbench.planning.collision.bodies import carried_bodies, geometry_of
from workbench.planning.kinematics.robot import Kinematics

SAMPLES = 1000
ALWAYS = 0.95
"""A pair that meets in this share of the samples meets by how it is built."""


def pairs_without_check(cell: Cell, *, seed: int = 0) -> Mapping[tuple[str, str], str]:
    """Pairs of links, the tool of an arm being `<arm>_tool`, each with its reason.

    Args:
        cell: its own disabled pairs are not looked at.
        seed: of the configurations.
    """
    kinematics = Kinematics(cell)
    model = kinematics.model
    bodies = carried_bodies(cell, kinematics)
    owners = [f"{one.owner}_tool" if one.kind == "tool" else one.owner for one in bodies]
    joints = np.array([one.joint for one in bodies])
    parents = np.array(list(model.parents))
    geometry = geometry_of(bodies)
    geometry.setCollisionPairs(np.triu(joints[:, None] != joints, 1), True)
    first, second = (
        np.array([getattr(pair, end) for pair in geometry.collisionPairs])
        for end in ("first", "second")
    )
    met = _meetings(kinematics, geometry, cell.policy.margin, seed)
    flanges = {f"{arm.name}_tool": arm.flange for arm in cell.arms}
    carrier = {owner: kinematics.frames[flanges.get(owner, owner)][0] for owner in set(owners)}
    pairs: dict[tuple[str, str], list[int]] = {}
    for number, (i, j) in enumerate(zip(first, second, strict=True)):
        pair = (min(owners[i], owners[j]), max(owners[i], owners[j]))
        pairs.setdefault(pair, []).append(number)
    reasons: dict[tuple[str, str], str] = {}
    for (a, b), numbers in pairs.items():
        share = float(met[:, numbers].any(axis=1).mean())
        i, j = carrier[a], carrier[b]
        are_neighbours = i == j or parents[i] == j or parents[j] == i
        if a != b and are_neighbours and share > 0:
            reasons[a, b] = "Adjacent"
        elif a != b and share >= ALWAYS:
            reasons[a, b] = "Always"
    return reasons


def _meetings(
    kinematics: Kinematics, geometry: pin.GeometryModel, margin: float, seed: int
) -> Bools:
    """Whether each pair is nearer than a margin [m] (samples, pairs), all arms drawn by seed."""
    model, data, found = kinematics.model, kinematics.model.createData(), pin.GeometryData(geometry)
    for request in found.collisionRequests:
        request.security_margin = margin
    rng = np.random.default_rng(seed)
    met = np.zeros((SAMPLES, len(geometry.collisionPairs)), bool)
    for number in range(SAMPLES):
        q = rng.uniform(model.lowerPositionLimit, model.upperPositionLimit)
        pin.computeCollisions(model, data, geometry, found, q, False)
        met[number] = [result.isCollision() for result in found.collisionResults]
    return met
