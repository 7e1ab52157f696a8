"""Whether views fit each other: what one has measured, others must not look through.

How far views lie apart where they show the same place says nothing of a pose that is far off:
the places that are the same are searched for near each other.
"""

from collections.abc import Sequence

import numpy as np

from workbench.extras.reconstruction.depth_views import DepthView
from workbench.extras.reconstruction.fusion import AGREED
from workbench.model.geometry import Bools, Floats, transform


def looked_through(views: Sequence[DepthView], gate: float) -> Floats:
    """The share (n,), 0..1, of what each view measured of the part that others see nothing at.

    Args:
        views: n of them, in the model's frame.
        gate: [m] a view that measures further than this behind a point has seen through it.  It
            takes as many such views as carve a surface away.
    """
    shares: list[float] = []
    for view in views:
        T = view.T_model_camera
        points = transform(T, view.points()[0])
        through = np.zeros(len(points), dtype=np.int32)
        for other in views:
            if other is not view:
                through += _looks_through(other, points, gate)
        shares.append(float(np.mean(through >= AGREED)))
    return np.array(shares)


def _looks_through(view: DepthView, points: Floats, gate: float) -> Bools:
    """Whether a view has measured something far behind points (n, 3) [m] of the model, (n,)."""
    T = view.T_model_camera.inverse()
    p = transform(T, points)
    rows, columns = view.camera.shape
    pixel = np.rint(p[:, :2] / p[:, 2:] * view.camera.focal + view.camera.centre).astype(int)
    is_in = ((pixel >= 0) & (pixel < (columns, rows))).all(axis=1)
    behind = np.zeros(len(points))
    behind[is_in] = view.depth[pixel[is_in, 1], pixel[is_in, 0]] - p[is_in, 2]
    return behind > gate
