"""One scan merged from several views of a scanner on an arm.

The poses that the robot's joints give put the points together.  Where the views show the same
surfaces these say how far a pose is off, and the view is moved by it, within bounds: more than
these is no noise of a calibration, and somebody has to look.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin
from scipy.spatial import KDTree

from workbench.model.cell import Cell
from workbench.model.derived.by_view import scans_by_view
from workbench.model.geometry import Floats, sampled, shift_and_turn
from workbench.model.robot import ScannedView
from workbench.model.scan import Scan
from workbench.perception.views.camera import are_within, picture_bounds, picture_of

COMPARED_AROUND = 0.02
"""[m] Points this far outside of the bin, and above its rim, are compared, too."""

MOST_POINTS = 8000
"""Of a view, by which it is compared."""

NEIGHBOURS = 12
"""Points by which the normal at a point is known."""

FLAT_SPREAD = 0.05
"""The least of the three spreads of neighbours over the middle one: more is no surface."""

ALIKE_NORMALS = 0.8
"""Cosine between the normals of what is the same place."""

FIRST_RADIUS, LAST_RADIUS = 0.03, 0.003
"""[m] Within this distance the same place is searched, at first and at last."""

FIT_ROUNDS = 20

SHIFT, TURN = 0.002, float(np.deg2rad(0.5))
"""[m], [rad] Deviations that poses are taken to have where the views do not show them."""

POINT_DEVIATION, INDEPENDENT_POINTS = 0.0005, 200.0
"""[m] Deviation of a point from the surface of another view, and how many points err independently:
neighbours share their errors."""

FEWEST_PAIRS = 200
"""Pairs of points with fewer of which nothing is compared."""

BEHIND = 0.006
"""[m] A view that measures further than this behind a point has seen through it."""

PIXEL_SPACINGS = 2.5
"""Width of the pixels in which views are compared over the distance of points."""

_Cloud = tuple[Floats, Floats]


def merged(cell: Cell, before: Scan | None, scan: Scan, name: str) -> Scan:
    """The scan together with those of other views that were taken before it.

    Args:
        cell: with the bin that all of them show.
        before: of other views, each with its name; None for none.
        scan: taken last, from where the scanner is now: its frame is that of the whole.
        name: of its view; an earlier scan of the same view goes.

    Returns:
        With `Scan.views`.  Each earlier view is moved onto those after it (`ScannedView`).
    """
    newest = ScannedView(name, len(scan.points), scan.T_world_scanner)
    scans = [
        each
        for each in (() if before is None else scans_by_view(before))
        if each.views[0].name != name
    ]
    if not scans:
        return replace(scan, views=(newest,))
    placed, views = [scan], [newest]
    for each in reversed(scans):
        view = _onto(cell, each, placed)
        views.insert(0, view)
        placed.append(replace(each, T_world_scanner=view.T_world_scanner))
    points = [_in_frame_of(scan, each, view) for each, view in zip(scans, views, strict=False)]
    colours = [each.colours for each in (*scans, scan)]
    painted = [some for some in colours if some is not None]
    return Scan(
        np.concatenate([*points, scan.points]),
        scan.T_world_scanner,
        f"merged: {', '.join(view.name for view in views)}",
        at=scan.at,
        # Where one of the views has no colours, nobody could tell which points have some.
        colours=np.concatenate(painted) if len(painted) == len(colours) else None,
        joints=scan.joints,
        views=tuple(views),
    )


def _in_frame_of(scan: Scan, other: Scan, view: ScannedView) -> Floats:
    T = scan.T_world_scanner.actInv(view.T_world_scanner)
    return other.points @ T.rotation.T + T.translation


def _onto(cell: Cell, scan: Scan, placed: Sequence[Scan]) -> ScannedView:
    """The view of a scan moved onto others, as far as it may be."""
    view = scan.views[0]
    T = _fit(_thin(cell, scan), [_thin(cell, other) for other in placed])
    middle = pin.SE3(np.eye(3), cell.bin.T_world_bin.translation)
    shift, turn = shift_and_turn(middle.inverse() * T * middle)
    # An earlier move counts, too.
    shift, turn = shift + view.shift, turn + view.turn
    moved = replace(view, T_world_scanner=T * view.T_world_scanner, shift=shift, turn=turn)
    if moved.is_off:
        return replace(moved, T_world_scanner=view.T_world_scanner)
    fitted = replace(scan, T_world_scanner=moved.T_world_scanner)
    shares = (
        share
        for other in placed
        for share in (_looked_through(cell, fitted, other), _looked_through(cell, other, fitted))
    )
    return replace(moved, through=round(max(shares), 6))


def _looked_through(cell: Cell, scan: Scan, other: Scan) -> float:
    """The share of a scan's points in and around the bin that another one sees nothing at."""
    T = other.T_world_scanner.inverse()
    p = _around(cell, scan) @ T.rotation.T + T.translation
    ahead = other.points[other.points[:, 2] > 0]
    image = picture_of(ahead)
    low, high = picture_bounds(image)
    is_in = are_within(image, low, high)
    image, depths = image[is_in], ahead[is_in, 2]
    width = PIXEL_SPACINGS * max(float(np.sqrt(np.prod(high - low) / len(image))), 1e-6)
    shape = np.floor((high - low) / width).astype(int) + 1
    nearest = np.full(shape, np.inf)
    np.minimum.at(nearest, tuple(np.floor((image - low) / width).astype(int).T), depths)
    p = p[p[:, 2] > 0]
    at = np.floor((p[:, :2] / p[:, 2:] - low) / width).astype(int)
    is_shown = ((at >= 0) & (at < shape)).all(axis=1)
    depth = nearest[tuple(at[is_shown].T)]
    behind = (depth - p[is_shown, 2])[np.isfinite(depth)]
    return float(np.mean(behind > BEHIND)) if len(behind) >= FEWEST_PAIRS else 0.0


