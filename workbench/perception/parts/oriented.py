"""Points with normals: what surfaces and scans are to the localizer."""

from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats, own


@dataclass(frozen=True, slots=True, eq=False)
class OrientedPoints:
    """Points (n, 3) [m] of a surface and its unit normals there (n, 3)."""

    points: Floats
    normals: Floats

    def __post_init__(self) -> None:
        own(self, "points", "normals")

    def __len__(self) -> int:
        return len(self.points)

    def __getitem__(self, chosen: np.ndarray) -> "OrientedPoints":
        return OrientedPoints(self.points[chosen], self.normals[chosen])

    def thinned(self, spacing: float) -> "OrientedPoints":
        """One point for each cube of `spacing` [m] and each main direction of the normal.

        Points of both faces of an edge stay, where plain down-sampling would keep one of them.
        """
        cubes = np.floor((self.points - self.points.min(axis=0)) / spacing).astype(np.int64)
        axis = np.abs(self.normals).argmax(axis=1)
        side = np.take_along_axis(self.normals, axis[:, None], axis=1)[:, 0] > 0
        key = np.concatenate([cubes, (2 * axis + side)[:, None]], axis=1)
        return self[np.sort(np.unique(key, axis=0, return_index=True)[1])]
