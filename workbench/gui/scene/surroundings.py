"""What stands around the robot and never moves, and from where it is viewed."""

import itertools
import math
from typing import Protocol

import numpy as np
import pinocchio as pin
import viser

from workbench.gui.scene.robot import ROBOT as DRAWN_ROBOT
from workbench.gui.scene.robot import ROBOT_CHECKED, place_new
from workbench.gui.scene.shade import shade_of
from workbench.gui.scene.stations import add_regions, add_stations
from workbench.gui.shared.colours import GRID, NIGHT_GRID, NIGHT_SKY, SKY, rgb_of
from workbench.gui.shared.movable_frames import name_of_region
from workbench.gui.shared.solids import by_colour
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import surfaces
from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.planning.kinematics.robot import Kinematics

FIELD_OF_VIEW = math.radians(40)
"""Vertical, of the first look."""

ASPECT = 1.2
"""Width by height of the scene in a window of 1280 x 720."""

FILLED = 0.88
"""This much of the picture is used; the rest is margin."""

SURROUNDING_POINTS = np.array(
    [[0.08, 0.0, -0.1], [-0.08, 0.0, -0.1], [0.0, 0.08, -0.1], [0.0, -0.08, -0.1]]
)
"""Around and below a place [m], since parts are put down on something."""


SKY_LIGHT, FLOOR_LIGHT = (236, 242, 255), (196, 200, 214)
"""What falls on things from above and from below, besides the light that gives them shape."""

FILL = 1.9
"""How bright that is."""

LIES = (81, 148, 237)
"""Of a part that has to lie somewhere, and is not there."""

UP = (0.0, 0.0, 1.0)
"""Where the sky is."""


class BrowserCamera(Protocol):
    """What viser knows of a browser's camera: its frame looks along z, with y down."""

    @property
    def position(self) -> Floats:
        """(3,) [m] in the world."""
        ...

    @property
    def wxyz(self) -> Floats:
        """Its turn as a quaternion (4,), no unit."""
        ...

    @property
    def fov(self) -> float:
        """Vertical field of view [rad]."""
        ...

    @property
    def aspect(self) -> float:
        """Width by height of the picture."""
        ...

    @property
    def up_direction(self) -> Floats:
        """Where up is (3,), no unit."""
        ...


def add_surroundings(scene: viser.SceneApi, cell: Cell) -> None:
    """Floor, fixtures, stations, bin, regions and scanner: each is a frame that a drag can move."""
    for fixture in surfaces(cell):
        name = f"/fixtures/{fixture.name}"
        place_new(scene.add_frame(name, show_axes=False), fixture.T_world_fixture)
        for number, (colour, points, triangles) in enumerate(by_colour(fixture.solids)):
            scene.add_mesh_simple(f"{name}/{number}", points, triangles, color=colour)
    add_shade(scene, cell)
    add_stations(scene, cell)
    place_new(scene.add_frame("/bin", show_axes=False), cell.bin.T_world_bin)
    for number, (colour, points, triangles) in enumerate(by_colour(cell.bin.solids)):
        scene.add_mesh_simple(
            f"/bin/{number}", points, triangles, color=colour, opacity=0.35, side="double"
        )
    add_regions(scene, cell.bin)
    mount = cell.scanner
    columns, rows = mount.resolution
    height = 2 * math.atan(math.tan(mount.field_of_view / 2) * rows / columns)
    place_new(scene.add_frame("/scanner", show_axes=False), mount.T_world_scanner)
    scene.add_camera_frustum(
        "/scanner/frustum",
        height,
        columns / rows,
        scale=0.05,
        color=(73, 80, 87),
        thickness=1.5,
        thickness_units="screen",
    )
    scene.add_label(
        "/scanner/label",
        "scanner",
        font_screen_scale=0.8,
        anchor="bottom-center",
    )
    add_floor(scene, cell)


def add_shade(scene: viser.SceneApi, cell: Cell) -> None:
    """The soft dark on the table below what stands there."""
    shade = shade_of(cell)
    if shade is not None:
        scene.add_image(
            "/shade",
            shade.image,
            *shade.size,
            format="png",
            position=shade.middle,
            cast_shadow=False,
            receive_shadow=False,
        )