def _around(cell: Cell, scan: Scan) -> Floats:
    """The points (n, 3) [m] of a scan in and around the bin, in the world."""
    points = scan.points_world
    p_bin = (points - cell.bin.T_world_bin.translation) @ cell.bin.T_world_bin.rotation
    half, top = cell.bin.size[:2] / 2 + COMPARED_AROUND, cell.bin.size[2] + COMPARED_AROUND
    return points[(np.abs(p_bin[:, :2]) <= half).all(axis=1) & (np.abs(p_bin[:, 2]) <= top)]


def _thin(cell: Cell, scan: Scan) -> _Cloud:
    """Some points (n, 3) [m] of a scan in and around the bin, and the normals there, in the world.

    Normals are zero where there is no surface.
    """
    points = _around(cell, scan)
    points = sampled(points, MOST_POINTS)
    if len(points) < NEIGHBOURS:
        return np.empty((0, 3)), np.empty((0, 3))
    _, nearest = KDTree(points).query(points, k=NEIGHBOURS)
    around = points[nearest]
    off = around - around.mean(axis=1, keepdims=True)
    spreads, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", off, off))
    normals = axes[:, :, 0]
    seen_from = scan.T_world_scanner.translation - points
    normals = normals * np.sign(np.einsum("nk,nk->n", normals, seen_from))[:, None]
    normals[spreads[:, 0] > FLAT_SPREAD * spreads[:, 1]] = 0.0
    return points, normals


def _fit(cloud: _Cloud, placed: Sequence[_Cloud]) -> pin.SE3:
    """The small motion in the world that brings a cloud onto the planes of the others.

    Gauss-Newton.  `SHIFT` and `TURN` weigh how far it goes from the given pose, so that it does not
    slide along what the views do not show.  Rounded, so that it is the same anywhere.
    """
    points, normals = cloud
    target, facing = (np.concatenate([each[k] for each in placed]) for k in (0, 1))
    T = pin.SE3.Identity()
    if not len(points) or not len(target):
        return T
    tree = KDTree(target)
    middle = points.mean(axis=0)
    prior = np.diag([1 / SHIFT**2] * 3 + [1 / TURN**2] * 3)
    for number in range(FIT_ROUNDS):
        reach = max(FIRST_RADIUS * 0.85**number, LAST_RADIUS)
        p = points @ T.rotation.T + T.translation
        away, nearest = tree.query(p, distance_upper_bound=reach)
        close = np.flatnonzero(np.isfinite(away))
        at = np.asarray(nearest)[close]
        same = np.einsum("nk,nk->n", normals[close] @ T.rotation.T, facing[at]) > ALIKE_NORMALS
        close, at = close[same], at[same]
        if len(close) < FEWEST_PAIRS:
            return pin.SE3.Identity()
        n = facing[at]
        off = np.einsum("nk,nk->n", p[close] - target[at], n)
        # What is far off shows something else.
        weight = np.square(1.0 - np.square(off / reach))
        rows = np.hstack([n, np.cross(p[close] - middle, n)])
        worth = INDEPENDENT_POINTS / float(weight.sum()) / POINT_DEVIATION**2
        gone = np.concatenate([T.act(middle) - middle, pin.log3(T.rotation)])
        step = np.linalg.solve(
            worth * (rows * weight[:, None]).T @ rows + prior,
            -worth * rows.T @ (weight * off) - prior @ gone,
        )
        turned = pin.exp3(np.asarray(step[3:], dtype=np.float64))
        T = pin.SE3(turned, middle + step[:3] - turned @ middle) * T
    # About the middle, to micrometres and microradians.
    shift, turn = np.round(T.act(middle) - middle, 6), np.round(pin.log3(T.rotation), 6)
    R = pin.exp3(turn)
    return pin.SE3(R, middle + shift - R @ middle)
