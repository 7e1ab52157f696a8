"""The one picture that all browsers share: what stands in the cell, and what moves in it."""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin
import viser

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.candidate import DrawnCandidates
from workbench.gui.scene.cloud import PaintedCloud, in_short, painted_cloud, shown_colours
from workbench.gui.scene.dragged_bodies import DrawnHeld, DrawnLost
from workbench.gui.scene.marks import DrawnPins, add_lines, draw_reach, draw_rejected
from workbench.gui.scene.robot import PLANNED, ROBOT, ROBOT_CHECKED, DrawnRobot, place, place_new
from workbench.gui.scene.searches import draw_search
from workbench.gui.scene.stations import DrawnBeside
from workbench.gui.scene.surroundings import (
    add_light,
    add_surroundings,
    aim_camera,
    paint_background,
    remove_surroundings,
    show_frames,
)
from workbench.gui.shared.colours import (
    AVOIDED,
    CHECKED,
    PLANNED_ROBOT,
    arm_colour,
    part_colour,
    rgb_of,
)
from workbench.gui.shared.look import View
from workbench.gui.shared.playback import ArmMoment, Run, joint_values, part_poses, tcp_path
from workbench.gui.shared.solids import with_hard_edges
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.geometry import Floats
from workbench.model.scan import Detection, Obstacle, RejectedHypothesis, Scan
from workbench.planning.collision.bodies import obstacle_label
from workbench.planning.kinematics.robot import Kinematics

PATH_POINTS = 24
"""Of the drawn way of the tool centre point, per leg."""

SEE_THROUGH = 0.45
"""Opacity of what is planned; what is real is solid."""


