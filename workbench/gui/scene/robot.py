"""A robot with its tools in the scene: added once, then only moved."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import replace

import numpy as np
import pinocchio as pin
import viser

from workbench.gui.shared.colours import NOT_REPORTED
from workbench.gui.shared.solids import Colour, by_colour
from workbench.model.cell import Arm, Cell, Finger
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Solid
from workbench.model.tools.slots import tool_of_arm

ROBOT, PLANNED, ROBOT_CHECKED = "/robot", "/planned", "/robot_checked"
"""Nodes that all browsers share: the real robot, solid; the planned one; and as it is checked."""


LIGHTNESS = (0.299, 0.587, 0.114)
"""What red, green and blue add to how light a colour is."""

LIGHTNESS_SHARE = 0.25
"""So much of the differences in lightness stays in a robot without its colours."""


class DrawnRobot:
    """Every link, tool and finger as a node that follows its link."""

    def __init__(
        self,
        scene: viser.SceneApi,
        name: str,
        cell: Cell,
        *,
        arms: Sequence[Arm] | None = None,
        colour: Colour | None = None,
        opacity: float | None = None,
        is_visible: bool = True,
        as_checked: bool = False,
    ):
        """Add the nodes.

        Args:
            scene: where.
            name: of the node that holds all others, such as `/robot`.
            cell: whose robot and tools.
            arms: draw the links of these only, as far as they move; None draws everything.
            colour: of everything; None keeps that of each solid.
            opacity: 0..1; None is solid.
            is_visible: whether to show it now.
            as_checked: draw what is checked for collisions instead of what it looks like.
        """
        self._scene = scene
        self._colour = colour
        self._opacity = opacity
        self._meshes: list[viser.MeshHandle] = []
        self._own: list[Colour] = []
        self._is_drained = False
        self.root = scene.add_frame(name, show_axes=False, visible=is_visible)
        self._links: dict[str, viser.FrameHandle] = {}
        self._fingers: dict[str, list[tuple[Finger, viser.FrameHandle]]] = {}
        self._shown: dict[str, Floats] = {}
        self._moved = {arm.name: moved_by(cell, arm) for arm in arms or cell.arms}
        drawn = None if arms is None else set[str]().union(*self._moved.values())
        for link in cell.robot.links:
            if drawn is not None and link.name not in drawn:
                continue
            node = scene.add_frame(f"{name}/{link.name}", show_axes=False)
            self._links[link.name] = node
            solids = link.collision if as_checked else link.visual
            self._add(f"{name}/{link.name}/visual", solids)
        self._tools: dict[str, dict[str, viser.FrameHandle]] = {}
        for arm in cell.arms if arms is None else arms:
            self._add(f"{name}/{arm.flange}/scanner", cell.scanner.housing_of(arm.name))
            self._fingers[arm.name], self._tools[arm.name] = [], {}
            slots = (tool_of_arm(arm, slot.tool) for slot in arm.tool_slots)
            for tool in {tool.name: tool for tool in (arm.tool, *slots)}.values():
                self._add_tool(name, replace(arm, tool=tool), is_carried=tool is arm.tool)

    def pose(self, Ts_world_link: Mapping[str, pin.SE3], openings: Mapping[str, float]) -> None:
        """Move everything.

        Args:
            Ts_world_link: pose of every link by name.
            openings: finger distance of each arm's tool by arm name [m].
        """
        for name, node in self._links.items():
            T = Ts_world_link[name]
            if self._is_new(name, T.homogeneous):
                place(node, T)
        for arm, fingers in self._fingers.items():
            opening = openings.get(arm, 0.0)
            for finger, node in fingers:
                shift = opening / 2 * finger.direction
                if self._is_new(node.name, shift):
                    node.position = shift

    def carry(self, tools: Mapping[str, str | None]) -> None:
        """Show the tools that arms carry, by name; empty: a bare flange; None: the mounted one."""
        for arm, nodes in self._tools.items():
            mounted, wanted = next(iter(nodes)), tools.get(arm)
            for tool, node in nodes.items():
                is_carried = tool == (mounted if wanted is None else wanted)
                if node.visible != is_carried:
                    node.visible = is_carried

    def show(self, is_visible: bool) -> None:
        """Show or hide it as a whole."""
        if self.root.visible != is_visible:
            self.root.visible = is_visible

    def show_arms(self, arms: Set[str]) -> None:
        """Show what moves with these arms, and hide the others; what they stand on stays."""
        for arm, links in self._moved.items():
            for name in links:
                self._links[name].visible = arm in arms

    def paint(self, colour: Colour) -> None:
        """Give everything one colour."""
        for mesh in self._meshes:
            mesh.color = colour

    def drain(self, is_drained: bool) -> None:
        """Take the colours away, or give them back."""
        if is_drained == self._is_drained:
            return
        self._is_drained = is_drained
        for mesh, own in zip(self._meshes, self._own, strict=True):
            mesh.color = drain_colour(own) if is_drained else own

    def _add_tool(self, name: str, arm: Arm, *, is_carried: bool) -> None:
        """Add the tool of an arm below the robot's node, to be seen while it is carried."""
        tool = f"{name}/{arm.flange}/{arm.tool.name}"
        frame = self._scene.add_frame(tool, show_axes=False, visible=is_carried)
        self._tools[arm.name][arm.tool.name] = frame
        self._add(f"{tool}/body", arm.tool.body)
        for finger in arm.tool.fingers:
            node = self._scene.add_frame(f"{name}/{finger_name(arm, finger)}", show_axes=False)
            self._add(f"{name}/{finger_name(arm, finger)}/visual", (finger.solid,))
            self._fingers[arm.name].append((finger, node))

    def _add(self, name: str, solids: tuple[Solid, ...]) -> None:
        meshes = add_solids(self._scene, name, solids, self._colour, self._opacity)
        self._meshes += meshes
        self._own += [mesh.color for mesh in meshes]

    def _is_new(self, name: str, value: Floats) -> bool:
        if name in self._shown and np.array_equal(self._shown[name], value):
            return False
        self._shown[name] = value
        return True


