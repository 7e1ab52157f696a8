"""What the page works out about a calibration: the answer, and one pose laid over its scan."""

from dataclasses import dataclass

import numpy as np
import viser

from workbench.app.calibration.calibration import compute_calibration
from workbench.app.core.state import State
from workbench.gui.shared.colours import BAD, BESIDE_BIN, BUSY, GOOD, PLATE, rgb_of
from workbench.model.calibration import Calibration, PlateObservation
from workbench.model.derived.scanner_poses import scanner_pose, with_scanner_at
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message
from workbench.planning.kinematics.robot import Kinematics

KNOWN_WITHIN = 0.025
"""[m] Points further from everything known than this belong to something else, and are grey."""

GREEN_WITHIN, AMBER_WITHIN = 0.002, 0.005
"""[m] Up to here a point near something known is green, and amber; beyond it is red."""


@dataclass(frozen=True, slots=True, eq=False)
class Overlay:
    """A pose of a calibration in the world: the arm at `q` (n,), what was scanned, the balls.

    `points` (m, 3) and `balls` (3, 3) [m] are placed by the scanner's pose.  `colours` (m, 3) show
    the distance of the points from the known surfaces.  `middle` [m] is the median distance of the
    near points.
    """

    arm: str
    q: Floats
    points: Floats
    colours: np.ndarray
    balls: Floats
    radius: float
    middle: float | None


def solve(state: State) -> Calibration | Message:
    """The calibration from the scanned poses, or why there is none."""
    try:
        return compute_calibration(state.cell, state.observations)
    except InputError as error:
        return error.message


def overlay(state: State, observation: PlateObservation, found: Calibration | None) -> Overlay:
    """One pose over the robot.

    Args:
        state: whose cell it is.
        observation: the pose.
        found: has the scanner's pose; None: as the cell has it.

    Returns:
        Of a scanner on an arm the points are compared with bin and fixtures, too.
    """
    # Open3D takes a second to load: the page does not wait for it.
    from workbench.perception.calibration.robot_overlay import distances_to_cell

    cell = state.cell
    T = scanner_pose(
        cell if found is None else with_scanner_at(cell, found.T_world_scanner), observation.q
    )
    points = observation.points @ T.rotation.T + T.translation
    links = Kinematics(cell).link_poses(cell.joint_values({observation.arm: observation.q}))
    away = distances_to_cell(cell, links, points)
    colours = np.full((len(points), 3), BESIDE_BIN, dtype=np.uint8)
    near = away < KNOWN_WITHIN
    colours[near] = rgb_of(BAD)
    colours[away < AMBER_WITHIN] = rgb_of(BUSY)
    colours[away < GREEN_WITHIN] = rgb_of(GOOD)
    balls = observation.balls @ T.rotation.T + T.translation
    middle = float(np.median(away[near])) if near.any() else None
    radius = observation.plate.radius
    return Overlay(observation.arm, observation.q, points, colours, balls, radius, middle)


def draw_overlay(scene: viser.SceneApi, shown: Overlay | None) -> None:
    """Its points and balls; the robot is posed by the scene."""
    scene.remove_by_name("/observation")
    if shown is None:
        return
    scene.add_point_cloud(
        "/observation/points",
        shown.points.astype(np.float32),
        shown.colours,
        point_size=0.0022,
        point_shape="circle",
        precision="float32",
    )
    for number, ball in enumerate(shown.balls, start=1):
        position = tuple(ball.tolist())
        scene.add_icosphere(
            f"/observation/ball-{number}",
            shown.radius,
            PLATE,
            opacity=0.6,
            position=position,
        )
        scene.add_label(
            f"/observation/ball-{number}/label",
            str(number),
            font_screen_scale=0.8,
            position=(0.0, 0.0, 2 * shown.radius),
        )
