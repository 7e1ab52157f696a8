"""Which hypotheses are parts: one after the other, the best first, no pixel explained twice."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import open3d as o3d
import pinocchio as pin

from workbench.model.cell import Bin
from workbench.model.geometry import Floats, frozen, put
from workbench.perception.assessment import Assessment
from workbench.perception.maps import DepthMap
from workbench.perception.part_surface import PartSurface
from workbench.perception.sightings import Sighting

LEAST_VISIBLE = 0.3
"""Less of the facing surface than this cannot tell a part from a chance likeness."""

PLAUSIBLE, CONVINCING = 0.75, 0.95
"""Of what is seen in the part's place, the part must explain these shares: before a close look
at it, and after."""

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
    maps: DepthMap,
    surface: PartSurface,
    hypotheses: list[Hypothesis],
    assess: Callable[[Floats], Assessment],
) -> list[Assessment]:
    """The hypotheses that hold together after a close look, in the order of choice.

    Each next one is that which gains most from the pixels that no chosen one explains; it must
    explain enough of what it shows, and not reach into a chosen one.

    Args:
        maps: the scan.
        surface: the part.
        hypotheses: possible poses, fitted roughly.
        assess: looks closely at a pose (4, 4) and returns a better one.
    """
    claimed = np.zeros(maps.depth.size, dtype=bool)
    chosen: list[Assessment] = []
    left = list(hypotheses)
    while left:
        gains = [_gain(hypothesis.sighting, claimed) for hypothesis in left]
        hypothesis = left.pop(int(np.argmax(gains)))
        if not _explains(hypothesis.sighting, claimed, PLAUSIBLE):
            continue
        assessed = assess(hypothesis.pose)
        if not _explains(assessed.sighting, claimed, CONVINCING) or any(
            _overlap(surface, assessed.pose, other.pose) for other in chosen
        ):
            continue
        claimed[assessed.sighting.explained] = True
        chosen.append(assessed)
    return chosen


def _gain(sighting: Sighting, claimed: np.ndarray) -> float:
    return sighting.gain - float(np.count_nonzero(claimed[sighting.explained]))


def _explains(sighting: Sighting, claimed: np.ndarray, consistent: float) -> bool:
    """Whether enough is explained that is not claimed; `consistent` see `CONVINCING`."""
    explained = int(np.count_nonzero(~claimed[sighting.explained]))
    return (
        explained >= LEAST_PIXELS
        and explained >= LEAST_VISIBLE * sighting.shown
        and explained >= consistent * (explained + len(sighting.violated))
    )


def _overlap(surface: PartSurface, pose: Floats, other: Floats) -> bool:
    """Whether the part at one pose reaches into itself at another."""
    between = np.linalg.inv(other) @ pose
    points = surface.coarse.points @ between[:3, :3].T + between[:3, 3]
    if (
        not surface.is_closed
        or np.linalg.norm(between[:3, :3] @ surface.middle + between[:3, 3] - surface.middle)
        > surface.diameter
    ):
        return False
    inside = surface.scene.compute_signed_distance(o3d.core.Tensor(points.astype(np.float32)))
    return float(np.mean(inside.numpy() < -DEEP * surface.diameter)) > MOST_DEEP
