"""Plain parts that lie on the floor, and a hand above them whose fingers close level."""

import numpy as np
import pinocchio as pin

from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Tool
from workbench.model.geometry import Box, Cylinder, Mesh, Shape, Solid, Sphere
from workbench.model.part import GraspLibrary, Part
from workbench.model.symmetry import Symmetry
from workbench.perception.views.surfaces import triangles_of

DOWN = np.diag([1.0, -1.0, -1.0])
"""The hand's turn: its z down, its closing axis y along the world's."""


def hand() -> Tool:
    """Two boxes 10 mm wide, which close along y of the TCP."""
    return read_cell("yumi").arms[0].tool


def plain(shape: Shape, symmetry: Symmetry | None = None, mass: float = 0.1) -> Part:
    """A part that is one piece."""
    surface = triangles_of(shape)
    return Part(
        "plain",
        Mesh(np.asarray(surface.vertices), np.asarray(surface.faces)),
        (Solid("piece", shape, pin.SE3.Identity()),),
        mass,
        symmetry or Symmetry(),
        GraspLibrary(),
    )


def brick(width: float) -> tuple[Part, pin.SE3]:
    """As wide between the fingers, and how it lies."""
    return plain(Box(np.array([0.06, width, 0.02]))), pin.SE3(np.eye(3), np.array([0, 0, 0.01]))


def ball(radius: float) -> tuple[Part, pin.SE3]:
    """And how it lies."""
    return plain(Sphere(radius)), pin.SE3(np.eye(3), np.array([0, 0, radius]))


def rod(radius: float) -> tuple[Part, pin.SE3]:
    """A cylinder on its side, across the way of the fingers."""
    T = pin.SE3(pin.rpy.rpyToMatrix(0, np.pi / 2, 0), np.array([0.0, 0.0, radius]))
    return plain(Cylinder(radius, 0.06)), T


def tcp_over(T_world_part: pin.SE3, along: float = 0.0) -> pin.SE3:
    """The hand straight above: tips 3 mm below the middle, moved along x by so many metres."""
    return pin.SE3(DOWN, T_world_part.translation + np.array([along, 0.0, -0.003]))


def off_by(T_world_tcp: pin.SE3, T_world_part: pin.SE3, error: np.ndarray) -> pin.SE3:
    """The hand, when the part lies off by an error (6,) [m, rad] at the TCP and along its axes."""
    T_tcp_part = T_world_tcp.actInv(T_world_part)
    T_tcp_off = pin.SE3(pin.exp3(error[3:]), error[:3]) * T_tcp_part
    return T_world_part * T_tcp_off.inverse()
