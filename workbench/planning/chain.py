"""One arm as plain arrays, and the compiled loops over it: forward and inverse kinematics.

Inverse kinematics is damped least squares (Nakamura and Hanafusa 1986) with the damping tied
to the remaining error (Sugihara 2011), steps clipped to the joint limits, and many starting
points: a seven-axis arm has a one-parameter family of answers, and which of them is taken is
decided later, by clearance and travel.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats

POSITION_TOLERANCE = 1e-6
ROTATION_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """An arm from the world to its TCP.

    `R` (n+1, 3, 3), `p` (n+1, 3): the fixed transform before each joint, and last the one from
    the last joint to the TCP.  `axes` (n, 3), `slides` (n,) 1.0 for prismatic joints.
    """

    R: Floats
    p: Floats
    axes: Floats
    slides: Floats
    lower: Floats
    upper: Floats

    def pose(self, q: Floats) -> pin.SE3:
        """`T_world_tcp` at `q` (n,) [rad]."""
        R, p, _, _ = _forward(self.R, self.p, self.axes, self.slides, np.asarray(q))
        return pin.SE3(R, p)

    def solve(
        self, T_world_tcp: pin.SE3, starts: Floats, *, iterations: int = 40
    ) -> tuple[Floats, Floats]:
        """Answers near each start, inside the limits.

        Args:
            T_world_tcp: where the TCP shall be.
            starts: shape (s, n) [rad].
            iterations: bound for each start.

        Returns:
            Configurations (s, n) and residuals (s, 2) [m, rad]; those within
            `POSITION_TOLERANCE` and `ROTATION_TOLERANCE` are solutions.
        """
        return _solve(
            self.R,
            self.p,
            self.axes,
            self.slides,
            self.lower,
            self.upper,
            np.ascontiguousarray(T_world_tcp.rotation),
            np.ascontiguousarray(T_world_tcp.translation),
            np.ascontiguousarray(np.atleast_2d(starts)),
            iterations,
        )


def is_solution(residuals: Floats) -> Floats:
    """Which rows of residuals (s, 2) [m, rad] are solutions, as booleans (s,)."""
    return (residuals[:, 0] < POSITION_TOLERANCE) & (residuals[:, 1] < ROTATION_TOLERANCE)


def chain_of(cell: Cell, arm: Arm) -> Chain:
    """The arrays of one arm of a cell."""
    R, p, axes, slides, names = [], [], [], [], []
    T = cell.T_world_robot
    for joint in cell.robot.chain(arm.flange):
        T = T * joint.T_parent_joint
        if joint.kind == "fixed":
            continue
        R.append(T.rotation.copy())
        p.append(T.translation.copy())
        axes.append(np.array(joint.axis))
        slides.append(1.0 if joint.kind == "prismatic" else 0.0)
        names.append(joint.name)
        T = pin.SE3.Identity()
    T = T * arm.tool.T_flange_tcp
    R.append(T.rotation.copy())
    p.append(T.translation.copy())
    lower, upper, _ = cell.robot.limits(tuple(names))
    return Chain(np.array(R), np.array(p), np.array(axes), np.array(slides), lower, upper)


@njit(cache=True)
def _rotation(axis: Floats, angle: float) -> Floats:
    x, y, z = axis
    s, c = np.sin(angle), np.cos(angle)
    d = 1.0 - c
    R = np.empty((3, 3))
    R[0, 0], R[0, 1], R[0, 2] = c + x * x * d, x * y * d - z * s, x * z * d + y * s
    R[1, 0], R[1, 1], R[1, 2] = y * x * d + z * s, c + y * y * d, y * z * d - x * s
    R[2, 0], R[2, 1], R[2, 2] = z * x * d - y * s, z * y * d + x * s, c + z * z * d
    return R


@njit(cache=True)
def _product(A: Floats, B: Floats) -> Floats:
    C = np.empty((3, 3))
    for i in range(3):
        for j in range(3):
            C[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]
    return C


@njit(cache=True)
def _turned(A: Floats, v: Floats) -> Floats:
    w = np.empty(3)
    for i in range(3):
        w[i] = A[i, 0] * v[0] + A[i, 1] * v[1] + A[i, 2] * v[2]
    return w


@njit(cache=True)
def _forward(Rs, ps, axes, slides, q):  # type: ignore[no-untyped-def]
    """TCP rotation and position, and each joint's axis and origin in the world."""
    n = len(q)
    R, p = Rs[0].copy(), ps[0].copy()
    z, o = np.empty((n, 3)), np.empty((n, 3))
    for i in range(n):
        z[i] = _turned(R, axes[i])
        o[i] = p
        if slides[i] > 0.5:
            p = p + z[i] * q[i]
        else:
            R = _product(R, _rotation(axes[i], q[i]))
        p = p + _turned(R, ps[i + 1])
        R = _product(R, Rs[i + 1])
    return R, p, z, o


