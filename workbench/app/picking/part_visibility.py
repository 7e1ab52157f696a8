"""Whether a scanner sees enough of a part to find it: pixels, where it lies alone in the bin."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import transform
from workbench.model.part import Part
from workbench.perception.views.camera import Pinhole
from workbench.perception.views.rendering import rendered
from workbench.planning.grasps.resting import ways_to_lie

LEAST_ACROSS = 45.0
"""Pixels over the diagonal of a part that is found reliably.  Shipped parts and a washer, made
smaller, six of them alone on the floor of `yumi` in three simulated scans each: with 50 and more
all were found, with 42 13 of 18, with 36 none to 4; at twice the resolution all again."""


@dataclass(frozen=True, slots=True)
class Visibility:
    """A part that lies in the middle of the bin, as the scanner sees it.

    `pixels` show it, `across` of them would lie over its diagonal, and it is `height` [m] high.
    """

    pixels: int
    across: float
    height: float

    @property
    def is_enough(self) -> bool:
        """Whether a part of this size is found reliably."""
        return self.across >= LEAST_ACROSS


def visibility(cell: Cell, part: Part) -> Visibility:
    """What the cell's scanner sees of a part in the way in which it lies most often."""
    up = ways_to_lie(part)[0][0]
    points = np.asarray(part.mesh.points)
    R = pin.Quaternion.FromTwoVectors(up, np.array([0.0, 0.0, 1.0])).matrix()
    lying = points @ R.T
    low, high = lying.min(axis=0), lying.max(axis=0)
    T_bin_part = pin.SE3(R, -np.array([*(low + high)[:2] / 2, low[2]]))
    T = cell.scanner.T_world_scanner.actInv(cell.bin.T_world_bin * T_bin_part)
    camera = Pinhole.of_scanner(cell.scanner)
    column, row = map(float, camera.centre)
    triangles = np.asarray(part.mesh.triangles, np.int32)
    _, _, depths, _, _ = rendered(
        T.homogeneous, points, triangles, False, camera.rays(), camera.focal, column, row
    )
    distance = float(transform(T, points)[:, 2].mean())
    diagonal = float(np.linalg.norm(np.ptp(points, axis=0)))
    return Visibility(
        int(np.isfinite(depths).sum()),
        camera.focal * diagonal / distance,
        float(high[2] - low[2]),
    )
