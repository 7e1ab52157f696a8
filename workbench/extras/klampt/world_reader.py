"""Klamp't worlds (`.xml`): a robot, and what stands around it.

Source: https://github.com/krishauser/Klampt, manual, "File types"
"""

import math
import re
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.extras.klampt.robots import read_rob
from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import is_file, read_whole
from workbench.formats.files.xml_elements import Element, read_xml
from workbench.formats.meshes.reading import LARGEST_MESH, read_mesh
from workbench.formats.robots.in_place import RobotInPlace
from workbench.formats.robots.urdf import read_urdf
from workbench.model.cell import Fixture
from workbench.model.errors import FileError
from workbench.model.geometry import Mesh, Solid

BLUE, BROWN = (0.4, 0.4, 1.0), (0.8, 0.6, 0.3)
"""What Klamp't gives rigid objects and terrains that say nothing."""


def read_klampt_world(path: Path) -> RobotInPlace:
    """A world with exactly one robot.

    Raises:
        FileError: not such a file, another number of robots, or a file in it cannot be read.
    """
    root = read_xml(path, "world")
    robots = list(root.all("robot"))
    if len(robots) != 1:
        raise FileError(path, f"has {len(robots)} robots, one is expected")
    file = _beside(robots[0], "file")
    robot = read_urdf(file) if file.suffix.lower() == ".urdf" else read_rob(file)
    things = [_thing(user, BLUE, k) for k, user in enumerate(root.all("rigidObject"))]
    things += [_thing(user, BROWN, k) for k, user in enumerate(root.all("terrain"))]
    names = [thing.name for thing in things]
    for name in names:
        if names.count(name) > 1:
            raise FileError(path, f"two things are called {quote(name)}")
    return RobotInPlace(robot, _read_pose(robots[0]), tuple(things))


def _thing(element: Element, usual: tuple[float, float, float], number: int) -> Fixture:
    name = re.sub(r"[^A-Za-z0-9_-]", "_", element.text("name", f"{element.tag}_{number + 1}"))
    geometry = element.one("geometry")
    display = element.one("display") or element.one("appearance")
    colour = usual
    if display is not None and display.text("color", ""):
        count = 4 if len(display.text("color").split()) == 4 else 3
        red, green, blue = np.clip(display.numbers("color", count), 0, 1).tolist()[:3]
        colour = (red, green, blue)
    if geometry is not None:
        key = "file" if geometry.text("file", "") else "mesh"
        mesh = _scale(_mesh(_beside(geometry, key)), geometry)
    else:
        mesh = _scale(_mesh(_beside(element, "file")), element)
    solid = Solid(f"{name}_mesh", mesh, pin.SE3.Identity(), colour)
    return Fixture(name, _read_pose(element), (solid,))


def _mesh(path: Path) -> Mesh:
    """A mesh file, or the mesh that a rigid object file names."""
    if path.suffix.lower() != ".obj":
        return read_mesh(path)
    content = read_whole(path, LARGEST_MESH).decode("utf-8", errors="replace")
    named = re.search(r"^\s*(?:mesh|geomfile)\s+(\S.*)$", content, re.MULTILINE)
    if named is None:
        return read_mesh(path)
    mesh = read_mesh(path.parent / named[1].strip().strip('"'))
    scale = re.search(r"^\s*geomscale\s+(\S.*?)\s*$", content, re.MULTILINE)
    return Mesh(mesh.points * _factor(path, scale[1] if scale else "1"), mesh.triangles)


def _factor(path: Path, text: str) -> float:
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if not 0 < factor < math.inf:
        raise FileError(path, f"geomscale: {quote(text)} is not a positive number")
    return factor


def _scale(mesh: Mesh, element: Element) -> Mesh:
    words = len(element.text("scale", "1").split())
    scale = element.numbers("scale", 3 if words == 3 else 1, (1.0,))
    shift = element.numbers("translate", 3, (0.0, 0.0, 0.0))
    if np.any(scale <= 0):
        raise element.error("scale: must be positive")
    return Mesh(np.asarray(mesh.points) * scale + shift, mesh.triangles)


def _read_pose(element: Element) -> pin.SE3:
    """Position and turns, one after the other, of a thing in the world."""
    p = element.numbers("position", 3, (0.0, 0.0, 0.0))
    if element.text("translation", ""):
        p = element.numbers("translation", 3)
    R = np.eye(3)
    for axis, key in enumerate(("rotateX", "rotateY", "rotateZ")):
        angle = element.number(key, 0.0)
        R = pin.rpy.rpyToMatrix(*(angle if k == axis else 0.0 for k in range(3))) @ R
    roll, pitch, yaw = element.numbers("rotateRPY", 3, (0.0, 0.0, 0.0))
    R = pin.rpy.rpyToMatrix(roll, pitch, yaw) @ R
    R = pin.exp3(element.numbers("rotateMoment", 3, (0.0, 0.0, 0.0))) @ R
    if np.abs(p).max() > 1e3:
        raise element.error("position: metres are expected")
    return pin.SE3(R, p)


def _beside(element: Element, key: str) -> Path:
    name = element.text(key)
    file = element.path.parent / name
    if not is_file(file):
        raise element.error(f"{key}={quote(name)}: the folder of the world has no such file")
    return file