class ScenePicture:
    """Draws a view by changing only what differs from the view drawn before.

    Concurrency: one thread.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        cell: Cell,
        *,
        most_points: int,
        planned_is_solid: bool = False,
    ):
        """Add what never changes.

        Args:
            server: its scene is drawn in.
            cell: that stands there.
            most_points: of a scan; the others are left out at random.
            planned_is_solid: for pictures of a plan that no real robot stands beside.
        """
        self._scene = server.scene
        self._most_points = most_points
        self._planned_is_solid = planned_is_solid
        self._parts: list[viser.FrameHandle] = []
        self._Ts_world_part: tuple[pin.SE3, ...] = ()
        self._rejected: tuple[RejectedHypothesis, ...] = ()
        self._cloud: PaintedCloud | None = None
        aim_camera(server, cell)
        self._build(cell)
        self._is_built = True

    def _build(self, cell: Cell) -> None:
        """Add robot and surroundings of a cell to an empty scene."""
        scene = self._scene
        self._cell, self._kinematics = cell, Kinematics(cell)
        add_light(scene)
        paint_background(scene)
        add_surroundings(scene, cell)
        self._robot = DrawnRobot(scene, ROBOT, cell)
        self._checked: DrawnRobot | None = None
        self._planned = DrawnRobot(
            scene,
            PLANNED,
            cell,
            arms=cell.arms,
            colour=None if self._planned_is_solid else PLANNED_ROBOT,
            opacity=None if self._planned_is_solid else SEE_THROUGH,
            is_visible=False,
        )
        self._pins = DrawnPins(scene)
        self._candidates = DrawnCandidates(scene, cell, self._kinematics)
        self._held, self._lost = DrawnHeld(scene), DrawnLost(scene)
        self._beside = DrawnBeside(scene)

    def _use(self, cell: Cell) -> bool:
        """Go on with another cell; whether everything has to be drawn anew."""
        is_other = not self._is_built or is_other_robot(self._cell, cell)
        self._is_built = False  # until it is: this may fail, and is tried again
        if is_other:
            self._scene.reset()
            self._parts = []
            self._rejected = ()
            self._build(cell)
        else:
            self._cell, self._kinematics = cell, Kinematics(cell)
            remove_surroundings(self._scene)
            add_surroundings(self._scene, cell)
            self._candidates.use(cell, self._kinematics)
        self._is_built = True
        return is_other

    def draw(self, old: View | None, new: View) -> None:
        """Bring the scene from `old` (None: nothing, or drawing it failed) to `new`."""
        is_same = self._is_built and self._cell is new.state.cell
        if not is_same and self._use(new.state.cell):
            old = None
        before, state = old and old.state, new.state
        is_other_scan = (
            before is None
            or before.scan is not state.scan
            or before.detections is not state.detections
            or before.cell.bin is not state.cell.bin
        )
        if is_other_scan:
            self._cloud = self._paint(state.scan, state.detections)
        are_other_obstacles = before is None or before.obstacles is not state.obstacles
        is_other_plan = before is None or before.plans != state.plans
        are_other_parts = before is None or before.detections is not state.detections
        if are_other_parts:
            self._add_parts(state.detections or ())
        are_other_colours = old is None or old.look.scan_colours != new.look.scan_colours
        if is_other_scan or are_other_obstacles or are_other_colours:
            self._draw_scan(new)
        if are_other_obstacles:
            self._draw_obstacles(state.obstacles)
        if is_other_plan:
            self._draw_paths(new.runs)
        is_other_time = (
            old is None
            or before is None
            or old.look.time != new.look.time
            or before.cell is not state.cell
        )
        is_elsewhere = (
            old is None
            or old.live.joints is not new.live.joints
            or old.live.last_joints is not new.live.last_joints
        )
        is_other_time = is_other_time or (old is not None and old.look.follows != new.look.follows)
        are_other_shapes = old is None or old.look.shapes != new.look.shapes
        if are_other_shapes:
            self._show_shapes(new.look.shapes)
        is_other_cell = before is None or before.cell is not state.cell
        if old is None or old.look.frames != new.look.frames or is_other_cell:
            show_frames(self._scene, self._cell, self._kinematics, is_shown=new.look.frames)
        if old is None or old.reached is not new.reached:
            draw_reach(self._scene, new.reached)
        is_other_search = old is None or old.look.search != new.look.search
        if is_other_search or before is None or before.searches is not state.searches:
            draw_search(self._scene, state, new.look.search)
        if old is None or old.look.held is not new.look.held:
            self._held.draw(new.look.held)
        shown = new.rejected if new.look.rejected else ()
        if old is None or shown is not self._rejected:
            draw_rejected(self._scene, self._cell, shown)
            self._rejected = shown
        if is_other_plan or are_other_parts or is_other_time or are_other_shapes or is_elsewhere:
            self._pose(new)
        self._beside.draw(new, self._Ts_world_part)
        self._lost.draw(new, self._kinematics)
        self._candidates.draw(old, new)

    def _paint(
        self, scan: Scan | None, detections: tuple[Detection, ...] | None
    ) -> PaintedCloud | None:
        """What is drawn of a scan."""
        if scan is None:
            return None
        points, own = scan.points_world, scan.colours
        if len(points) > self._most_points:
            chosen = np.random.default_rng(0).choice(
                len(points), self._most_points, replace=False, shuffle=False
            )
            points, own = points[chosen], None if own is None else own[chosen]
        return painted_cloud(self._cell, points, detections or (), own)

    def _draw_scan(self, view: View) -> None:
        """The points of a part belong to its node: they go where it goes."""
        cloud, detections = self._cloud, view.state.detections or ()
        if cloud is None:
            self._scene.remove_by_name("/scan")
            return
        colours = shown_colours(cloud, view.state.obstacles, as_scanned=view.look.scan_colours)
        rest = cloud.owners < 0
        self._add_points("/scan", cloud.points[rest], colours[rest])
        for number, detection in enumerate(detections):
            own = cloud.owners == number
            T = detection.T_world_part.inverse()
            points = cloud.points[own] @ T.rotation.T + T.translation
            self._add_points(f"/parts/part-{number + 1}/points", points, colours[own])

    def _add_points(self, name: str, points: Floats, colours: np.ndarray) -> None:
        middle, near = in_short(points)
        self._scene.add_point_cloud(
            name,
            near,
            colours,
            point_size=0.0016,
            point_shape="circle",
            point_shading="flat",
            precision="float16",
            position=middle,
        )

    def _draw_obstacles(self, obstacles: tuple[Obstacle, ...]) -> None:
        self._scene.remove_by_name("/seen")
        for number, obstacle in enumerate(obstacles):
            name = f"/seen/{obstacle_label(number)}"
            box = self._scene.add_box(
                name,
                rgb_of(AVOIDED),
                dimensions=tuple(obstacle.size.tolist()),
                opacity=0.35,
            )
            place_new(box, obstacle.T_world_box)

    def _add_parts(self, detections: tuple[Detection, ...]) -> None:
        self._scene.remove_by_name("/parts")
        self._parts = [
            self._added_part(number, detection) for number, detection in enumerate(detections)
        ]
        self._pins.add(self._cell, detections)

    def _added_part(self, number: int, detection: Detection) -> viser.FrameHandle:
        name = f"/parts/part-{number + 1}"
        node = self._scene.add_frame(name, show_axes=False)
        mesh = self._cell.part(detection.part).mesh
        points, triangles = with_hard_edges(triangles_of(mesh))
        self._scene.add_mesh_simple(
            f"{name}/mesh", points, triangles, color=rgb_of(part_colour(number)), opacity=0.9
        )
        return node

    def _draw_paths(self, runs: tuple[Run, ...]) -> None:
        for number, arm in enumerate(self._cell.arms):
            ways = [
                tcp_path(self._kinematics, self._cell, run, points=PATH_POINTS)
                for run in runs
                if run.arm == arm.name
            ]
            name = f"/path/{arm.name}"
            if not ways:
                self._scene.remove_by_name(name)
                continue
            segments = np.concatenate([np.stack([way[:-1], way[1:]], axis=1) for way in ways])
            add_lines(self._scene, name, segments, rgb_of(arm_colour(number)), 2.5)

    def _show_shapes(self, is_shown: bool) -> None:
        """Show what is checked for collisions instead of what it looks like."""
        if is_shown and self._checked is None:
            self._checked = DrawnRobot(
                self._scene, ROBOT_CHECKED, self._cell, colour=CHECKED, as_checked=True
            )
        self._robot.show(not is_shown)
        if self._checked is not None:
            self._checked.show(is_shown)

    def _pose(self, view: View) -> None:
        planned, all_arms = view.planned_arms, frozenset(arm.name for arm in self._cell.arms)
        self._pose_robot(self._robot, view.real)
        self._robot.drain(not (view.is_reported or self._planned_is_solid))
        # Where nobody knows where the robot is or was, what is planned stands alone.
        is_placed = view.is_reported or view.was_reported
        self._robot.show_arms(all_arms if is_placed else all_arms - planned)
        self._planned.show(bool(planned) and not view.look.shapes)
        if planned:
            self._pose_robot(self._planned, view.moments)
            self._planned.show_arms(planned)
        if self._checked is not None:
            self._pose_robot(self._checked, view.moments if planned else view.real)
        row, detections = view.state.plans, view.state.detections or ()
        if row and len(row[0].detections) == len(self._parts):
            poses = part_poses(self._cell, self._kinematics, row, view.runs, view.look.time)
        else:
            poses = tuple(detection.T_world_part for detection in detections)
        self._Ts_world_part = poses
        for node, T in zip(self._parts, poses, strict=True):
            place(node, T)
        self._pins.turn(poses)

    def _pose_robot(self, robot: DrawnRobot, stands: Mapping[str, ArmMoment]) -> None:
        links = self._kinematics.link_poses(joint_values(self._cell, stands))
        robot.pose(links, {arm: moment.opening for arm, moment in stands.items()})
        robot.carry({arm: moment.tool for arm, moment in stands.items()})


def is_other_robot(first: Cell, second: Cell) -> bool:
    """Whether robot, arms or tools are drawn otherwise."""

    def state_to_draw(cell: Cell) -> str:
        arms = [(a.name, a.joints, a.flange, a.tool, a.tools, a.tool_slots) for a in cell.arms]
        return digest_of((cell.robot, arms))

    return state_to_draw(first) != state_to_draw(second)