@njit(cache=True)
def _rotation_error(target: Floats, R: Floats) -> Floats:
    """The rotation vector that takes R to the target, in the world frame."""
    E = _product(target, R.T)
    v = np.array([E[2, 1] - E[1, 2], E[0, 2] - E[2, 0], E[1, 0] - E[0, 1]])
    s = np.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    c = E[0, 0] + E[1, 1] + E[2, 2] - 1.0
    if s < 1e-9:
        if c > 0:
            return v * 0.5
        # Half a turn: the axis is the column of E + 1 with the largest diagonal entry.
        k = int(np.argmax(np.array([E[0, 0], E[1, 1], E[2, 2]])))
        axis = E[:, k].copy()
        axis[k] += 1.0
        return axis / np.sqrt(np.sum(axis * axis)) * np.pi
    return v * (np.arctan2(s, c) / s)


@njit(cache=True)
def _damped_step(J: Floats, e: Floats, damping: float) -> Floats:
    """J^T (J J^T + damping)^-1 e by Cholesky."""
    n = J.shape[1]
    L = np.zeros((6, 6))
    for i in range(6):
        for j in range(i + 1):
            s = damping if i == j else 0.0
            for k in range(n):
                s += J[i, k] * J[j, k]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = np.sqrt(max(s, 1e-18)) if i == j else s / L[j, j]
    y = np.empty(6)
    for i in range(6):
        s = e[i]
        for k in range(i):
            s -= L[i, k] * y[k]
        y[i] = s / L[i, i]
    for i in range(5, -1, -1):
        s = y[i]
        for k in range(i + 1, 6):
            s -= L[k, i] * y[k]
        y[i] = s / L[i, i]
    step = np.zeros(n)
    for k in range(n):
        for i in range(6):
            step[k] += J[i, k] * y[i]
    return step


@njit(cache=True)
def _solve(Rs, ps, axes, slides, lower, upper, R_t, p_t, starts, iterations):  # type: ignore[no-untyped-def]
    count, n = starts.shape
    found, residuals = np.empty((count, n)), np.empty((count, 2))
    J, e = np.empty((6, n)), np.empty(6)
    for s in range(count):
        q = np.minimum(np.maximum(starts[s], lower), upper)
        best = np.inf
        stalled = 0
        for _ in range(iterations + 1):
            R, p, z, o = _forward(Rs, ps, axes, slides, q)
            e[:3] = p_t - p
            e[3:] = _rotation_error(R_t, R)
            off = np.sqrt(e[0] ** 2 + e[1] ** 2 + e[2] ** 2)
            turned = np.sqrt(e[3] ** 2 + e[4] ** 2 + e[5] ** 2)
            total = off + 0.2 * turned
            if total < best:
                stalled = stalled + 1 if total > 0.98 * best else 0
                best = total
                found[s] = q
                residuals[s, 0] = off
                residuals[s, 1] = turned
            else:
                stalled += 1
            if (
                off < POSITION_TOLERANCE * 0.1 and turned < ROTATION_TOLERANCE * 0.1
            ) or stalled > 8:
                break
            # Far from the goal, a shortened goal keeps the linear model honest.
            shrink = min(1.0, 0.2 / max(off, 1e-12), 0.8 / max(turned, 1e-12))
            for i in range(n):
                if slides[i] > 0.5:
                    J[:3, i] = z[i]
                    J[3:, i] = 0.0
                else:
                    J[:3, i] = np.cross(z[i], p - o[i])
                    J[3:, i] = z[i]
                # A joint at its limit that would leave it cannot help: take its column out.
            step = _damped_step(J, e * shrink, 1e-3 * min(total * total, 1.0) + 1e-9)
            blocked = False
            for i in range(n):
                if (q[i] <= lower[i] and step[i] < 0) or (q[i] >= upper[i] and step[i] > 0):
                    J[:, i] = 0.0
                    blocked = True
            if blocked:
                step = _damped_step(J, e * shrink, 1e-3 * min(total * total, 1.0) + 1e-9)
            q = np.minimum(np.maximum(q + step, lower), upper)
    return found, residuals