def add_floor(scene: viser.SceneApi, cell: Cell, *, is_dark: bool = False) -> None:
    """The grid below everything; it recedes on a dark page as on a light one."""
    lowest = 0.0
    for fixture in cell.fixtures:
        for _, points, _ in by_colour(fixture.solids, fixture.T_world_fixture):
            lowest = min(lowest, float(points[:, 2].min()))
    fine, coarse = NIGHT_GRID if is_dark else GRID
    scene.add_grid(
        "/floor",
        3.0,
        3.0,
        position=(*cell.bin.T_world_bin.translation[:2], lowest - 0.002),
        cell_size=0.1,
        section_size=0.5,
        cell_color=rgb_of(fine),
        section_color=rgb_of(coarse),
    )


def nodes_with(
    cell: Cell, thing: str, T: pin.SE3, *, as_checked: bool = False
) -> dict[str, pin.SE3]:
    """What is drawn elsewhere with one of `things` at `T`: nodes by name, with their poses.

    Args:
        cell: as it is drawn.
        thing: one of `things`; of places and tools nothing is drawn.
        T: where it would be in the world.
        as_checked: whether the robot is drawn as it is checked for collisions.
    """
    match thing:
        case "bin":
            regions = enumerate(cell.bin.regions)
            return {"/bin": T} | {f"/regions/{k}": T * region.T_bin_region for k, region in regions}
        case "scanner":
            return {"/scanner": T}
        case "robot":
            # Its links are drawn where they are in the world.
            root = ROBOT_CHECKED if as_checked else DRAWN_ROBOT
            return {root: T * cell.T_world_robot.inverse()}
        case _:
            if any(fixture.name == thing for fixture in cell.fixtures):
                on_it = (station for station in cell.stations if station.fixture == thing)
                stations = {
                    f"/stations/{station.name}": T * station.T_base_station for station in on_it
                }
                return {f"/fixtures/{thing}": T} | stations
            names = [name_of_region(region) for region in cell.bin.regions]
            return {f"/regions/{names.index(thing)}": T} if thing in names else {}


def remove_surroundings(scene: viser.SceneApi) -> None:
    """Take away what `add_surroundings` has added."""
    for name in ("/fixtures", "/stations", "/bin", "/regions", "/scanner", "/floor", "/shade"):
        scene.remove_by_name(name)


def show_frames(
    scene: viser.SceneApi, cell: Cell, kinematics: Kinematics, *, is_shown: bool
) -> None:
    """Show or hide the frames that poses in the cell file are about.

    Where parts have to lie there is one, the first kind that may.
    """
    scene.remove_by_name("/frames")
    if not is_shown:
        return
    frames = {"world": pin.SE3.Identity(), "robot": cell.T_world_robot}
    frames |= {"bin": cell.bin.T_world_bin, "scanner": cell.scanner.T_world_scanner}
    frames |= {fixture.name: fixture.T_world_fixture for fixture in cell.fixtures}
    links = kinematics.link_poses({})
    lie: dict[str, Part] = {}
    for arm in cell.arms:
        frames[f"{arm.name} tcp at home"] = links[arm.flange] * arm.tool.T_flange_tcp
        for number, T in enumerate(arm.Ts_world_place, start=1):
            frames[f"{arm.name} place {number}"] = T
        for number, wanted in enumerate(arm.part_places, start=1):
            label = f"{arm.name} part-place {number}"
            frames[label] = wanted.T_world_part
            part = next((part for part in cell.parts if wanted.is_for(part.name)), None)
            if part is not None:
                lie[label] = part
    for number, (label, T) in enumerate(frames.items()):
        node = scene.add_frame(f"/frames/{number}", axes_length=0.06, axes_radius=0.0015)
        place_new(node, T)
        scene.add_label(f"/frames/{number}/label", label, font_screen_scale=0.7)
        if label in lie:
            mesh = lie[label].mesh
            scene.add_mesh_simple(
                f"/frames/{number}/part",
                np.array(mesh.points),
                np.array(mesh.triangles),
                color=LIES,
                opacity=0.4,
                side="double",
            )


