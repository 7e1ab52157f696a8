"""What is drawn in one browser alone, over the picture that all share."""

from collections.abc import Mapping

import pinocchio as pin
import viser

from workbench.app.calibration.calibration import plate_pose
from workbench.gui.scene.contacts import draw_meets
from workbench.gui.scene.drag_overlay import DrawnCarried, DrawnVerdicts
from workbench.gui.scene.marks import (
    draw_chosen,
    draw_measured,
    draw_plate,
    draw_visited,
    remove_chosen,
)
from workbench.gui.scene.robot import PLANNED, ROBOT_CHECKED, finger_name, moved_by, place
from workbench.gui.shared.calibrating import draw_overlay
from workbench.gui.shared.look import View
from workbench.gui.shared.own import ShownPlate
from workbench.gui.shared.playback import joint_values
from workbench.gui.shared.visitor import Visitor
from workbench.model.cell import Cell
from workbench.model.derived.scanner_poses import scanner_pose
from workbench.planning.kinematics.robot import Kinematics

SCANNER = "/scanner"
"""The node of the scanner, with its frustum and its label."""


class OwnScene:
    """The see-through robot where this browser has moved it, what it meets, what was measured.

    In viser a node of one browser takes the place of the shared node of that name, in this browser
    alone; what hangs below it follows: so only poses of links are sent, no meshes, and what
    all see is back, as it is then, once they are removed.  The solid robot is the real one for all.

    Concurrency: the renderer's thread.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is drawn yet."""
        self._client = visitor.client
        self._scene = visitor.client.scene
        self._root: viser.FrameHandle | None = None
        self._frames: dict[str, viser.FrameHandle] = {}
        self._plate: ShownPlate | None = None
        self._plate_frame: viser.FrameHandle | None = None
        self._labelled: View | None = None
        self._verdicts = DrawnVerdicts(self._scene, visitor.client.camera)
        self._carried = DrawnCarried(self._scene)
        visitor.on_end(self._clear, in_scene=True)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is drawn from `old` to `new`."""
        is_first = old is None
        with self._client.atomic():
            if is_first or old.overlay is not new.overlay:
                draw_overlay(self._scene, new.overlay)
            if is_first or old.jogged is not new.jogged:
                draw_meets(self._scene, "/jog_meets", new.jogged.meets if new.jogged else ())
            if is_first or old.own.measured is not new.own.measured:
                draw_measured(self._scene, new.own.measured)
            if is_first or old.own.dragged is not new.own.dragged:
                self._verdicts.draw(new.own.dragged)
            are_other_parts = is_first or old.state.detections is not new.state.detections
            if are_other_parts or is_first or old.own.part is not new.own.part:
                draw_chosen(self._scene, old, new)
                self._labelled = new
            if is_first or old.own.carried is not new.own.carried:
                self._carried.draw(new.own.carried)
            if is_first or old.visited is not new.visited:
                draw_visited(self._scene, new.visited)
            if _plate_of(new) is not self._plate:
                self._plate = _plate_of(new)
                self._plate_frame = draw_plate(self._scene, self._plate)
            if new.jogged is None and new.overlay is None and new.filmed is None:
                self._give_back()
            elif (
                is_first
                or not self._frames
                or old.jogged is not new.jogged
                or old.overlay is not new.overlay
                or old.filmed is not new.filmed
                or old.look.time != new.look.time
                or old.look.shapes != new.look.shapes
                or old.live.joints != new.live.joints
            ):
                self._pose(new)

    def _pose(self, view: View) -> None:
        cell, now = view.state.cell, view.moments
        if self._root is None:
            self._root = self._scene.add_frame(PLANNED, show_axes=False)
        _say(self._root, not view.look.shapes)
        shown = set[str]().union(*(moved_by(cell, cell.arm(arm)) for arm in view.planned_arms))
        links = Kinematics(cell).link_poses(joint_values(cell, now))
        poses = poses_of(cell, links, {arm: moment.opening for arm, moment in now.items()})
        for name, T in poses.items():
            for root in (PLANNED, ROBOT_CHECKED):
                whole = f"{root}/{name}"
                if whole not in self._frames:
                    self._frames[whole] = self._scene.add_frame(whole, show_axes=False)
                place(self._frames[whole], T)
                if root == PLANNED and name in links:
                    _say(self._frames[whole], name in shown)
        self._place_scanner(view)

    def _place_scanner(self, view: View) -> None:
        """A scanner on an arm goes with it; the plate is where the suggestion assumes it."""
        cell, now, carrier = view.state.cell, view.moments, view.state.cell.scanner.on_arm
        if carrier is not None:
            if SCANNER not in self._frames:
                self._frames[SCANNER] = self._scene.add_frame(SCANNER, show_axes=False)
            place(self._frames[SCANNER], scanner_pose(cell, now[carrier.arm].q))
        if (plate := self._plate) is not None and self._plate_frame is not None:
            arm, kinematics = cell.arm(plate.arm), Kinematics(cell)
            T = plate_pose(cell, kinematics, arm, now[arm.name].q, plate.T_flange_plate)
            place(self._plate_frame, T)

    def _give_back(self) -> None:
        for name in self._frames:
            # A link takes along what hangs below it: that is no longer there when its turn comes.
            self._scene.remove_by_name(name)
        self._frames = {}
        if self._root is not None:
            self._scene.remove_by_name(PLANNED)
            self._root = None

    def _clear(self) -> None:
        self._give_back()
        self._verdicts.draw(None)
        self._carried.draw(None)
        draw_plate(self._scene, None)
        remove_chosen(self._scene, self._labelled)
        for name in ("/observation", "/jog_meets", "/measured", "/nearest", "/nearest_points"):
            self._scene.remove_by_name(name)


def _plate_of(view: View) -> ShownPlate | None:
    """The plate that is drawn: that of a suggestion, while the robot is jogged."""
    return None if view.jogged is None else view.own.plate


def _say(node: viser.FrameHandle, is_visible: bool) -> None:
    """Show or hide a node, also when that was said before: what all see may have changed it."""
    node.visible = not is_visible
    node.visible = is_visible


def poses_of(
    cell: Cell, Ts_world_link: Mapping[str, pin.SE3], openings: Mapping[str, float]
) -> dict[str, pin.SE3]:
    """The nodes of a drawn robot that move, by their names below its root.

    Args:
        cell: whose robot and tools.
        Ts_world_link: pose of every link by name.
        openings: finger distance of each arm's tool by arm name [m].

    Returns:
        Poses of links in the world, and of fingers on their tool.
    """
    found: dict[str, pin.SE3] = {}
    for arm in cell.arms:
        found |= {link: Ts_world_link[link] for link in moved_by(cell, arm)}
        for finger in arm.tool.fingers:
            shift = openings.get(arm.name, 0.0) / 2 * finger.direction
            found[finger_name(arm, finger)] = pin.SE3(pin.SE3.Identity().rotation, shift)
    return found
