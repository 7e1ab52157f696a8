"""An arm by its Denavit-Hartenberg table: joints, and capsules instead of what it looks like.

Standard: row k leads from frame k-1 to frame k: rotate by theta about z, shift by d along z, shift
by a along x, rotate by alpha about x.  Modified: alpha and a come first, about the previous x.

Source: J. Denavit and R. S. Hartenberg, "A kinematic notation for lower-pair mechanisms based on
matrices", Journal of Applied Mechanics 22, 1955; J. J. Craig, "Introduction to Robotics", 1986.
"""

import math
from itertools import pairwise

import numpy as np
import pinocchio as pin

from workbench.formats.files.toml_keys import Table
from workbench.model.geometry import Capsule, Solid, Sphere
from workbench.model.robot import Joint, Link, Robot

REACH_MM = 10_000.0
Z = np.array([0.0, 0.0, 1.0])


def read_dh(table: Table, name: str) -> Robot:
    """A robot from a table with `convention`, `radius_mm`, and `[[joint]]` rows.

    Each row has `alpha_deg`, `a_mm`, `d_mm`, `theta_deg`, `kind`, its range in `range_deg` or
    `range_mm`, and `speed_deg` or `speed_mm` per second.  Links are `base`, `link_1` ... and
    `flange`; what is checked are capsules along each link, `radius_mm` thick.
    """
    is_standard = table.text("convention", among=("standard", "modified")) == "standard"
    radius = table.number("radius_mm", 60, low=1, high=1000) / 1000
    joints: list[Joint] = []
    after = pin.SE3.Identity()  # what is left of the row before, once its joint has moved
    parent = "base"
    rows = list(table.tables("joint"))
    if not rows:
        raise table.error("joint", "at least one [[joint]] is needed")
    for number, row in enumerate(rows, start=1):
        along, across = _row(row)
        child = f"link_{number}"
        before = after if is_standard else after * across
        joints.append(_joint(row, f"joint_{number}", parent, child, before * _turn(row)))
        after = _shift(along) * across if is_standard else _shift(along)
        parent = child
        row.finish()
    joints.append(Joint("flange_mount", "fixed", parent, "flange", after, Z))
    table.finish()
    links = [Link("base"), *(_link(joints, k, radius) for k in range(len(rows))), Link("flange")]
    neighbours = frozenset(tuple(sorted((j.parent, j.child))) for j in joints)
    near = frozenset(
        tuple(sorted((first.parent, second.child)))
        for first, second in pairwise(joints)
        if np.linalg.norm(second.T_parent_joint.translation) < 2 * radius
    )
    return Robot(name, tuple(links), tuple(joints), neighbours | near)  # type: ignore[arg-type]


def _row(row: Table) -> tuple[float, pin.SE3]:
    """The shift d along z [m], and the shift a along and the turn alpha about x."""
    alpha = math.radians(row.number("alpha_deg", 0, low=-360, high=360))
    a = row.number("a_mm", 0, low=-REACH_MM, high=REACH_MM) / 1000
    d = row.number("d_mm", 0, low=-REACH_MM, high=REACH_MM) / 1000
    return d, pin.SE3(pin.rpy.rpyToMatrix(alpha, 0.0, 0.0), np.array([a, 0.0, 0.0]))


def _turn(row: Table) -> pin.SE3:
    theta = math.radians(row.number("theta_deg", 0, low=-360, high=360))
    return pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, theta), np.zeros(3))


def _shift(d: float) -> pin.SE3:
    return pin.SE3(np.eye(3), d * Z)


def _joint(row: Table, name: str, parent: str, child: str, T: pin.SE3) -> Joint:
    if row.text("kind", "revolute", among=("revolute", "prismatic")) == "revolute":
        low, high = np.deg2rad(row.numbers("range_deg", 2, low=-720, high=720))
        speed = math.radians(row.number("speed_deg", low=0.1, high=5000))
        kind = "revolute"
    else:
        low, high = row.numbers("range_mm", 2, low=-REACH_MM, high=REACH_MM) / 1000
        speed = row.number("speed_mm", low=0.1, high=50_000) / 1000
        kind = "prismatic"
    if not low < high:
        raise row.error("range_deg" if kind == "revolute" else "range_mm", "must be [least, most]")
    return Joint(name, kind, parent, child, T, Z, float(low), float(high), speed)


def _link(joints: list[Joint], number: int, radius: float) -> Link:
    """A capsule from where the link hangs to where the next joint is, a ball when that is near.

    That of the first link begins above the foot: the robot stands on something.
    """
    name = joints[number].child
    p = joints[number + 1].T_parent_joint.translation
    above = 1.5 * radius / max(float(np.linalg.norm(p)), 1e-9)
    start = p * min(1.0, above) if number == 0 else 0 * p
    middle, length = (start + p) / 2, float(np.linalg.norm(p - start))
    if length < radius:
        solid = Solid(f"{name}_0", Sphere(radius), pin.SE3(np.eye(3), middle))
    else:
        out = p / float(np.linalg.norm(p))
        yaw, pitch = math.atan2(out[1], out[0]), math.acos(float(np.clip(out[2], -1.0, 1.0)))
        R = pin.rpy.rpyToMatrix(0.0, pitch, yaw)
        solid = Solid(f"{name}_0", Capsule(radius, length), pin.SE3(R, middle))
    return Link(name, (solid,), (solid,))
