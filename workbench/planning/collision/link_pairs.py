"""Which pairs of links need no check: neighbours, and those that meet whatever the arms do.

What a robot's maker gives as an SRDF file is found here by trying: seeded configurations over
the whole range of all arms.  Pairs that were never seen to meet stay checked, neighbours too: a
sample proves nothing, and the check is cheap.
"""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Ints
from workbench.planning.collision.bodies import carried_bodies, geometry_of
from workbench.planning.kinematics.robot import Kinematics

RANDOM_POSTURES = 1000
ALWAYS = 0.95
"""A pair that meets in this share of the samples meets by how it is built."""
DROPPED_EVERY = 20
"""Samples after which pairs are left out of which the answer is known."""


def pairs_without_check(cell: Cell, *, seed: int = 0) -> Mapping[tuple[str, str], str]:
    """Pairs of links, the tool of an arm being `<arm>_tool`, each with its reason.

    Args:
        cell: its own disabled pairs are not checked.
        seed: of the configurations.
    """
    kinematics = Kinematics(cell)
    model = kinematics.model
    bodies = carried_bodies(cell, kinematics)
    owners = [f"{body.owner}_tool" if body.kind == "tool" else body.owner for body in bodies]
    joints = np.array([body.joint for body in bodies])
    parents = np.array(list(model.parents))
    geometry = geometry_of(bodies)
    geometry.setCollisionPairs(np.triu(joints[:, None] != joints, 1), True)
    first, second = (
        np.array([getattr(pair, end) for pair in geometry.collisionPairs])
        for end in ("first", "second")
    )
    flanges = {f"{arm.name}_tool": arm.flange for arm in cell.arms}
    carrier = {owner: kinematics.frames[flanges.get(owner, owner)][0] for owner in set(owners)}
    ends = [tuple(sorted((owners[i], owners[j]))) for i, j in zip(first, second, strict=True)]
    pairs = {pair: number for number, pair in enumerate(dict.fromkeys(ends))}
    are_neighbours = np.array(
        [
            carrier[a] == carrier[b]
            or parents[carrier[a]] == carrier[b]
            or parents[carrier[b]] == carrier[a]
            for a, b in pairs
        ]
    )
    of = np.array([pairs[pair] for pair in ends])
    found = _meetings(kinematics, geometry, cell.policy.margin, seed, of, are_neighbours)
    reasons: dict[tuple[str, str], str] = {}
    for (a, b), number in pairs.items():
        if found[number] and a != b:
            reasons[a, b] = "Adjacent" if are_neighbours[number] else "Always"
    return reasons


def _meetings(
    kinematics: Kinematics,
    geometry: pin.GeometryModel,
    margin: float,
    seed: int,
    of: Ints,
    are_neighbours: Bools,
) -> Bools:
    """Whether pairs of links need no check (n,): neighbours that meet, others that always do.

    Args:
        kinematics: of the cell, all of whose arms are drawn by seed.
        geometry: its pairs of bodies are checked until it is known of their links.
        margin: [m] bodies meet that are nearer.
        seed: of the configurations.
        of: the pair of links of each pair of bodies.
        are_neighbours: pairs of links (n,).
    """
    model, data, found = kinematics.model, kinematics.model.createData(), pin.GeometryData(geometry)
    for request in found.collisionRequests:
        request.security_margin = margin
    rng = np.random.default_rng(seed)
    hits = np.zeros(len(are_neighbours), int)
    looked_at = np.arange(len(of))
    for number in range(1, RANDOM_POSTURES + 1):
        q = rng.uniform(model.lowerPositionLimit, model.upperPositionLimit)
        pin.computeCollisions(model, data, geometry, found, q, False)
        met = [k for k in looked_at.tolist() if found.collisionResults[k].isCollision()]
        hits[np.unique(of[met])] += 1
        if number % DROPPED_EVERY == 0:
            is_known = np.where(
                are_neighbours, hits > 0, number - hits > (1 - ALWAYS) * RANDOM_POSTURES
            )
            for k in looked_at[is_known[of[looked_at]]].tolist():
                found.deactivateCollisionPair(k)
            looked_at = looked_at[~is_known[of[looked_at]]]
    return np.where(are_neighbours, hits > 0, hits >= ALWAYS * RANDOM_POSTURES)
