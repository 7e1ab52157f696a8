"""A part's surface from several scans: the steps one after the other."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.extras.reconstruction.agreement import looked_through
from workbench.extras.reconstruction.alignment import aligned, as_given
from workbench.extras.reconstruction.depth_views import (
    Bounds,
    DepthView,
    depth_view,
    pixel_width,
)
from workbench.extras.reconstruction.fusion import fused
from workbench.extras.reconstruction.surface import closed_surface, simplified, unseen_share
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Mesh, transform
from workbench.model.scan import Scan

FEWEST_SCANS, MOST_SCANS = 3, 200
"""Scans: two leave most of a part unseen."""

VOXELS = 30_000_000
"""At most, for the memory's sake."""

NARROWEST_VOXEL = 0.0002
"""[m] Scanners tell no more."""

TRUNCATION = 4.0
"""[voxels] Noise and errors of poses must be less, and walls thicker than half of it."""

SURFACE_TOLERANCE = 0.0002
"""[m] By so much the surface may change for the sake of fewer triangles."""

LEAST_SHARED = 0.25
"""Of what a scan shows of the part: so much at least others show too, or nothing says that its pose
is right."""

MOST_LOOKED_THROUGH = 0.05
"""Of what a scan shows of the part: where others see through more, its pose is wrong."""

SEEN = 2.0
"""[voxels] What is no further from a measured point was seen."""


@dataclass(frozen=True, slots=True, eq=False)
class Reconstruction:
    """A closed surface, and how reliable it is.

    Attributes:
        mesh: the surface [m], in the world frame of the scans.
        unseen: share of its area (0..1) that no scan shows and that was closed.
        voxel: width of the voxels [m].
        Ts_model_scanner: poses of the scans, as given or refined.
        apart: median distance of a scan's points from the other scans [m], with the given and
            with the used poses.
        shared: smallest share (0..1) of a scan's view of the part that other scans show, too.
    """

    mesh: Mesh
    unseen: float
    voxel: float
    Ts_model_scanner: tuple[pin.SE3, ...]
    apart: tuple[float, float]
    shared: float


def reconstruct(
    scans: Sequence[Scan],
    bounds: Bounds,
    *,
    voxel: float | None = None,
    tolerance: float = SURFACE_TOLERANCE,
    refine: bool = True,
) -> Reconstruction:
    """Merge scans of one part, taken from known poses, into one closed surface.

    Args:
        scans: `T_world_scanner` is the pose of the scanner in the model's frame, which is fixed to
            the part, its turntable, or the flange that holds it.
        bounds: a box that contains the part and nothing else.
        voxel: width of the voxels [m]; None: that of the scans' pixels.
        tolerance: of the simplification [m].
        refine: whether to align the scans with each other (`alignment`) and refuse those that do
            not fit; False uses the given poses.

    Raises:
        InputError: too few scans, no part in the region, or voxels too small for it; or a scan
            shows nothing there, overlaps with no other scan, or does not fit the others.
    """
    if not FEWEST_SCANS <= len(scans) <= MOST_SCANS:
        raise InputError(
            f"{FEWEST_SCANS} to {MOST_SCANS} scans are expected, {len(scans)} are given"
        )
    size = bounds.high - bounds.low
    if voxel is None:
        pixels = float(np.median([pixel_width(scan, bounds) for scan in scans]))
        voxel = max(pixels, NARROWEST_VOXEL, float(np.cbrt(np.prod(size) / VOXELS)))
    count = float(np.prod(size / voxel))
    if count > VOXELS:
        raise InputError(
            f"voxels of {voxel * 1000:g} mm would be {count / 1e6:.0f} million in the region, at "
            f"most {VOXELS / 1e6:.0f} million are used; make them larger or the region smaller"
        )
    views = [depth_view(scan, bounds) for scan in scans]
    for scan, view in zip(scans, views, strict=True):
        if len(view.points()[0]) == 0:
            raise InputError(f"{scan.source}: nothing in the region is seen surely enough")
    fit = aligned(views) if refine else as_given(views)
    if not fit.shared.any():
        raise InputError(
            "no two scans show the same place of the part: scan it from more sides, and see "
            "whether the poses are right"
        )
    if refine:
        views = [
            replace(view, T_model_camera=T)
            for view, T in zip(views, fit.Ts_model_camera, strict=True)
        ]
        _refuse_what_does_not_fit(scans, views, fit.shared, TRUNCATION * voxel)
    field, origin = fused(views, bounds, voxel, TRUNCATION * voxel)
    surface = closed_surface(field, origin, voxel)
    poses = tuple(view.T_model_camera for view in views)
    measured = np.concatenate(
        [transform(T, view.points()[0]) for view, T in zip(views, poses, strict=True)]
    )
    unseen = unseen_share(surface, measured, SEEN * voxel)
    fewer = simplified(surface, tolerance)
    mesh = Mesh(fewer.vertices, fewer.faces)
    apart = (fit.given, fit.now)
    return Reconstruction(mesh, unseen, voxel, poses, apart, float(fit.shared.min()))


def _refuse_what_does_not_fit(
    scans: Sequence[Scan], views: Sequence[DepthView], shared: Floats, gate: float
) -> None:
    """Name the scan that fits the others least, if that is too little for a model to be true."""
    through = looked_through(views, gate)
    worst = int(np.argmax(through))
    if through[worst] > MOST_LOOKED_THROUGH:
        raise InputError(
            f"{scans[worst].source}: where it shows the part other scans look through in "
            f"{through[worst]:.0%} of its points; is its pose right?"
        )
    alone = int(np.argmin(shared))
    if shared[alone] < LEAST_SHARED:
        raise InputError(
            f"{scans[alone].source}: only {shared[alone]:.0%} of what it shows of the part other "
            "scans show too; is its pose right, and are there scans from sides beside it?"
        )
