"""Which hypotheses are parts: one after the other, the best first, no pixel explained twice."""

from dataclasses import dataclass

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Bin
from workbench.model.geometry import Floats, frozen, put
from workbench.perception.maps import DepthMap
from workbench.perception.part_surface import PartSurface
from workbench.perception.sightings import Sighting

LEAST_VISIBLE = 0.3
"""Less of the facing surface than this cannot tell a part from a chance likeness."""

LEAST_CONSISTENT = 0.93
"""Of what is seen in the part's place, the part must explain this share."""

LEAST_PIXELS = 40

DEEP, MOST_DEEP = 0.03, 0.02
"""Two parts, or part and bin, exclude each other when more than this share of the surface is
deeper inside than this share of the diameter."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """A pose (4, 4) of the part in the scanner's frame, and what it predicts and explains."""

    pose: Floats
    sighting: Sighting

    def __post_init__(self) -> None:
        put(self, pose=frozen(self.pose))


def is_in_bin(surface: PartSurface, pose: Floats, T_scanner_bin: pin.SE3, bin: Bin) -> bool:
    """Whether the part does not reach through floor or walls; it may stick out above."""
    T = T_scanner_bin.inverse().homogeneous @ pose
    points = surface.coarse.points @ T[:3, :3].T + T[:3, 3]
    allowed = DEEP * surface.diameter
    below = points[:, 2] < -allowed
    across = (np.abs(points[:, :2]) > bin.size[:2] / 2 + allowed).any(axis=1)
    return float(np.mean(below | (across & (points[:, 2] < bin.size[2])))) <= MOST_DEEP


def choose(
    maps: DepthMap, surface: PartSurface, hypotheses: list[Hypothesis]
) -> list[Hypothesis]:
    """The hypotheses that hold together, in the order in which they were chosen.

    Each next one is that which gains most from the pixels that no chosen one explains; it must
    explain enough of what it shows, and not reach into a chosen one.
    """
    claimed = np.zeros(maps.depth.size, dtype=bool)
    chosen: list[Hypothesis] = []
    left = list(hypotheses)
    while left:
        gains = [_gain(hypothesis.sighting, claimed) for hypothesis in left]
        hypothesis = left.pop(int(np.argmax(gains)))
        if not _is_convincing(hypothesis.sighting, claimed):
            continue
        if any(_overlap(surface, hypothesis.pose, other.pose) for other in chosen):
            continue
        claimed[hypothesis.sighting.explained] = True
        chosen.append(hypothesis)
    return chosen


def _gain(sighting: Sighting, claimed: np.ndarray) -> float:
    return sighting.gain - float(np.count_nonzero(claimed[sighting.explained]))


def _is_convincing(sighting: Sighting, claimed: np.ndarray) -> bool:
    explained = int(np.count_nonzero(~claimed[sighting.explained]))
    against = len(sighting.violated)
    return (
        explained >= LEAST_PIXELS
        and explained >= LEAST_VISIBLE * sighting.shown
        and explained >= LEAST_CONSISTENT * (explained + against)
    )


def _overlap(surface: PartSurface, pose: Floats, other: Floats) -> bool:
    """Whether the part at one pose reaches into itself at another."""
    between = np.linalg.inv(other) @ pose
    points = surface.coarse.points @ between[:3, :3].T + between[:3, 3]
    if not surface.is_closed or np.linalg.norm(
        between[:3, :3] @ surface.middle + between[:3, 3] - surface.middle
    ) > surface.diameter:
        return False
    inside = surface.scene.compute_signed_distance(o3d.core.Tensor(points.astype(np.float32)))
    return float(np.mean(inside.numpy() < -DEEP * surface.diameter)) > MOST_DEEP
