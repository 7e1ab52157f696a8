"""What stands around the robot and never moves, and from where it is looked at."""

import math

import numpy as np
import viser

from workbench.gui.colours import SKY, rgb_of
from workbench.gui.robot import quaternion
from workbench.gui.solids import by_colour
from workbench.model.cell import Cell


def add_surroundings(scene: viser.SceneApi, cell: Cell) -> None:
    """Floor, fixtures, bin and scanner: they never move."""
    lowest = 0.0
    for fixture in cell.fixtures:
        for number, (colour, points, triangles) in enumerate(
            by_colour(fixture.solids, fixture.T_world_fixture)
        ):
            scene.add_mesh_simple(
                f"/fixtures/{fixture.name}/{number}", points, triangles, color=colour
            )
            lowest = min(lowest, float(points[:, 2].min()))
    for number, (colour, points, triangles) in enumerate(
        by_colour(cell.bin.solids, cell.bin.T_world_bin)
    ):
        scene.add_mesh_simple(
            f"/bin/{number}", points, triangles, color=colour, opacity=0.35, side="double"
        )
    mount = cell.scanner
    columns, rows = mount.resolution
    height = 2 * math.atan(math.tan(mount.field_of_view / 2) * rows / columns)
    scene.add_camera_frustum(
        "/scanner",
        height,
        columns / rows,
        scale=0.05,
        color=(73, 80, 87),
        thickness=1.5,
        thickness_units="screen",
        wxyz=quaternion(mount.T_world_scanner),
        position=mount.T_world_scanner.translation,
    )
    scene.add_label(
        "/scanner/label",
        "scanner",
        font_screen_scale=0.8,
        anchor="bottom-center",
    )
    scene.add_grid(
        "/floor",
        3.0,
        3.0,
        position=(*cell.bin.T_world_bin.translation[:2], lowest - 0.002),
        cell_size=0.1,
        section_size=0.5,
        cell_color=(233, 236, 239),
        section_color=(206, 212, 218),
    )


def paint_background(scene: viser.SceneApi) -> None:
    """A soft sky, so that white robots stand out."""
    shares = np.linspace(0.0, 1.0, 64)[:, None, None]
    top, bottom = (np.array(rgb_of(colour)) for colour in SKY)
    gradient = (1 - shares) * top + shares * bottom
    scene.set_background_image(np.repeat(gradient, 8, axis=1).astype(np.uint8), "png")


def aim_camera(server: viser.ViserServer, cell: Cell) -> None:
    """Look at robot, bin and places from in front and from the side, from above."""
    scanner = cell.scanner.T_world_scanner.translation
    robot, goal = cell.T_world_robot.translation, cell.bin.T_world_bin.translation
    interesting = np.array(
        [robot, robot + np.array([0.0, 0.0, 0.6]), goal, scanner]
        + [T.translation for arm in cell.arms for T in arm.Ts_world_place]
    )
    centre = (interesting.min(axis=0) + interesting.max(axis=0)) / 2
    reach = float(np.linalg.norm(interesting - centre, axis=1).max())
    towards = math.atan2(goal[1] - robot[1], goal[0] - robot[0]) - math.radians(38)
    direction = np.array([math.cos(towards), math.sin(towards), 0.6])
    server.initial_camera.position = centre + 2.75 * reach * direction
    server.initial_camera.look_at = centre
    server.initial_camera.up = (0.0, 0.0, 1.0)
    server.initial_camera.fov = math.radians(40)
