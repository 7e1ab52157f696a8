"""How far apart two poses of a part are, when poses that look alike count as one."""

import numpy as np
import pinocchio as pin

from workbench.model.part import Part
from workbench.perception.localization.near_symmetry import stated_symmetry


def pose_error(
    part: Part, T_world_true: pin.SE3, T_world_found: pin.SE3, *, roll_known: bool = True
) -> tuple[float, float]:
    """Distance of the middle [m] and turn [rad] between two poses, under the stated symmetry.

    Args:
        part: whose poses; its symmetry says which of them are one.
        T_world_true: one pose.
        T_world_found: the other one.
        roll_known: False leaves the angle about the part's axis out.
    """
    T = T_world_true.actInv(T_world_found)
    axis = np.asarray(part.symmetry.axis)
    middle = (part.mesh.points.min(axis=0) + part.mesh.points.max(axis=0)) / 2
    if part.symmetry.fold == 0 or not roll_known:
        on_axis = axis * float(axis @ middle)
        # The angle by sine and cosine: near zero an arc cosine sees nothing below 1e-8.
        turned = T.rotation @ axis
        tilt = float(np.arctan2(np.linalg.norm(np.cross(axis, turned)), axis @ turned))
        return float(np.linalg.norm(T.act(on_axis) - on_axis)), tilt
    motions = stated_symmetry(part.symmetry)
    turns = [float(np.linalg.norm(pin.log3(T.rotation @ M[:3, :3].T))) for M in motions]
    best = motions[int(np.argmin(turns))]
    return float(np.linalg.norm(T.act(middle) - best[:3, :3] @ middle)), min(turns)
