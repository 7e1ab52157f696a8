"""Where the flange is for many configurations at once: blend radii are lengths at the flange."""

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats


class Flange:
    """The flange of one arm of turning joints, as its controller counts the axes.

    `lever` [m]: no axis turns the flange about a point farther away; so turns of the axes that add
    up to `a` [rad] move it by at most `lever * a`.
    """

    def __init__(self, cell: Cell, arm: Arm) -> None:
        self._arm, self._chain = arm, cell.robot.chain(arm.flange)
        self._places = {name: k for k, name in enumerate(arm.joints)}
        self.lever = sum(float(np.linalg.norm(j.T_parent_joint.translation)) for j in self._chain)

    def at(self, axes: Floats) -> Floats:
        """Its positions (k, 3) [m] in the robot's frame at axes (k, 6) [rad]."""
        q = np.array([self._arm.from_axes(row) for row in axes])
        turned, position = np.eye(3), np.zeros((len(q), 3))
        for joint in self._chain:
            position = position + turned @ joint.T_parent_joint.translation
            turned = turned @ joint.T_parent_joint.rotation
            if joint.name in self._places:
                turned = turned @ _turns(joint.axis, q[:, self._places[joint.name]])
        return position


def _turns(axis: Floats, angles: Floats) -> Floats:
    """Rotations (k, 3, 3) about a unit axis (3,) by angles (k,) [rad] (Rodrigues)."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    s, c = np.sin(angles)[:, None, None], np.cos(angles)[:, None, None]
    return np.eye(3) + s * across + (1 - c) * (across @ across)
