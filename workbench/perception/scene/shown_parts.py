"""Which parts a scan shows at their believed poses: others may not be there."""

import numpy as np
import open3d as o3d

from workbench.model.cell import Cell
from workbench.model.geometry import Bools
from workbench.model.scan import Detection, Scan
from workbench.perception.scene.unexplained import EXPLAINED_WITHIN, known_surfaces

FEWEST_POINTS = 10
"""Points near the surface of a part by which it is seen; a wire of 0.1 m at 1 m shows more."""

ASIDE = EXPLAINED_WITHIN / 2
"""[m] Half of a part's points are no farther from its surface: else it lies elsewhere."""


def shown(cell: Cell, scan: Scan, detections: tuple[Detection, ...]) -> Bools:
    """Whether a scan shows each part at its believed pose.

    A point belongs to the surface that it is nearest to, of parts, bin and fixtures.  So a part
    that lies elsewhere, or is not there, has none, or has them off its surface.

    Args:
        cell: bin and fixtures.
        scan: what was seen.
        detections: the parts.

    Returns:
        For each part (k,), no unit.
    """
    T, near = scan.T_world_scanner, np.zeros(len(scan.points), bool)
    for detection in detections:
        reach = (
            float(np.linalg.norm(cell.part(detection.part).mesh.points, axis=1).max())
            + EXPLAINED_WITHIN
        )
        off = scan.points - T.actInv(detection.T_world_part.translation)
        near |= np.einsum("ij,ij->i", off, off) <= reach**2
    points = scan.points[near] @ T.rotation.T + T.translation
    scene, owners = known_surfaces(cell, detections)
    queries = np.ascontiguousarray(points, dtype=np.float32)
    if not len(points):
        return np.zeros(len(detections), bool)
    found = scene.compute_closest_points(o3d.core.Tensor(queries), nthreads=1)
    away = np.linalg.norm(found["points"].numpy() - queries, axis=1)
    whose = owners[found["geometry_ids"].numpy().astype(np.int64)]
    of = [away[(whose == k) & (away <= EXPLAINED_WITHIN)] for k in range(len(detections))]
    return np.array(
        [len(far) >= FEWEST_POINTS and float(np.median(far)) <= ASIDE for far in of], bool
    )
