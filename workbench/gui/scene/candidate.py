"""Candidates in the scene: a stroke for each, and the chosen one in full."""

import numpy as np
import pinocchio as pin
import viser

from workbench.gui.scene.contacts import draw_meets
from workbench.gui.scene.marks import add_lines
from workbench.gui.scene.robot import DrawnRobot, place_new
from workbench.gui.shared.colours import rgb_of, verdict_colour
from workbench.gui.shared.look import Pose, View
from workbench.gui.shared.solids import by_colour
from workbench.gui.shared.views import candidate_label
from workbench.model.candidate import Candidate
from workbench.model.cell import Arm, Cell
from workbench.model.derived.by_tcp import by_taking
from workbench.model.geometry import Floats, Ints
from workbench.planning.kinematics.robot import Kinematics

STROKE = 0.03
"""Length of the drawn end of an approach [m]."""

LABEL_HEIGHT = 0.17
"""[m] The label stands this far above the tool's tip, clear of the hand."""


def strokes_of(ends: Floats, approaches: Floats, colours: Ints) -> tuple[Floats, Ints]:
    """The drawn ends of approaches.

    Args:
        ends: (n, 3) [m] of the hand.
        approaches: (n, 3), unit vectors.
        colours: (n, 3), 0..255.

    Returns:
        Lines (n, 2, 3) [m] with their colours (n, 2, 3).
    """
    strokes = np.stack([ends - STROKE * approaches, ends], axis=1)
    return strokes, np.repeat(colours[:, None, :], 2, axis=1).astype(np.uint8)


class DrawnCandidates:
    """All candidates as strokes along their approach, in the colour of their verdict.

    The chosen one shows its tool, or the whole arm in the pose that is viewed, with the
    verdict beside it; what comes too close to each other there is red.

    Concurrency: one thread.
    """

    def __init__(self, scene: viser.SceneApi, cell: Cell, kinematics: Kinematics):
        """Draw nothing yet."""
        self._scene = scene
        self._cell = cell
        self._kinematics = kinematics
        self._arms: dict[str, DrawnRobot] = {}
        self._shown: Arm | None = None

    def use(self, cell: Cell, kinematics: Kinematics) -> None:
        """Go on with a cell whose robot and tools are the same."""
        self._cell, self._kinematics = cell, kinematics

    def draw(self, old: View | None, new: View) -> None:
        """Bring the scene from `old` to `new`."""
        same = (
            old is not None
            and old.state.candidates is new.state.candidates
            and old.look.candidate == new.look.candidate
        )
        if old is not None and same:
            if old.pose is not new.pose:
                self._pose(new.pose)
            return
        candidates, chosen = new.state.candidates or (), new.look.candidate
        # With a plan they would only hide what moves, unless somebody asks for one.
        if candidates and (new.state.plan is None or chosen is not None):
            self._draw_strokes(candidates)
        else:
            self._scene.remove_by_name("/grasps")
        self._scene.remove_by_name("/candidate")
        self._scene.remove_by_name("/meets")
        self._shown = None
        for robot in self._arms.values():
            robot.show(False)
        if chosen is not None and chosen < len(candidates):
            self._draw_chosen(candidates[chosen], new.pose)

    def _draw_strokes(self, candidates: tuple[Candidate, ...]) -> None:
        ends = np.array([candidate.T_world_tcp.translation for candidate in candidates])
        approaches = np.array(
            [candidate.T_world_tcp.rotation @ candidate.grasp.approach for candidate in candidates]
        )
        colours = np.array(
            [rgb_of(verdict_colour(candidate.verdict.kind)) for candidate in candidates]
        )
        strokes, painted = strokes_of(ends, approaches, colours)
        add_lines(self._scene, "/grasps", strokes, painted, 2.0)

    def _draw_chosen(self, candidate: Candidate, pose: Pose | None) -> None:
        colour = rgb_of(verdict_colour(candidate.verdict.kind))
        arm = by_taking(self._cell, candidate).arm(candidate.arm)
        T_world_tcp, opening = candidate.T_world_tcp, candidate.grasp.opening
        if pose is not None and pose.T_world_tcp is not None:
            T_world_tcp, opening = pose.T_world_tcp, pose.opening
        node = self._scene.add_frame("/candidate", axes_length=0.04, axes_radius=0.0015)
        place_new(node, T_world_tcp)
        self._scene.add_label(
            "/candidate/label",
            candidate_label(candidate),
            position=LABEL_HEIGHT * T_world_tcp.rotation[2],
            font_screen_scale=0.8,
            anchor="bottom-center",
        )
        if pose is not None and pose.q is not None:
            if arm.name not in self._arms:
                self._arms[arm.name] = DrawnRobot(
                    self._scene, f"/candidate_{arm.name}", self._cell, arms=(arm,), opacity=0.45
                )
            self._shown = arm
            self._arms[arm.name].paint(colour)
            self._arms[arm.name].show(True)
            self._pose(pose)
            return
        self._pose(pose)
        T_tcp_flange = arm.tool.T_flange_tcp.inverse()
        opened = [
            (finger.solid, pin.SE3(np.eye(3), opening / 2 * finger.direction))
            for finger in arm.tool.fingers
        ]
        pieces = by_colour(arm.tool.body, T_tcp_flange)
        for solid, shift in opened:
            pieces += by_colour((solid,), T_tcp_flange * shift)
        for number, (_, points, triangles) in enumerate(pieces):
            self._scene.add_mesh_simple(
                f"/candidate/tool_{number}",
                points,
                triangles,
                color=colour,
                opacity=0.45,
            )

    def _pose(self, pose: Pose | None) -> None:
        """Move the arm, where one is shown, and draw in red what meets there."""
        arm = self._shown
        draw_meets(self._scene, "/meets", () if pose is None else pose.meets)
        if pose is None or pose.q is None or arm is None:
            return
        links = self._kinematics.link_poses(dict(zip(arm.joints, pose.q.tolist(), strict=True)))
        self._arms[arm.name].pose(links, {arm.name: pose.opening})
