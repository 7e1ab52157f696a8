"""What a suction cup meets: the surface under its lip."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.cell import Tool
from workbench.model.derived.by_tcp import may_touch
from workbench.model.geometry import Floats, Mesh
from workbench.planning.grasps.pads import outline
from workbench.planning.grasps.part_rays import RayGrid, tops

CELLS = 24
"""Across the cup."""

SMALLEST = 0.001
"""[m] Radius of a cup, even where its mesh ends in a point."""

LIP = 0.75
"""Share of the radius: the surface further out is under the lip, which has to close."""

NEAR_TIP = 0.002
"""[m] Solids of the tool that reach as near to the TCP's plane are the cup."""


@dataclass(frozen=True, slots=True, eq=False)
class Seal:
    """The surface under a cup's lip.

    `missing` is the share of the lip without a surface below it.  `unevenness` [m] is the variation
    of the surface's height, `height` [m] its mean above the TCP, towards the cup.
    """

    missing: float
    unevenness: float
    height: float


class Cup:
    """The lip of a tool without fingers.

    Lifetime: as long as the tool; holds nothing of a part.
    """

    def __init__(self, tool: Tool):
        T_tcp_flange = tool.T_flange_tcp.inverse()
        solids = [solid for solid in tool.body if may_touch(tool, solid.name)]
        corners = [outline(s.shape) for s in solids]
        poses = [T_tcp_flange * s.T_owner_shape for s in solids]
        points = np.vstack(
            [
                points @ T.rotation.T + T.translation
                for points, T in zip(corners, poses, strict=True)
            ]
        )
        tip = points[points[:, 2] > points[:, 2].max() - NEAR_TIP]
        self.radius = max(float(np.linalg.norm(tip[:, :2], axis=1).max()), SMALLEST)
        step = 2 * self.radius / CELLS
        edge = -self.radius + step / 2
        self._grid = RayGrid(edge, edge, step, (CELLS, CELLS))
        u, v = self._grid.centres
        far = np.hypot(u, v) / self.radius
        self._is_lip = (far >= LIP) & (far <= 1.0)

    def seal(self, mesh: Mesh, T_tcp_part: pin.SE3, reach: float) -> Seal | None:
        """What the lip meets that comes from `reach` [m] above; None when it meets nothing."""
        points = np.asarray(mesh.points) @ T_tcp_part.rotation.T + T_tcp_part.translation
        # The tool looks along z of the TCP: what it meets first has the smallest z.
        starts = np.where(self._is_lip, reach, np.nan)
        heights, _ = tops(points, np.asarray(mesh.triangles), self._grid, starts, -1.0)
        met: Floats = heights[self._is_lip & ~np.isnan(heights)]
        if len(met) == 0:
            return None
        missing = 1 - len(met) / int(self._is_lip.sum())
        return Seal(missing, float(np.ptp(met)), float(met.mean()))
