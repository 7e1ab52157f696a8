"""A body: one shape, and what carries it."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Capsule, Cylinder, Shape, Sphere
from workbench.proof.engine.robot import Tree

Kind = Literal["link", "tool", "still", "part"]


@dataclass(frozen=True, slots=True, eq=False)
class CheckedBody:
    """One shape.

    `label` is what people read, `name` what it is part of: two bodies of one name are never
    compared.  `arm` carries it, empty where none does.  `part` is the number of the detection, -1
    for what is none.  `joint` and `T_joint_body`: where it hangs as long as no hand holds it.
    `is_rolled`: it is the room of a piece of a part at every turn, since its roll is not known.
    `of_kind`: the kind of part that it is a piece of, found or assembled; empty for what is none.
    `fixture`: the one that it is of, or the tool in its slot.  `is_solid`: it is of the bin or of a
    fixture, and stands for nothing else.
    """

    kind: Kind
    label: str
    name: str
    arm: str
    part: int
    joint: int
    T_joint_body: pin.SE3
    shape: Shape
    is_finger: bool = False
    is_rolled: bool = False
    of_kind: str = ""
    fixture: str = ""
    is_solid: bool = False


def is_round(body: CheckedBody, tree: Tree) -> bool:
    """Whether a body fills the same space however its joint is turned: a flange on its axis."""
    joint = tree.joints.get(body.joint)
    if joint is None or joint.kind != "revolute":
        return False
    if not isinstance(body.shape, Sphere | Cylinder | Capsule):
        return False
    R, at = body.T_joint_body.rotation, body.T_joint_body.translation
    is_alike = (
        isinstance(body.shape, Sphere) or np.linalg.norm(np.cross(joint.axis, R[:, 2])) < 1e-9
    )
    return bool(is_alike and np.linalg.norm(np.cross(joint.axis, at)) < 1e-9)
