"""Poses of a tool made from a place on a part's surface, and openings from what is there."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, Mesh
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.pads import outline
from workbench.planning.grasps.part_rays import NO_TRIANGLE, first_hits, nearest_points, normals_of

BEYOND = 0.003
"""[m] Finger tips go this much beyond the middle of what they hold: pads, not tips, touch it."""

SPARE = 0.0005
"""[m] Finger tips stay this far above the underside of a thin part."""

PALM_ROOM = 0.002
"""[m] Between the palm and the surface."""

PLAY = 0.005
"""[m] Of air on each side of the part between open fingers."""

CLOSING_DIRECTIONS = 12
"""Directions tried in which the fingers may close, over half a turn."""

SAME_WIDTH = 0.0002
"""[m] Widths that differ less are the same."""


@dataclass(frozen=True, slots=True)
class Opening:
    """Finger distances [m] for a part between them: on arrival and when closed."""

    opening: float
    grip: float


def fitted_opening(checker: GraspChecker, T_part_tcp: pin.SE3) -> Opening | None:
    """Finger distances for the part that is between the fingers at a pose, as grasps state them.

    None when nothing is there, or the tool has not two fingers.  Both are within the tool's stroke
    unless the part, or its tolerance, is wider.
    """
    hold = checker.hold(T_part_tcp)
    if hold is None:
        return None
    low, high = checker.tool.stroke
    high -= 2 * (checker.part.tolerance or 0.0)
    grip = max(hold.width, low)
    return Opening(max(min(grip + 2 * (abs(hold.offset) + PLAY), high), grip), grip)


def frame_at(checker: GraspChecker, point: Floats, normal: Floats) -> pin.SE3:
    """`T_part_tcp` for a place on the surface: the tool comes against the normal.

    z points against the normal; x lies along the part's longer extent there, so that fingers close
    across the shorter one.  Fingers have what they close on in their middle; they go in to a little
    beyond the middle of what is under the point, no deeper than two thirds of their length.  A cup
    stands on the point.

    Args:
        checker: of part and tool.
        point: (3,) [m] on the surface.
        normal: (3,), outward.
    """
    z = -np.asarray(normal) / np.linalg.norm(normal)
    position = np.asarray(point) + _depth(checker, point, z) * z
    frames = [_frame(position, z, x) for x in _across(z)]
    if checker.pads is None:
        return frames[0]
    widths: list[float] = []
    for T in frames:
        hold = checker.hold(T)
        widths.append(np.inf if hold is None else hold.width)
    # The first of those that are as narrow: it lies along an axis of the part.
    narrow = int(np.flatnonzero(np.array(widths) <= min(widths) + SAME_WIDTH)[0])
    return centre_on_grip(checker, frames[narrow])


def snap_to_surface(checker: GraspChecker, T_part_tcp: pin.SE3) -> pin.SE3:
    """A pose moved onto the surface where the tool comes in, and turned square to it.

    That is where the tool's way along its z meets the part first, or else the nearest point.  x
    stays as near as it can to where it was; the depth is that of `frame_at`.
    """
    mesh = checker.part.mesh
    z, origin = T_part_tcp.rotation[:, 2], T_part_tcp.translation
    far = float(np.linalg.norm(mesh.points - origin, axis=1).max()) * 1.01
    start = origin - far * z
    distances, met = first_hits(mesh, start[None], z[None])
    if met[0] == NO_TRIANGLE:
        points, _, met = nearest_points(mesh, origin[None])
        point = points[0]
    else:
        point = start + distances[0] * z
    inward = -outward_normal(mesh, int(met[0]))
    x = T_part_tcp.rotation[:, 0]
    if abs(float(x @ inward)) > 0.99:
        x = T_part_tcp.rotation[:, 1]
    return centre_on_grip(
        checker, _frame(point + _depth(checker, point, inward) * inward, inward, x)
    )


def centre_on_grip(checker: GraspChecker, T_part_tcp: pin.SE3) -> pin.SE3:
    """The pose moved along the fingers' travel until what they close on is in their middle."""
    hold = checker.hold(T_part_tcp)
    if hold is None or checker.pads is None:
        return T_part_tcp
    return T_part_tcp * pin.SE3(np.eye(3), hold.offset * checker.pads.travel)


def outward_normal(mesh: Mesh, triangle: int) -> Floats:
    """The outward unit normal (3,) of a triangle."""
    return normals_of(mesh)[0][triangle]


def thickness(mesh: Mesh, points: Floats, inward: Floats) -> Floats:
    """How far it is (n,) [m] from points (n, 3) on or in a body to its other side, along (n, 3).

    A point a little outside, as one on a smooth surface above its facets, counts as on it.
    """
    skin = 1e-6
    starts = points + skin * inward
    far, met = first_hits(mesh, starts, inward)
    enters = np.einsum("ij,ij->i", normals_of(mesh)[0][met], inward) < 0
    enters &= np.isfinite(far)
    if enters.any():
        again = starts[enters] + (far[enters, None] + skin) * inward[enters]
        far[enters] += skin + first_hits(mesh, again, inward[enters])[0]
    return far + skin


def palm_distance(checker: GraspChecker) -> float:
    """How far [m] the TCP lies in front of what is no finger."""
    tool = checker.tool
    T_tcp_flange = tool.T_flange_tcp.inverse()
    tops = [
        ((T_tcp_flange * s.T_owner_shape).act(corner)[2])
        for s in tool.body
        for corner in outline(s.shape)
    ]
    return max(0.0, -max(tops, default=-np.inf))


def _depth(checker: GraspChecker, point: Floats, inward: Floats) -> float:
    """How deep the tips go in under a point; 0 for a cup."""
    if checker.pads is None:
        return 0.0
    thick = float(thickness(checker.part.mesh, np.asarray(point)[None], inward[None])[0])
    length = palm_distance(checker)
    deepest = max(0.0, min(length * 2 / 3, length - PALM_ROOM))
    return float(min(thick / 2 + BEYOND, max(thick - SPARE, thick / 2), deepest))


def _across(z: Floats) -> list[Floats]:
    """Directions square to z, the part's own axes first."""
    flat = np.eye(3) - np.outer(z, z)
    axes = sorted(np.eye(3), key=lambda axis: abs(float(axis @ z)))
    first = flat @ axes[0]
    first /= np.linalg.norm(first)
    second = np.cross(z, first)
    turns = np.arange(1, CLOSING_DIRECTIONS) * np.pi / CLOSING_DIRECTIONS
    own = [flat @ axis for axis in axes[:2] if np.linalg.norm(flat @ axis) > 0.1]
    return [*own, *(np.cos(turn) * first + np.sin(turn) * second for turn in turns)]


def _frame(position: Floats, z: Floats, x: Floats) -> pin.SE3:
    """The pose there with that z, and x as near to the one given as it can be."""
    y = np.cross(z, x)
    y /= np.linalg.norm(y)
    return pin.SE3(np.column_stack([np.cross(y, z), y, z]), np.asarray(position))
