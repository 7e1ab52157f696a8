"""A part alone and large in one browser, with its grasps, while others see the cell."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pinocchio as pin
import viser

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.marks import add_lines
from workbench.gui.scene.robot import add_solids, place
from workbench.gui.shared.colours import BAD, BRAND, BUSY, GOOD, MUTED, rgb_of
from workbench.gui.shared.solids import Colour, with_hard_edges
from workbench.model.cell import Tool
from workbench.model.geometry import Floats
from workbench.model.part import Grasp, Part, grasps_of

STAGE = "/stage"
"""Name of the part's frame in the scene; all that is shown with it lies below."""

T_WORLD_STAGE = pin.SE3(np.eye(3), np.array([0.0, 0.0, 1000.0]))
"""Where the part is: this far above the cell that nothing of it is seen."""

PART_COLOUR = (173, 181, 189)
AXIS_LENGTH = 0.8
"""Length of the part's axes by its size."""

STEM = 0.12
"""Length of the mark of a grasp by the size of the part."""

Pressed = Callable[[Floats, Floats], None]
"""Gets the origin (3,) [m] and direction (3,) of a ray in the part's frame."""


class GraspStage:
    """The part, the marks of its grasps, and the tool where the chosen one has it.

    Lifetime: as long as its browser; `open` and `close` as often as wanted.

    Concurrency: one thread at a time.
    """

    def __init__(self, client: viser.ClientHandle):
        """Nothing is shown yet."""
        self._client = client
        self._scene = client.scene
        self._camera: tuple[Any, Any] | None = None
        self._clicked: Any = None
        self._size = 0.1
        self._drawn: Part | None = None
        self._tool: str = ""
        self._hand: viser.FrameHandle | None = None
        self._meshes: list[viser.MeshHandle] = []
        self._fingers: list[tuple[Floats, viser.FrameHandle]] = []

    @property
    def is_open(self) -> bool:
        """Whether the browser looks at the part instead of the cell."""
        return self._camera is not None

    def open(self, part: Part, pressed: Pressed) -> None:
        """Look at the part; `pressed` is called with where somebody clicks."""
        camera = self._client.camera
        self._camera = camera.position, camera.look_at
        self._size = size_of(part)
        root = self._scene.add_frame(
            STAGE,
            axes_length=self._size * AXIS_LENGTH,
            axes_radius=self._size * 0.006,
            origin_radius=self._size * 0.012,
        )
        place(root, T_WORLD_STAGE)
        with self._client.atomic():
            camera.position, camera.look_at = view_of(part)

        @self._scene.on_click()
        def click(event: Any) -> None:
            origin = np.array(event.ray_origin, dtype=np.float64)
            direction = np.array(event.ray_direction, dtype=np.float64)
            if np.all(np.isfinite([origin, direction])) and np.linalg.norm(direction) > 0.5:
                pressed(origin - T_WORLD_STAGE.translation, direction)

        self._clicked = click

    def close(self) -> None:
        """Look at the cell again, from where it was viewed."""
        self._scene.remove_by_name(STAGE)
        if self._clicked is not None:
            self._scene.remove_click_callback(self._clicked)
        if self._camera is not None:
            with self._client.atomic():
                self._client.camera.position, self._client.camera.look_at = self._camera
        self._camera, self._drawn, self._tool, self._hand = None, None, "", None
        self._clicked = None

    def draw(self, part: Part, chosen: str, bad: frozenset[str]) -> None:
        """Draw part and marks as they are now.

        Args:
            part: whose surface and grasps.
            chosen: entry whose marks stand out.
            bad: entries that cannot be taken so.
        """
        if self._drawn is None or self._drawn.mesh is not part.mesh:
            points, triangles = with_hard_edges(triangles_of(part.mesh))
            self._scene.add_mesh_simple(
                "/stage/part", points, triangles, color=PART_COLOUR, side="double"
            )
        self._drawn = part
        segments, colours = marks_of(part, chosen, bad, self._size)
        self._scene.remove_by_name("/stage/marks")
        if len(segments):
            add_lines(self._scene, "/stage/marks", segments, colours, 2.5)

    def show_tool(self, tool: Tool, T_part_tcp: pin.SE3, opening: float, is_ok: bool) -> None:
        """Show the tool with its fingers apart by `opening` [m]; red when it cannot be so."""
        if self._tool != tool.name or self._hand is None:
            self._add_tool(tool)
        colour = rgb_of(GOOD if is_ok else BAD)
        with self._client.atomic():
            if self._hand is not None:
                place(self._hand, T_part_tcp * tool.T_flange_tcp.inverse())
            for direction, node in self._fingers:
                node.position = opening / 2 * direction
            for mesh in self._meshes:
                if mesh.color != colour:
                    mesh.color = colour

    def hide_tool(self) -> None:
        """Show no tool."""
        self._scene.remove_by_name("/stage/tool")
        self._hand, self._tool = None, ""

    def mark(self, point: Floats | None) -> None:
        """Mark a point (3,) [m] of the surface; None: no point."""
        if point is None:
            self._scene.remove_by_name("/stage/point")
            return
        x, y, z = point.tolist()
        self._scene.add_icosphere(
            "/stage/point", self._size * 0.025, rgb_of(BRAND), position=(x, y, z)
        )

    def show_sphere(self, directions: Floats, colours: Any) -> None:
        """Show something about every unit direction (n, 3) as seen from around the part."""
        self._scene.add_point_cloud(
            "/stage/sphere",
            (directions * self._size * 1.1).astype(np.float32),
            colours,
            point_size=self._size * 0.035,
            point_shape="circle",
            precision="float32",
        )

    def hide_sphere(self) -> None:
        """Show nothing around the part."""
        self._scene.remove_by_name("/stage/sphere")

    def _add_tool(self, tool: Tool) -> None:
        self._scene.remove_by_name("/stage/tool")
        self._hand = self._scene.add_frame("/stage/tool", show_axes=False)
        self._tool, self._fingers = tool.name, []
        add = partial(add_solids, self._scene, colour=rgb_of(GOOD), opacity=0.3)
        self._meshes = add("/stage/tool/body", tool.body)
        for finger in tool.fingers:
            name = f"/stage/tool/{finger.solid.name}"
            node = self._scene.add_frame(name, show_axes=False)
            self._fingers.append((np.asarray(finger.direction), node))
            self._meshes += add(f"{name}/visual", (finger.solid,))


