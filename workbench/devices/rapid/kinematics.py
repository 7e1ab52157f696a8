"""Where the flange of an arm is, and which axes bring it somewhere; degrees, as in RAPID."""

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats

ITERATIONS = 200
DAMPING = 1e-4
CONVERGED_WITHIN = 1e-7
"""[m, rad] A pose is reached within this."""


class Axes:
    """One arm as its controller sees it: axes in the order of the wire, in degrees.

    `lower`, `upper` (n,) [deg], `velocity` (n,) [deg/s], `home` (n,) [deg].
    """

    def __init__(self, cell: Cell, arm: Arm) -> None:
        self._arm = arm
        lower, upper, velocity = cell.robot.limits(arm.joints)
        ends = np.array([self.from_chain(lower), self.from_chain(upper)])
        self.lower, self.upper = ends.min(axis=0), ends.max(axis=0)
        self.velocity = np.abs(self.from_chain(velocity))
        self.home = self.from_chain(np.asarray(arm.home))
        self._chain = cell.robot.chain(arm.flange)
        self._places = {name: k for k, name in enumerate(arm.joints)}

    def from_chain(self, q: Floats) -> Floats:
        """Axes (n,) [deg] of a configuration (n,) [rad] in chain order."""
        return np.rad2deg(self._arm.to_axes(q))

    def to_chain(self, axes: Floats) -> Floats:
        """The configuration (n,) [rad] in chain order of axes (n,) [deg]."""
        return self._arm.from_axes(np.deg2rad(axes))

    def flange(self, axes: Floats) -> pin.SE3:
        """`T_world_flange` [m] at axes (n,) [deg]."""
        q, T = self.to_chain(axes), pin.SE3.Identity()
        for joint in self._chain:
            T = T * joint.T_parent_joint
            if joint.name in self._places:
                value = q[self._places[joint.name]]
                if joint.kind == "revolute":
                    T = T * pin.SE3(pin.exp3(joint.axis * value), np.zeros(3))
                else:
                    T = T * pin.SE3(np.eye(3), joint.axis * value)
        return T

    def reach(self, T_world_flange: pin.SE3, start: Floats) -> Floats | None:
        """Axes (n,) [deg] near `start` (n,) [deg] for a pose; None when none was found.

        Damped least squares (Nakamura and Hanafusa 1986), the Jacobian by differences.
        """
        axes = np.array(start)
        for _ in range(ITERATIONS):
            here = self.flange(axes)
            error = pin.log6(here.actInv(T_world_flange)).vector
            if np.abs(error).max() < CONVERGED_WITHIN:
                return axes
            columns = []
            for k in range(len(axes)):
                moved = np.array(axes)
                moved[k] += 1e-3
                columns.append(pin.log6(here.actInv(self.flange(moved))).vector / 1e-3)
            J = np.array(columns).T
            scale = 1.0 / 57.3**2
            step = J.T @ np.linalg.solve(J @ J.T + DAMPING * scale * np.eye(6), error)
            axes = np.clip(axes + np.clip(step, -10, 10), self.lower, self.upper)
        return None
