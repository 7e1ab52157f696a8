"""One arm as plain arrays, and the compiled loops over it: forward and inverse kinematics.

Inverse kinematics is damped least squares (Nakamura and Hanafusa 1986) with the damping tied
to the remaining error (Sugihara 2011); steps clipped to the joint limits, and many starting
points: a seven-axis arm has a one-parameter family of answers, and which of them is taken is
decided later, by clearance and travel.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Bools, Floats
from workbench.planning.compiled import njit_in_place

POSITION_TOLERANCE = 1e-6
ROTATION_TOLERANCE = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Chain:
    """An arm from the world to its TCP.

    `R` (n+1, 3, 3), `p` (n+1, 3) [m]: the fixed transform before each joint, and last the one
    from the last joint to the TCP.  `axes` (n, 3), `slides` (n,) 1.0 for prismatic joints.
    `lower`, `upper` (n,) [rad]: the joint limits as far as they can be sent (`MotionModel.limits`);
    `velocity` (n,) [rad/s], `acceleration` (n,) [rad/s2], `jerk` (n,) [rad/s3]: the largest that
    the joints have; without `jerk` acceleration may jump.
    """

    R: Floats
    p: Floats
    axes: Floats
    slides: Floats
    lower: Floats
    upper: Floats
    velocity: Floats
    acceleration: Floats
    jerk: Floats | None = None

    @property
    def arrays(self) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
        """What compiled code needs of it: `R`, `p`, `axes`, `slides`, `lower`, `upper`."""
        return self.R, self.p, self.axes, self.slides, self.lower, self.upper

    def pose(self, q: Floats) -> pin.SE3:
        """`T_world_tcp` at `q` (n,) [rad]."""
        n = len(self.axes)
        R, p, z, o = np.empty((3, 3)), np.empty(3), np.empty((n, 3)), np.empty((n, 3))
        forward(self.R, self.p, self.axes, self.slides, np.array(q), R, p, z, o)
        return pin.SE3(R, p)

    def joint_positions(self, q: Floats) -> Floats:
        """Where the joints are in the world at `q` (n,) [rad], shape (n, 3)."""
        n = len(self.axes)
        R, p, z, o = np.empty((3, 3)), np.empty(3), np.empty((n, 3)), np.empty((n, 3))
        forward(self.R, self.p, self.axes, self.slides, np.array(q), R, p, z, o)
        return o

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
        return solve_from_starts(
            *self.arrays,
            np.ascontiguousarray(T_world_tcp.rotation),
            np.ascontiguousarray(T_world_tcp.translation),
            # A copy can be written to: read-only arrays would be compiled for once more.
            np.array(np.atleast_2d(starts), order="C"),
            iterations,
        )


def is_solution(residuals: Floats) -> Bools:
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
    lower, upper, velocity = cell.robot.limits(tuple(names))
    limits = (*cell.controller.motion.limits(lower, upper), velocity, np.array(arm.acceleration))
    jerk = None if arm.jerk is None else np.array(arm.jerk)
    return Chain(np.array(R), np.array(p), np.array(axes), np.array(slides), *limits, jerk)


# The loops below index into whole arrays instead of passing rows: a slice costs an allocation,
# and they run for every starting point of every candidate.  Inverse kinematics by the joints of
# `bounds.joint_pose`, which serve the whole robot, takes half as long again.


@njit_in_place
def forward(
    Rs: Floats,
    ps: Floats,
    axes: Floats,
    slides: Floats,
    q: Floats,
    R: Floats,
    p: Floats,
    z: Floats,
    o: Floats,
) -> None:
    """Write TCP rotation R (3, 3) and position p (3,) [m], axes z and origins o (n, 3)."""
    for i in range(3):
        p[i] = ps[0, i]
        for k in range(3):
            R[i, k] = Rs[0, i, k]
    for j in range(len(q)):
        x, y, w = axes[j, 0], axes[j, 1], axes[j, 2]
        for i in range(3):
            z[j, i] = R[i, 0] * x + R[i, 1] * y + R[i, 2] * w
            o[j, i] = p[i]
        if slides[j] > 0.5:
            for i in range(3):
                p[i] += z[j, i] * q[j]
        else:
            sin, cos = np.sin(q[j]), np.cos(q[j])
            d = 1.0 - cos
            t00, t01, t02 = cos + x * x * d, x * y * d - w * sin, x * w * d + y * sin
            t10, t11, t12 = y * x * d + w * sin, cos + y * y * d, y * w * d - x * sin
            t20, t21, t22 = w * x * d - y * sin, w * y * d + x * sin, cos + w * w * d
            for i in range(3):
                a, b, e = R[i, 0], R[i, 1], R[i, 2]
                R[i, 0] = a * t00 + b * t10 + e * t20
                R[i, 1] = a * t01 + b * t11 + e * t21
                R[i, 2] = a * t02 + b * t12 + e * t22
        n = j + 1
        for i in range(3):
            a, b, e = R[i, 0], R[i, 1], R[i, 2]
            p[i] += a * ps[n, 0] + b * ps[n, 1] + e * ps[n, 2]
            for k in range(3):
                R[i, k] = a * Rs[n, 0, k] + b * Rs[n, 1, k] + e * Rs[n, 2, k]


@njit_in_place
def _along(R: Floats, row: int, x: float, y: float, z: float) -> float:
    """The product of a row of R (3, 3) and (x, y, z)."""
    return float(x * R[row, 0] + y * R[row, 1] + z * R[row, 2])


@njit_in_place
def _rotation_error(target: Floats, R: Floats, e: Floats) -> None:
    """Write into e[3:6] the rotation vector, in the world frame, that takes R to the target."""
    a, b, g = target[0, 0], target[0, 1], target[0, 2]
    e00, e01, e02 = _along(R, 0, a, b, g), _along(R, 1, a, b, g), _along(R, 2, a, b, g)
    a, b, g = target[1, 0], target[1, 1], target[1, 2]
    e10, e11, e12 = _along(R, 0, a, b, g), _along(R, 1, a, b, g), _along(R, 2, a, b, g)
    a, b, g = target[2, 0], target[2, 1], target[2, 2]
    e20, e21, e22 = _along(R, 0, a, b, g), _along(R, 1, a, b, g), _along(R, 2, a, b, g)
    x, y, w = e21 - e12, e02 - e20, e10 - e01
    s = np.sqrt(x * x + y * y + w * w)
    c = e00 + e11 + e22 - 1.0
    if s < 1e-9 and c < 0:
        # Half a turn: the axis is the column of E + 1 with the largest diagonal entry.
        if e00 >= e11 and e00 >= e22:
            x, y, w = e00 + 1.0, e10, e20
        elif e11 >= e22:
            x, y, w = e01, e11 + 1.0, e21
        else:
            x, y, w = e02, e12, e22 + 1.0
        scale = np.pi / np.sqrt(x * x + y * y + w * w)
    else:
        scale = np.arctan2(s, c) / s if s >= 1e-9 else 0.5
    e[3], e[4], e[5] = x * scale, y * scale, w * scale


@njit_in_place
def _damped_step(
    J: Floats, e: Floats, scale: float, damping: float, L: Floats, y: Floats, step: Floats
) -> None:
    """Write step = J^T (J J^T + damping)^-1 (e * scale), by Cholesky."""
    n = J.shape[1]
    for i in range(6):
        for j in range(i + 1):
            s = damping if i == j else 0.0
            for k in range(n):
                s += J[i, k] * J[j, k]
            for k in range(j):
                s -= L[i, k] * L[j, k]
            L[i, j] = np.sqrt(max(s, 1e-18)) if i == j else s / L[j, j]
    for i in range(6):
        s = e[i] * scale
        for k in range(i):
            s -= L[i, k] * y[k]
        y[i] = s / L[i, i]
    for i in range(5, -1, -1):
        s = y[i]
        for k in range(i + 1, 6):
            s -= L[k, i] * y[k]
        y[i] = s / L[i, i]
    for k in range(n):
        step[k] = 0.0
        for i in range(6):
            step[k] += J[i, k] * y[i]


@njit_in_place
def _jacobian(p: Floats, z: Floats, o: Floats, slides: Floats, J: Floats) -> None:
    """Write the geometric Jacobian (6, n) of the TCP in the world frame."""
    for i in range(len(slides)):
        x, y, w = p[0] - o[i, 0], p[1] - o[i, 1], p[2] - o[i, 2]
        turns = slides[i] < 0.5
        J[0, i] = z[i, 1] * w - z[i, 2] * y if turns else z[i, 0]
        J[1, i] = z[i, 2] * x - z[i, 0] * w if turns else z[i, 1]
        J[2, i] = z[i, 0] * y - z[i, 1] * x if turns else z[i, 2]
        for k in range(3):
            J[3 + k, i] = z[i, k] if turns else 0.0


@njit(cache=True)
def solve_from_starts(
    Rs: Floats,
    ps: Floats,
    axes: Floats,
    slides: Floats,
    lower: Floats,
    upper: Floats,
    R_t: Floats,
    p_t: Floats,
    starts: Floats,
    iterations: int,
) -> tuple[Floats, Floats]:
    """See `Chain.solve`: its `arrays`, then the target's rotation (3, 3) and position (3,) [m]."""
    count, n = starts.shape
    found, residuals = np.empty((count, n)), np.empty((count, 2))
    R, p, z, o = np.empty((3, 3)), np.empty(3), np.empty((n, 3)), np.empty((n, 3))
    J, e, q, step = np.empty((6, n)), np.empty(6), np.empty(n), np.empty(n)
    L, y = np.zeros((6, 6)), np.empty(6)
    for s in range(count):
        for i in range(n):
            q[i] = min(max(starts[s, i], lower[i]), upper[i])
        best = np.inf
        stalled = 0
        for _ in range(iterations + 1):
            forward(Rs, ps, axes, slides, q, R, p, z, o)
            for i in range(3):
                e[i] = p_t[i] - p[i]
            _rotation_error(R_t, R, e)
            off = np.sqrt(e[0] ** 2 + e[1] ** 2 + e[2] ** 2)
            turned = np.sqrt(e[3] ** 2 + e[4] ** 2 + e[5] ** 2)
            total = off + 0.2 * turned
            stalled = 0 if total < 0.98 * best else stalled + 1
            if total < best:
                best = total
                residuals[s, 0], residuals[s, 1] = off, turned
                for i in range(n):
                    found[s, i] = q[i]
            done = off < POSITION_TOLERANCE * 0.1 and turned < ROTATION_TOLERANCE * 0.1
            if done or stalled > 8:
                break
            # Far from the goal, a shortened goal keeps the linear model honest.
            scale = min(1.0, 0.2 / max(off, 1e-12), 0.8 / max(turned, 1e-12))
            damping = 1e-3 * min(total * total, 1.0) + 1e-9
            _jacobian(p, z, o, slides, J)
            _damped_step(J, e, scale, damping, L, y, step)
            blocked = False
            for i in range(n):
                # A joint at its limit that would leave it cannot help: take its column out.
                if (q[i] <= lower[i] and step[i] < 0) or (q[i] >= upper[i] and step[i] > 0):
                    blocked = True
                    for k in range(6):
                        J[k, i] = 0.0
            if blocked:
                _damped_step(J, e, scale, damping, L, y, step)
            for i in range(n):
                q[i] = min(max(q[i] + step[i], lower[i]), upper[i])
    return found, residuals