def add_solids(
    scene: viser.SceneApi,
    name: str,
    solids: tuple[Solid, ...],
    colour: Colour | None = None,
    opacity: float | None = None,
) -> list[viser.MeshHandle]:
    """Show solids, a mesh for each colour of theirs; `colour` is shown instead of them."""
    return [
        scene.add_mesh_simple(
            f"{name}_{number}", points, triangles, color=colour or own, opacity=opacity
        )
        for number, (own, points, triangles) in enumerate(by_colour(solids))
    ]


def drain_colour(colour: Colour) -> Colour:
    """A grey for a colour of what nobody reports: what is lighter stays a little lighter."""
    lightness = float(np.dot(colour, LIGHTNESS))
    red, green, blue = (
        round(channel + LIGHTNESS_SHARE * (lightness - channel)) for channel in NOT_REPORTED
    )
    return red, green, blue


def finger_name(arm: Arm, finger: Finger) -> str:
    """A finger's node, below that of the robot."""
    return f"{arm.flange}/{arm.tool.name}/{finger.solid.name}"


def moved_by(cell: Cell, arm: Arm) -> set[str]:
    """The links that move when a joint of the arm does."""
    moved: set[str] = set()
    for joint in cell.robot.joints:
        if joint.name in arm.joints or joint.parent in moved:
            moved.add(joint.child)
    return moved


def place(node: viser.SceneNodeHandle, T: pin.SE3) -> None:
    """Move a node to `T`, its pose in its parent."""
    node.position = T.translation
    node.wxyz = quaternion(T)


def place_new(node: viser.SceneNodeHandle, T: pin.SE3) -> None:
    """Move a node that was just added, maybe under the name of one that was just removed.

    Browsers keep the pose of that one, and viser sends none that equals a new node's.  So another
    pose comes first, which no browser gets: the last one counts.
    """
    node.position = T.translation + 1.0
    w, x, y, z = quaternion(T)
    node.wxyz = (-w, -x, -y, -z)
    place(node, T)


def quaternion(T: pin.SE3) -> tuple[float, float, float, float]:
    """The rotation of a pose as w, x, y, z."""
    q = pin.Quaternion(T.rotation)
    return q.w, q.x, q.y, q.z


def pose_of_node(node: viser.TransformControlsHandle) -> pin.SE3:
    """The pose of a gizmo in the world.

    Raises:
        InputError: a browser has sent numbers that are no pose.
    """
    w, x, y, z = (float(value) for value in node.wxyz)
    length = float(np.sqrt(w * w + x * x + y * y + z * z))
    if not 0.5 < length < 2.0 or not np.all(np.isfinite(node.position)):
        raise InputError("the gizmo is nowhere")
    q = pin.Quaternion(w, x, y, z).normalized()
    return pin.SE3(q.matrix(), np.array(node.position, dtype=np.float64))
