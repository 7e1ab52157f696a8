"""A last close look at a part found: polish its pose, and see how sure it is."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, frozen, put
from workbench.perception.hypotheses import NARROW_GATES, SAME_ANGLE, SAME_DISTANCE
from workbench.perception.maps import DepthMap
from workbench.perception.part_surface import PartSurface
from workbench.perception.poses import distinct
from workbench.perception.registration import refine
from workbench.perception.sightings import Sighting, look

RIVALS = 4
"""Near-symmetric poses that are fitted and polished before the best of them is taken."""

CLOSE = 0.02
"""Rivals whose gain is smaller by more than this share are not polished."""

STEPS_OVER_TOLERANCE = (1.0, 0.5, 0.25)
"""Lengths of the polishing steps."""

WEAK = 3
"""Directions along which a pose is polished: those that the fit holds least."""

TELLING = 0.008
"""Share of the explained pixels by which a pose must be better than another to exclude it."""

FEWEST_TELLING = 8.0
"""[pixels] And by no less than this."""


@dataclass(frozen=True, slots=True, eq=False)
class Assessment:
    """A pose (4, 4) in the scanner's frame with what is to be said about it.

    `gap` is by how much of the shown surface more it is explained than the best different pose
    of the same object, None when the part has no near-symmetry.  `roll_known` is False when
    turning the part about its axis changes nothing that the scan shows.
    """

    pose: Floats
    sighting: Sighting
    gap: float | None
    roll_known: bool

    def __post_init__(self) -> None:
        put(self, pose=frozen(self.pose))


def assess(maps: DepthMap, surface: PartSurface, pose: Floats, tolerance: float) -> Assessment:
    """Look at all near-symmetric poses of one that was found, and take the best.

    Args:
        maps: the scan.
        surface: the part.
        pose: (4, 4) found for it.
        tolerance: [m] see `look`.
    """
    pose, sighting = _best_of(maps, surface, pose @ surface.symmetry.motions, tolerance)
    others = pose @ surface.symmetry.motions
    sightings = look(maps, surface, others, tolerance)
    gains = np.array([other.gain for other in sightings])
    order = np.argsort(-gains, kind="stable")
    kept = (
        distinct(
            np.concatenate([pose[None], others]),
            np.concatenate([[0], order + 1]),
            surface.stated,
            surface.middle,
            distance=np.inf,
            angle=SAME_ANGLE,
            most=len(others),
        )[1:]
        - 1
    )
    margin = max(FEWEST_TELLING, TELLING * len(sighting.explained))
    turned = kept[kept < len(surface.symmetry.turns)]
    return Assessment(
        pose=pose,
        sighting=sighting,
        gap=None if len(kept) == 0 else max(0.0, sighting.gain - gains[kept[0]]) / sighting.shown,
        roll_known=len(turned) == 0 or bool(gains[turned].max() < sighting.gain - margin),
    )


def _best_of(
    maps: DepthMap, surface: PartSurface, poses: Floats, tolerance: float
) -> tuple[Floats, Sighting]:
    """The best of the poses (k, 4, 4), after fitting and polishing the few that look best."""
    glances = look(maps, surface, poses, tolerance)
    gains = np.array([sighting.gain for sighting in glances])
    kept = distinct(
        poses,
        np.argsort(-gains, kind="stable"),
        surface.stated,
        surface.middle,
        distance=SAME_DISTANCE * surface.diameter,
        angle=SAME_ANGLE,
        most=RIVALS,
    )
    fitted, _ = refine(maps, poses[kept], surface.fine, NARROW_GATES * tolerance)
    gains = np.array([sighting.gain for sighting in look(maps, surface, fitted, tolerance)])
    close = gains >= gains.max() - CLOSE * abs(gains.max())
    polished = [_polished(maps, surface, pose, tolerance) for pose in fitted[close]]
    sightings = look(maps, surface, np.array(polished), tolerance)
    best = int(np.argmax([sighting.gain for sighting in sightings]))
    return polished[best], sightings[best]


def _polished(maps: DepthMap, surface: PartSurface, pose: Floats, tolerance: float) -> Floats:
    """The pose after a search along the directions that the fit of surfaces leaves loose.

    A cylinder slides along its axis without leaving its surface; where it ends is seen by
    which pixels show it, which no distance between points and planes expresses.
    """
    seen = look(maps, surface, pose[None], tolerance)[0]
    for move in _weak_directions(maps, surface, seen, pose):
        for step in STEPS_OVER_TOLERANCE:
            tried = np.array(
                [_moved(surface, pose, k * step * tolerance * move) for k in range(-2, 3)]
            )
            values = [s.closeness(tolerance) for s in look(maps, surface, tried, tolerance)]
            pose = tried[int(np.argmax(values))]
    return pose


def _weak_directions(
    maps: DepthMap, surface: PartSurface, sighting: Sighting, pose: Floats
) -> Floats:
    """Small motions (WEAK, 6): turn about the middle over the radius, and shift."""
    centre = pose[:3, :3] @ surface.middle + pose[:3, 3]
    pixels = sighting.explained
    points = maps.rays.reshape(-1, 3)[pixels] * maps.depth.ravel()[pixels, None]
    normals = maps.normals.reshape(-1, 3)[pixels]
    arms = (points - centre) / (surface.diameter / 2)
    rows = np.concatenate([np.cross(arms, normals), normals], axis=1)
    return np.linalg.eigh(rows.T @ rows)[1][:, :WEAK].T


def _moved(surface: PartSurface, pose: Floats, move: Floats) -> Floats:
    centre = pose[:3, :3] @ surface.middle + pose[:3, 3]
    turn = pin.exp3(move[:3] / (surface.diameter / 2))
    moved = pose.copy()
    moved[:3, :3] = turn @ pose[:3, :3]
    moved[:3, 3] = turn @ (pose[:3, 3] - centre) + centre + move[3:]
    return moved
