"""What two fingers close on: the part between them, seen along their travel."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.cell import Tool
from workbench.model.geometry import Box, Capsule, Cylinder, Floats, Ints, Mesh, Shape, Sphere
from workbench.planning.grasps.part_rays import RayGrid, tops

CELLS = 40
"""Of the grid, along the longer side of the fingers."""

SMALLEST = 0.0005
"""[m] Cells are no smaller."""

TOUCHING = 0.0004
"""[m] What a pad comes this near is touched by it: rubber gives way, meshes have facets."""


@dataclass(frozen=True, slots=True, eq=False)
class PadContact:
    """What two fingers close on.

    `width` [m] is the part's, from where the first finger meets it to where the second does;
    `offset` [m] how far its middle lies towards the first.  For each finger: the area [m2] that it
    touches, the mean outward normal (3,) there, in the TCP frame, its angle [rad] to the
    travel; and points (n, 3) [m] of where it touches, evenly spread, in the TCP frame, with the
    share (n,) of the pressure: less where the part curves away.
    """

    width: float
    offset: float
    areas: tuple[float, float]
    normals: tuple[Floats, Floats]
    slants: tuple[float, float]
    patches: tuple[tuple[Floats, Floats], tuple[Floats, Floats]]


def has_pads(tool: Tool) -> bool:
    """Whether a tool has two fingers that travel against each other, across its z."""
    if len(tool.fingers) != 2:
        return False
    first, second = (np.asarray(finger.direction) for finger in tool.fingers)
    across = np.cross(tool.T_flange_tcp.rotation[:, 2], first - second)
    return float(np.linalg.norm(across)) > 0.1


class Pads:
    """Two fingers of a tool (`has_pads`), as a grid of rays along their travel.

    Lifetime: as long as the tool; holds nothing of a part.
    """

    def __init__(self, tool: Tool):
        T_tcp_flange = tool.T_flange_tcp.inverse()
        travels = [T_tcp_flange.rotation @ finger.direction for finger in tool.fingers]
        travel = (travels[0] - travels[1]) / np.linalg.norm(travels[0] - travels[1])
        across = np.cross([0.0, 0.0, 1.0], travel)
        across /= np.linalg.norm(across)
        self.R_tcp_view = np.column_stack([across, np.cross(travel, across), travel])
        """The third axis is the travel of the first finger, the second one z of the TCP."""
        self.travel = travel
        self.R_tcp_closing = np.column_stack([-across, travel, np.cross(travel, across)])
        """Its second axis is the travel of the first finger, its third one z of the TCP."""
        hulls = [
            _hull(finger.solid.shape, T_tcp_flange * finger.solid.T_owner_shape)
            for finger in tool.fingers
        ]
        corners = [points @ self.R_tcp_view for points, _ in hulls]
        both = np.vstack(corners)
        low, high = both[:, :2].min(axis=0), both[:, :2].max(axis=0)
        step = max(float((high - low).max()) / CELLS, SMALLEST)
        shape = tuple(np.maximum(np.floor((high - low) / step), 1).astype(int).tolist())
        edge = (high - low - (np.array(shape) - 1) * step) / 2
        self.grid = RayGrid(float(low[0] + edge[0]), float(low[1] + edge[1]), step, shape)
        self._cell = float((high - low).prod()) / (shape[0] * shape[1])
        everywhere = np.full(shape, np.inf)
        # The inner faces when closed, as travels of each finger: NaN where it has none.
        self.inner = (
            -tops(corners[0], hulls[0][1], self.grid, everywhere, -1.0)[0],
            -tops(corners[1], hulls[1][1], self.grid, everywhere, 1.0)[0],
        )

    def hold(self, mesh: Mesh, T_tcp_part: pin.SE3, opening: float) -> PadContact | None:
        """What the fingers meet when they close from `opening` [m]; None when one meets nothing.

        A part that is wider than `opening` is measured as far as it reaches through.
        """
        view = pin.SE3(self.R_tcp_view.T, np.zeros(3)) * T_tcp_part
        points = np.asarray(mesh.points) @ view.rotation.T + view.translation
        triangles = self._near(points, mesh.triangles)
        if len(triangles) == 0:
            return None
        starts = [inner + opening / 2 for inner in self.inner]
        rooms: list[float] = []
        touched: list[tuple[float, Floats]] = []
        patches: list[tuple[Floats, Floats]] = []
        u, v = self.grid.centres
        for start, other, sense in ((starts[0], starts[1], 1.0), (starts[1], starts[0], -1.0)):
            height, met = tops(points, triangles, self.grid, start, sense)
            # What lies behind the other finger is not between them.
            height = np.where(height > -np.where(np.isnan(other), np.inf, other), height, np.nan)
            room = start - height
            if np.isnan(room).all():
                return None
            least = float(np.nanmin(room))
            touches = room < least + TOUCHING
            rooms.append(least)
            touched.append(self._contact(points, triangles, met[touches]))
            there = np.column_stack([u[touches], v[touches], sense * height[touches]])
            depths = TOUCHING - (room[touches] - least)  # what is pressed in deeper bears more
            patches.append((there @ self.R_tcp_view.T, depths / depths.sum()))
        slants = tuple(
            float(np.arccos(np.clip(sense * normal[2], -1.0, 1.0)))
            for (_, normal), sense in zip(touched, (1.0, -1.0), strict=True)
        )
        normals = tuple(self.R_tcp_view @ normal for _, normal in touched)
        return PadContact(
            opening - rooms[0] - rooms[1],
            (rooms[1] - rooms[0]) / 2,
            (touched[0][0], touched[1][0]),
            (normals[0], normals[1]),
            (slants[0], slants[1]),
            (patches[0], patches[1]),
        )

    def _near(self, points: Floats, triangles: Ints) -> Ints:
        """Triangles that a ray of the grid may meet."""
        low = np.array([self.grid.u, self.grid.v])
        high = low + self.grid.step * (np.array(self.grid.shape) - 1)
        return _meeting(points, triangles, low, high)

    def _contact(self, points: Floats, triangles: Ints, met: Ints) -> tuple[float, Floats]:
        """Area and mean normal, in the view frame, where triangles were met."""
        kinds, times = np.unique(met, return_counts=True)
        a, b, c = points[triangles[kinds].T]
        across = np.cross(b - a, c - a)
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        normal = times @ across
        return len(met) * self._cell, normal / max(float(np.linalg.norm(normal)), 1e-12)


@njit(cache=True)
def _meeting(P: Floats, triangles: Ints, low: Floats, high: Floats) -> Ints:
    """Triangles (k, 3) by points (n, 3) [m] of which not all lie on one side of a box (2,) [m]."""
    sides = np.zeros(len(P), np.uint8)
    for n in range(len(P)):
        for i in range(2):
            sides[n] |= (P[n, i] < low[i]) << i | (P[n, i] > high[i]) << (2 + i)
    met, count = np.empty_like(triangles), 0
    for a, b, c in triangles:
        if sides[a] & sides[b] & sides[c] == 0:
            met[count, 0], met[count, 1], met[count, 2] = a, b, c
            count += 1
    return met[:count].copy()


def _hull(shape: Shape, T_tcp_shape: pin.SE3) -> tuple[Floats, Ints]:
    """Corners (n, 3) [m] in the TCP frame and triangles of the hull of a shape, facing outward."""
    from scipy.spatial import ConvexHull  # takes a while, and planning asks for no hulls

    hull = ConvexHull(outline(shape))
    corners, triangles = hull.points, hull.simplices.copy()
    a, b, c = corners[triangles.T]
    looks_in = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles[looks_in] = triangles[looks_in][:, ::-1]
    return corners @ T_tcp_shape.rotation.T + T_tcp_shape.translation, triangles


def outline(shape: Shape) -> Floats:
    """Points (n, 3) [m] of a shape's surface, in its frame, whose hull is nearly the shape's."""
    turns = np.arange(32) * np.pi / 16
    ring = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(32)])
    rise = np.linspace(-np.pi / 2, np.pi / 2, 9)[:, None, None]
    ball = (np.cos(rise) * ring + np.sin(rise) * [0.0, 0.0, 1.0]).reshape(-1, 3)
    match shape:
        case Box(size=size):
            signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
            return signs * np.asarray(size)
        case Cylinder(radius=radius, length=length):
            ends = np.array([[0.0, 0.0, -length / 2], [0.0, 0.0, length / 2]])
            return (ends[:, None] + radius * ring).reshape(-1, 3)
        case Capsule(radius=radius, length=length):
            ends = np.array([[0.0, 0.0, -length / 2], [0.0, 0.0, length / 2]])
            return (ends[:, None] + radius * ball).reshape(-1, 3)
        case Sphere(radius=radius):
            return radius * ball
        case Mesh(points=points):
            return np.asarray(points)