def size_of(part: Part) -> float:
    """The longest side of the part's box [m]."""
    return float(np.ptp(np.asarray(part.mesh.points), axis=0).max())


def view_of(part: Part) -> tuple[Floats, Floats]:
    """From where the part is viewed first, and to which point, each (3,) [m] in the world."""
    points = np.asarray(part.mesh.points)
    middle = T_WORLD_STAGE.act((points.min(axis=0) + points.max(axis=0)) / 2)
    return middle + size_of(part) * np.array([2.1, -2.4, 1.5]), middle


def marks_of(
    part: Part, chosen: str, bad: frozenset[str], size: float
) -> tuple[Floats, np.ndarray]:
    """For each grasp a fork: where the hand comes from, and how far its fingers are apart.

    Returns:
        Segments (n, 2, 3) [m] in the part's frame, and their colours (n, 2, 3) 0..255.
    """
    segments: list[Floats] = []
    colours: list[Colour] = []
    for entry in part.library.entries:
        for grasp in grasps_of(entry):
            fork = fork_of(grasp, STEM * size)
            segments.append(fork)
            if entry.name in bad:
                colour = rgb_of(BAD)
            elif entry.name == chosen:
                colour = rgb_of(BRAND)
            else:
                colour = rgb_of(BUSY if grasp.is_enabled else MUTED)
            colours += [colour] * len(fork)
    if not segments:
        return np.zeros((0, 2, 3)), np.zeros((0, 2, 3))
    painted = np.repeat(np.array(colours, dtype=np.uint8)[:, None], 2, axis=1)
    return np.concatenate(segments), painted


def fork_of(grasp: Grasp, stem: float) -> Floats:
    """Segments (n, 2, 3) [m] of a grasp's mark, its stem so long [m]."""
    half = max(grasp.opening / 2, 0.15 * stem)
    tips = [np.array([0.0, side * half, 0.0]) for side in (1, -1)]
    roots = [tip - np.array([0.0, 0.0, stem]) for tip in tips]
    middle = np.array([0.0, 0.0, -stem])
    lines = [
        (tips[0], roots[0]),
        (tips[1], roots[1]),
        (roots[0], roots[1]),
        (middle, 2 * middle),
    ]
    return np.array([[grasp.T_part_tcp.act(end) for end in line] for line in lines])


def nearest_entry(part: Part, origin: Floats, direction: Floats, size: float) -> str:
    """The entry whose mark a ray passes closest to, if that is close enough to be meant.

    The ray begins at `origin` (3,) [m], its `direction` (3,) is of any length; `size` [m] is that
    of the part.
    """
    ray = direction / np.linalg.norm(direction)
    best, name = 0.035 * size, ""
    for entry in part.library.entries:
        for grasp in grasps_of(entry):
            top = grasp.T_part_tcp.act(np.array([0.0, 0.0, -1.5 * STEM * size])) - origin
            beside = float(np.linalg.norm(top - (top @ ray) * ray))
            if beside < best:
                best, name = beside, entry.name
    return name