def add_light(scene: viser.SceneApi) -> None:
    """Light from above and some from all sides, before anything is there that it falls on.

    Where no graphics processor draws, the map of an environment takes some ten seconds of all
    processors at the first picture; shadows take a third of the rest.
    """
    scene.configure_environment_map(None)
    scene.configure_default_lights(cast_shadow=False)
    scene.add_light_hemisphere(
        "/light", sky_color=SKY_LIGHT, ground_color=FLOOR_LIGHT, intensity=FILL, position=UP
    )


def paint_background(scene: viser.SceneApi, *, is_dark: bool = False) -> None:
    """A soft sky, so that white robots stand out."""
    shares = np.linspace(0.0, 1.0, 64)[:, None, None]
    top, bottom = (np.array(rgb_of(colour)) for colour in (NIGHT_SKY if is_dark else SKY))
    gradient = (1 - shares) * top + shares * bottom
    scene.set_background_image(np.repeat(gradient, 8, axis=1).astype(np.uint8), "png")


def aim_camera(server: viser.ViserServer, cell: Cell) -> None:
    """Have every browser begin with the first look at a cell."""
    position, centre = first_look(cell)
    camera = server.initial_camera
    camera.position, camera.look_at = position, centre
    camera.up, camera.fov = (0.0, 0.0, 1.0), FIELD_OF_VIEW


def first_look(cell: Cell) -> tuple[Floats, Floats]:
    """Robot, bin, places and scanner from in front, from the side and from above.

    Returns:
        Position of the camera and the point it looks at, each (3,) [m] in the world.
    """
    return frame_camera(interesting_points(cell), look_direction(cell), FIELD_OF_VIEW, ASPECT)


def look_direction(cell: Cell) -> Floats:
    """The unit vector (3,) from a cell to where it is seen from first."""
    robot, goal = cell.T_world_robot.translation, cell.bin.T_world_bin.translation
    azimuth = math.atan2(goal[1] - robot[1], goal[0] - robot[0]) - math.radians(38)
    direction = np.array([math.cos(azimuth), math.sin(azimuth), 0.6])
    return direction / np.linalg.norm(direction)


def interesting_points(cell: Cell) -> Floats:
    """Points (n, 3) [m] in the world frame that a first look should hold."""
    length, width, height = cell.bin.size
    corners = [
        cell.bin.T_world_bin.act(np.array([x * length / 2, y * width / 2, z * height]))
        for x, y, z in itertools.product((-1, 1), (-1, 1), (0, 1))
    ]
    Ts = [T for arm in cell.arms for T in arm.Ts_world_place]
    Ts += [part_place.T_world_part for arm in cell.arms for part_place in arm.part_places]
    places = [T.translation + beside for T in Ts for beside in SURROUNDING_POINTS]
    links = [T.translation for T in Kinematics(cell).link_poses({}).values()]
    return np.array([*corners, *places, *links, cell.scanner.T_world_scanner.translation])


def frame_camera(
    points: Floats, direction: Floats, field_of_view: float, aspect: float
) -> tuple[Floats, Floats]:
    """From where a camera holds all points, as near as that goes.

    Args:
        points: shape (n, 3) [m].
        direction: unit vector (3,) from what is viewed to the camera, not vertical.
        field_of_view: vertical [rad].
        aspect: width by height of the picture.

    Returns:
        Position of the camera and the point it looks at, each (3,) [m].
    """
    right = np.cross([0.0, 0.0, 1.0], direction)
    right /= np.linalg.norm(right)
    up = np.cross(direction, right)
    axes = np.stack([right, up, direction])
    inside = points @ axes.T
    centre = (inside.min(axis=0) + inside.max(axis=0)) / 2
    across, upwards = np.abs(inside - centre)[:, :2].T
    nearer = (inside - centre)[:, 2]
    tangent = math.tan(field_of_view / 2) * FILLED
    distance = float(np.max(nearer + np.maximum(upwards / tangent, across / (tangent * aspect))))
    target = centre @ axes
    return target + distance * direction, target
